// As the sample of 2007 moves its particles: look up the cell that the particle is in, push it out of the plane there,
// reflect its velocity, mixed with the surface's where that comes towards it, then explicit Euler. Kept to be compared with:
// what is fast goes through, what is leaving is turned back, and friction depends on the frame rate.

// Whole step, or one of its parts.
void step_once_as_seed(inout vec3 at_m, inout vec3 velocity_mps, vec3 gravity_mps2, float dt_s, uint part) {
    ivec3 cell = cell_of(law.grid, at_m);
    uint i = in_grid(law.grid, cell) ? cell_index(law.grid, cell) : 0u;
    if (in_grid(law.grid, cell) && is_occupied(i)) {
        Plane plane = plane_of(i, 0u);
        vec3 n = plane.normal, u = plane.velocity_mps;
        precise vec3 from_centre = at_m - cell_centre_m(law.grid, cell);
        precise float d = dotted(n, from_centre) + plane.distance_m;
        precise vec3 seen = velocity_mps - u;
        float approach = dotted(seen, n), speed = sqrt(dotted(u, u));
        if (d < law.radius_m && (method == METHOD_SEED || approach < 0.0)) {
            float towards = speed > 0.0 ? max(dotted(u, n) / speed, 0.0) : 0.0;
            precise vec3 pushed = at_m + n * (law.radius_m - d);
            precise vec3 mirrored = velocity_mps - n * (2.0 * dotted(velocity_mps, n));
            precise vec3 mixed = mirrored * (law.restitution * (1.0 - towards)) + u * towards;
            precise float change = dotted(mixed - velocity_mps, n);
            precise vec3 touch = at_m - n * d;
            append_impact(touch, n, seen, change, plane.triangle, law_slot() * 8u + min(part, 7u), source_now());
            at_m = pushed;
            velocity_mps = mixed;
        }
    }
    precise vec3 at = at_m + velocity_mps * dt_s;
    precise vec3 velocity = velocity_mps + gravity_mps2 * dt_s;
    at_m = at;
    velocity_mps = velocity;
}

void step_as_seed(inout Particle it, float dt_s) {
    vec3 gravity = gravity_mps2();
    uint parts = 1u;
    if (method == METHOD_SUBSTEPS) {
        precise float cells = sqrt(dotted(it.velocity_mps, it.velocity_mps)) * dt_s / law.grid.cell_m;
        parts = uint(clamp(ceil(cells), 1.0, 64.0));
    }
    precise float part_s = dt_s / float(parts);
    vec3 at = it.at_m, velocity = it.velocity_mps;
    for (uint part = 0u; part < parts; ++part) step_once_as_seed(at, velocity, gravity, part_s, part);
    it.at_m = at;
    it.velocity_mps = velocity;
}
