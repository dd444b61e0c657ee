// Vertex of a grid that is drawn in tiles of 32 x 32 quads, one instance a tile, with one index list for all tiles:
// `draw::Grid` makes it. A tile that reaches over the border repeats the last vertex: empty triangles.

const uint GRID_TILE = 32u;

uvec2 grid_vertex(uvec2 vertices) {
    uint tiles_x = max((vertices.x - 1u + GRID_TILE - 1u) / GRID_TILE, 1u);
    uvec2 tile = uvec2(uint(gl_InstanceIndex) % tiles_x, uint(gl_InstanceIndex) / tiles_x);
    uvec2 within = uvec2(uint(gl_VertexIndex) % (GRID_TILE + 1u), uint(gl_VertexIndex) / (GRID_TILE + 1u));
    return min(tile * GRID_TILE + within, vertices - 1u);
}
