// Arguments of indirect dispatches and draws.

// Workgroups for `items`, in as many rows as keep a row short: no device allows fewer than 65535 a dimension.
uvec2 groups_of(uint items, uint per_group) {
    uint groups = (items + per_group - 1u) / per_group;
    uint rows = (groups + 65534u) / 65535u;
    return uvec2(rows == 0u ? 0u : (groups + rows - 1u) / rows, max(rows, 1u));
}

// For those who read or draw `slots`.
void tell_readers(uint slots) {
    pool.slots = slots;
    pool.quad_vertices = 6u * slots;
    pool.quad_instances = 1u;
    pool.quad_first_vertex = 0u;
    pool.quad_first_instance = 0u;
    pool.point_vertices = slots;
    pool.point_instances = 1u;
    pool.point_first_vertex = 0u;
    pool.point_first_instance = 0u;
    uvec2 groups = groups_of(slots, 256u);
    pool.reader_groups_x = groups.x;
    pool.reader_groups_y = groups.y;
    pool.reader_groups_z = 1u;
}
