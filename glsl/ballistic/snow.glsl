/* effect
rate_per_s = 700
life_s = 12
acceleration_mps2 = 0 -1.1 0    # with the drag: 1.1 m/s down in the end
drag_per_s = 1
emitter_m = 0 10 0
blend = over
ground = 1
*/
// Snow that sways as it falls, and melts where it lands. CPU twin: ballistic::cpu::birth, sway.

Birth birth(Who who, vec3 emitter_m) {
    vec4 u = chance(who, 0u);
    precise vec3 at = emitter_m + vec3(30.0 * u.x - 15.0, 0.0, 30.0 * u.y - 15.0);
    precise vec3 v = vec3(0.8 * u.z - 0.4, -1.1, 0.8 * u.w - 0.4);
    return Birth(at, v, 0.0);
}

Look look(Who who, inout Flight f) {
    vec4 u = chance(who, 1u);
    precise float turns = u.x + f.age_s * (0.15 + 0.2 * u.y);
    vec2 way = cos_sin_of_turn(turns - floor(turns));
    precise vec3 swayed = f.at_m + 0.25 * vec3(way.x, 0.0, way.y);
    f.at_m = swayed;
    float melt = f.down_s < 0.0 ? 1.0 : 1.0 - smoothstep(0.0, 2.0, f.down_s);
    float opacity = 0.85 * melt * smoothstep(0.0, 0.05, f.share);
    return Look(vec2(effect.size * (0.02 + 0.02 * u.z)), 0.0, vec4(vec3(opacity), opacity), false);
}
