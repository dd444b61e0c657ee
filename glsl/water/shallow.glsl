// Water that a face velocity carries (m^2/s): it is as deep as upstream, above the higher ground.
float carried(float velocity, float surface_a, float surface_b, float bed_a, float bed_b) {
    precise float depth = (velocity > 0.0 ? surface_a : surface_b) - max(bed_a, bed_b);
    precise float flow = velocity * max(depth, 0.0);
    return flow;
}
