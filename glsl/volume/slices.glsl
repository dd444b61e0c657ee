// The grid seen along one of its axes, `way`: texels are the other two, in cyclic order, and slices of one cell lie across
// it. Nearer to where particles come from is greater depth. Everything is in cells from the least corner.

int slice_axis() { return int(p.way % 3u); }
bool goes_down() { return p.way >= 3u; }

// Columns, rows and slices.
vec3 turned(vec3 v) {
    int w = slice_axis();
    return vec3(v[(w + 1) % 3], v[(w + 2) % 3], v[w]);
}

ivec3 turned_back(ivec3 texel) {
    int w = slice_axis();
    ivec3 cell;
    cell[(w + 1) % 3] = texel.x;
    cell[(w + 2) % 3] = texel.y;
    cell[w] = texel.z;
    return cell;
}

float depth_of(float height) {
    precise float share = height / turned(vec3(grid_cells(p.grid))).z;
    return goes_down() ? share : 1.0 - share;
}

vec4 slice_position(vec3 place) {
    vec3 at = turned(place), cells = turned(vec3(grid_cells(p.grid)));
    return vec4(2.0 * at.xy / cells.xy - 1.0, depth_of(at.z), 1.0);
}

// Where the ray of a texel's centre meets the plane of a triangle. It is computed here, not interpolated, so that
// whoever draws the triangle finds the same bits.
float slice_height(vec2 texel, vec3 normal, vec3 a_m) {
    vec3 n = turned(normal), a = turned(cell_place(p.grid, a_m));
    precise float height = a.z - (n.x * (texel.x - a.x) + n.y * (texel.y - a.y)) / n.z;
    return height;
}
