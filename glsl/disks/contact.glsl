// What two disks that overlap do. CPU twins: `way`, `contact`, `strike` of disks::cpu::Disks.
#include "common/random.glsl"

struct Contact {
    bool collides;
    float ago_s;   // how long before the end of the step they met
    vecd normal;   // from the first to the second
};

// Unit vector along d; where centres coincide, an axis of the ids.
vecd axis_of(vecd d, float reach_m, uint id, uint other_id) {
    float far = length(d);
    if (far > 1e-6 * reach_m) return d / far;
    vec4 units = random_units(random_bits(min(id, other_id), max(id, other_id), 0u, 0u));
#if DIMENSIONS == 2
    vec2 axis = cos_sin_of_turn(units.x);
#else
    vec3 axis = direction_of(units.xy);
#endif
    return id < other_id ? axis : -axis;
}

// d: from the first to the second, nearer than `reach_m`; u: how fast the second leaves the first. With `rewinds` they
// meet where |d - u t| = reach_m, by the root that does not cancel. Who overlapped before this step collides now, if they
// come nearer still. Seen from the other, d and u change sign, and nothing else does, to the bit.
Contact contact_of(vecd d, vecd u, float reach_m, uint id, uint other_id, bool rewinds) {
    if (rewinds) {
        float a = dot(u, u), b = dot(d, u), c = dot(d, d) - reach_m * reach_m;
        float s = sqrt(max(b * b - a * c, 0.0));
        float ago_s = b > 0.0 ? (b + s) / a : -c / max(s - b, 1e-30);
        if (ago_s <= p.dt_s) return Contact(true, ago_s, (d - u * ago_s) / reach_m);
    }
    vecd normal = axis_of(d, reach_m, id, other_id);
    return Contact(dot(normal, u) < 0.0, 0.0, normal);
}

// Impulse on the second, and minus it on the first, along the normal: two elastic bodies.
float impulse_of(float mass, float other_mass, vecd normal, vecd u) {
    return -2.0 * dot(normal, u) * (mass * other_mass / (mass + other_mass));
}
