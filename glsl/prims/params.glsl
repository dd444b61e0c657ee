// Mirrors `prims::Params`.
layout(push_constant, std430) uniform Push {
    uint count;  // elements
    uint tiles;  // of TILE elements each
    uint bins;   // keys are below
} p;

const uint GROUP = 256u;  // invocations of every workgroup
const uint ITEMS = 16u;   // elements of an invocation
const uint TILE = GROUP * ITEMS;
// Up to so many tiles, a scan's last dispatch adds up the sums itself: cheaper than a dispatch between. Mirrors `prims::FEW_TILES`.
const uint FEW_TILES = 1024u;

// Which workgroup this is, where there are more than fit into a row.
uint tile_index() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
