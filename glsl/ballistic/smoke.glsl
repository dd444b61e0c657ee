/* effect
rate_per_s = 40
life_s = 4
acceleration_mps2 = 0.9 1.6 0   # warm air rises, wind
drag_per_s = 0.9
emitter_m = 0 0.3 0
blend = over
*/
// Smoke that grows and thins as it rises. CPU twin: ballistic::cpu::birth.

Birth birth(Who who, vec3 emitter_m) {
    vec4 u = chance(who, 0u);
    precise vec3 at = emitter_m + vec3(0.5 * u.x - 0.25, 0.0, 0.5 * u.y - 0.25);
    precise vec3 v = direction_of(u.zw) * vec3(0.5, 0.2, 0.5) + vec3(0.0, 1.4, 0.0);
    return Birth(at, v, 0.0);
}

Look look(Who who, inout Flight f) {
    float opacity = 0.4 * smoothstep(0.0, 0.12, f.share) * (1.0 - smoothstep(0.3, 1.0, f.share));
    vec4 u = chance(who, 1u);
    vec2 half_m = vec2(effect.size * (0.25 + 1.35 * sqrt(f.share)));
    vec3 grey = vec3(0.12 + 0.3 * f.share + 0.06 * u.y);
    return Look(half_m, u.x + 0.08 * (u.z - 0.5) * f.age_s, vec4(grey * opacity, opacity), false);
}
