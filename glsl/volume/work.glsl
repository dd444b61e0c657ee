// Triangles that are too large for one invocation, for an indirect dispatch of a few workgroups each, and what was left out.
layout(set = 0, binding = WORK, std430) WORK_ACCESS buffer Work {
    uint groups_x, groups_y, groups_z;  // of the dispatch
    uint larges;                        // how many
    uint no_area, not_finite;           // triangles that were skipped
    uint large[];                       // room for all triangles
};

const uint LARGE_CELLS = 32u;     // a triangle whose box overlaps more is large
const uint MOST_GROUPS = 32768u;  // along x; each then takes several triangles
