// How a paint map lies in memory: in tiles of 8 x 8 texels, and blocks of 8 x 8 tiles, so that a workgroup that has a tile
// reads and writes one run of memory, and what lies together on the mesh is culled together. Maps of several meshes follow
// each other, each a whole number of blocks; texels beyond its edge are covered by nothing. CPU twin: paint::Map.
#ifndef PAINT_MAP_GLSL
#define PAINT_MAP_GLSL

const uint TILE_TEXELS = 64u;
const uint BLOCK_TILES = 64u;

// Mirrors `paint::Map`, 16 bytes.
struct Map {
    uint width;        // texels
    uint height;
    uint first_block;
    uint blocks_x;     // of a row
};

uint texel_of(Map map, uvec2 at) {
    uvec2 block = at >> 6u, tile = at >> 3u & 7u, texel = at & 7u;
    uint tiles = BLOCK_TILES * (map.first_block + map.blocks_x * block.y + block.x) + 8u * tile.y + tile.x;
    return TILE_TEXELS * tiles + 8u * texel.y + texel.x;
}

// The texel under texture coordinates; v points down, as the rows do.
uint texel_at(Map map, vec2 uv) {
    uvec2 size = uvec2(map.width, map.height);
    uvec2 at = uvec2(clamp(uv, 0.0, 1.0) * vec2(size));
    return texel_of(map, min(at, size - 1u));
}

// Where a texel is on its mesh. Mirrors `paint::Position`, 16 bytes.
struct Position {
    vec3 at_m;
    uint triangle;  // 0: no mesh here, or nowhere; else 1 + the triangle, and GUTTER beside a chart
};

const uint GUTTER = 0x80000000u;

// Box round a tile or a block. Mirrors `paint::Box`, 32 bytes.
struct Box {
    vec3 low_m;
    uint mesh;
    vec3 high_m;
    uint covered;  // texels with a place; 0: no box
};

// Square of the distance of two points (m^2).
float distance_sq(vec3 a, vec3 b) {
    precise vec3 way = a - b;
    precise float sq = way.x * way.x + way.y * way.y + way.z * way.z;
    return sq;
}

// The same of a point and a box, 0 inside. Subtraction, square and sum round monotonically, and are done here in the order
// of `distance_sq`: so it is never above what `distance_sq` says of a point of the box, not by the last bit. What a tile
// culls, none of its texels would have taken.
float distance_sq(vec3 at, Box box) {
    precise vec3 below = box.low_m - at;
    precise vec3 above = at - box.high_m;
    precise vec3 way = max(max(below, above), vec3(0.0));
    precise float sq = way.x * way.x + way.y * way.y + way.z * way.z;
    return sq;
}

#endif
