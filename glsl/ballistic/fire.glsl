/* effect
rate_per_s = 200            # one every 5 ms
life_s = 1
acceleration_mps2 = 0 7.8 0
emitter_m = 0 1 0
blend = add
*/
// A ball of flame (Luna, "Introduction to 3D Game Programming with DirectX 11", 2012, chapter 20). CPU twin:
// ballistic::cpu::birth.

Birth birth(Who who, vec3 emitter_m) {
    precise vec3 v = direction_of(chance(who, 0u).xy) * vec3(2.0, 4.0, 2.0);
    return Birth(emitter_m, v, 0.0);
}

Look look(Who who, inout Flight f) {
    float opacity = 1.0 - smoothstep(0.0, 1.0, f.share);
    vec3 glow = mix(vec3(1.0, 0.62, 0.22), vec3(0.85, 0.16, 0.03), f.share);
    return Look(vec2(1.5 * effect.size), chance(who, 1u).x, vec4(0.2 * opacity * glow, 0.0), false);
}
