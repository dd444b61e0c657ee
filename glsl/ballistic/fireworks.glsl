/* effect
rate_per_s = 0.8            # shells
burst = 400                 # sparks of each
life_s = 3.6                # of a shell and its sparks
acceleration_mps2 = 0 -9.8 0
drag_per_s = 0.8
emitter_m = 0 0 0
exposure_s = 0.03
blend = add
*/
// Fireworks, in two stages and without a state: a shell rises for as long as its fuse burns, and where its closed form ends
// that of its sparks begins. CPU twin: ballistic::cpu::birth.
#include "ballistic/path.glsl"


// The first particle of a burst is its flash.
const float FLASH_S = 0.4;
const float FLASH_HALF_M = 2.5;

Birth birth(Who who, vec3 emitter_m) {
    vec4 shell = chance_of_burst(who, 0u), spark = chance(who, 0u);
    precise float fuse_s = 1.3 + 0.4 * shell.x;
    precise vec3 launch = vec3(8.0 * shell.y - 4.0, 24.0 + 4.0 * shell.z, 8.0 * shell.w - 4.0);
    Reach r = reach_of(Wide(fuse_s, 0.0), effect.acceleration.w);
    vec3 at = position(emitter_m, launch, effect.acceleration.xyz, r);
    precise float thrown_mps = who.member == 0u ? 0.0 : 7.0 + 1.5 * spark.z;
    precise vec3 v = velocity(launch, effect.acceleration.xyz, r) + direction_of(spark.xy) * thrown_mps;
    return Birth(at, v, fuse_s);
}

Look look(Who who, inout Flight f) {
    vec3 hue = 0.5 + 0.5 * cos(6.2831853 * (chance_of_burst(who, 1u).x + vec3(0.0, 0.33, 0.67)));
    if (who.member == 0u) {
        float bright = max(1.0 - f.age_s / FLASH_S, 0.0);
        float half_m = bright > 0.0 ? FLASH_HALF_M * effect.size : 0.0;
        return Look(vec2(half_m), 0.0, vec4((0.5 + 0.5 * hue) * (bright * bright), 0.0), false);
    }
    // All sparks begin in one place, where the sum of them would be a hard white disc: they come up as they part, as the
    // area that they share grows, with the square of their age.
    float apart = f.age_s * f.age_s / (f.age_s * f.age_s + 0.3);
    float left = 1.0 - smoothstep(0.35, 1.0, f.share), flicker = 0.6 + 0.4 * cos_sin_of_turn(fract(9.0 * f.share + chance(who, 1u).x)).x;
    vec3 glow = mix(hue, vec3(1.0), exp(-6.0 * f.age_s)) * (6.0 * apart * left * flicker);
    return Look(vec2(0.05 * effect.size, 0.0), 0.0, vec4(glow, 0.0), true);
}
