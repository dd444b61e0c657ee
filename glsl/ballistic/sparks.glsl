/* effect
rate_per_s = 400
life_s = 1.4
acceleration_mps2 = 0 -9.8 0
drag_per_s = 1.6
emitter_m = 0 0.5 0
exposure_s = 0.03
blend = add
*/
// Sparks: thrown up in a cone, or off what was hit, braked by air, drawn as streaks that cool. CPU twin:
// ballistic::cpu::birth.

Birth birth(Who who, vec3 emitter_m) {
    vec4 u = chance(who, 0u);
    precise vec3 v = (direction_of(u.xy) * vec3(0.45, 0.3, 0.45) + vec3(0.0, 0.9, 0.0)) * (5.0 + 6.0 * u.z);
    return Birth(emitter_m, away(v), 0.0);
}

Look look(Who who, inout Flight f) {
    float heat = 1.0 - f.share;
    vec3 glow = vec3(2.4, 1.5 * heat, 0.7 * heat * heat) * heat;
    return Look(vec2(0.012 * effect.size, 0.0), 0.0, vec4(glow, 0.0), true);
}
