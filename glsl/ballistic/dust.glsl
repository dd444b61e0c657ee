/* effect
rate_per_s = 60
burst = 3
life_s = 0.7
acceleration_mps2 = 0 -0.6 0    # so fine that air carries most of its weight
drag_per_s = 6
emitter_m = 0 0.1 0
blend = over
*/
// Dust: what an impact knocks off. Part of it goes on as the particle would bounce from a mirror, the rest comes off the
// surface, more the harder it was hit; air stops it within a hand's breadth. CPU twin: ballistic::cpu::birth.

Birth birth(Who who, vec3 emitter_m) {
    vec4 u = chance(who, 0u);
    vec3 n = struck.normal, came = struck.velocity_mps;
    precise float into = (came.x * n.x + came.y * n.y) + came.z * n.z;
    precise vec3 mirrored = came - (2.0 * into) * n;
    precise vec3 lobe = direction_of(u.xy) + vec3(0.0, 1.0, 0.0);  // more of it straight off than aslant, by the cosine
    precise float share = 0.1 * u.z * u.z, off_mps = 0.25 + 0.02 * struck.impulse_mps;
    precise vec3 v = share * mirrored + off_mps * away(lobe);
    return Birth(emitter_m, v, 0.0);
}

Look look(Who who, inout Flight f) {
    vec4 u = chance(who, 1u);
    float left = 1.0 - f.share, opacity = 0.16 * left * left;
    vec2 half_m = vec2(effect.size * (0.004 + (0.02 + 0.03 * u.x) * sqrt(f.share)));
    vec3 pale = mix(vec3(0.62, 0.52, 0.38), vec3(0.78, 0.72, 0.62), u.y);
    return Look(half_m, u.z, vec4(pale * opacity, opacity), false);
}
