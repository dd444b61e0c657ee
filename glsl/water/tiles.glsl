// Which tile a workgroup of a fused kernel steps. In basins with land there are two lists, for two builds of the kernel: of
// tiles of open water, and of tiles with a shore in reach, as that of the grid is. `water::tiles` makes them. The including
// file declares has_land and has_shores.
layout(set = 0, binding = 4, std430) readonly buffer Tiles {
    uvec3 groups;  // of the dispatch
    uint count;    // of tiles, no more than there are groups
    uint tiles[];  // column, and row << 16
};

const uint NONE = 0xffffffffu;

uvec2 tile_of_group() {
    if (!has_land) return gl_WorkGroupID.xy;
    uint i = gl_WorkGroupID.y * groups.x + gl_WorkGroupID.x;
    if (i >= count) return uvec2(NONE);
    return uvec2(tiles[i] & 0xffffu, tiles[i] >> 16u);
}
