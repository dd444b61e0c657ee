/* effect
rate_per_s = 500            # bursts
burst = 5                   # drops in each: 2500 a second
life_s = 3
acceleration_mps2 = -1 -9.8 0
emitter_m = 0 10 0          # the camera
exposure_s = 0.033
blend = over
ground = 1
*/
// Rain over 70 x 70 m round the camera, from 20 m above it (Luna, 2012, chapter 20), which ends on the ground in a splash.
// CPU twin: ballistic::cpu::birth.

Birth birth(Who who, vec3 emitter_m) {
    vec4 u = chance(who, 0u);
    precise vec3 at = emitter_m + vec3(70.0 * u.x - 35.0, 20.0, 70.0 * u.y - 35.0);
    return Birth(at, vec3(0.0), 0.0);
}

Look look(Who who, inout Flight f) {
    const vec3 WATER = vec3(0.62, 0.7, 0.78);
    const float SPLASH_S = 0.22;
    if (f.down_s >= SPLASH_S) return Look(vec2(0.0), 0.0, vec4(0.0), false);
    if (f.down_s >= 0.0) {
        float part = f.down_s / SPLASH_S, opacity = 0.4 * (1.0 - part);
        f.at_m.y += 0.03;
        return Look(effect.size * vec2(0.05 + 0.16 * part, 0.03 + 0.06 * part), 0.0, vec4(WATER * opacity, opacity), false);
    }
    return Look(vec2(0.012 * effect.size, 0.0), 0.0, vec4(0.5 * WATER, 0.5), true);
}
