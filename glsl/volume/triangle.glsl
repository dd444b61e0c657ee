// A triangle of the scene among cells. Places are in cells from the least corner of the grid, so that the box of a cell
// is [cell, cell + 1]; edges come from differences in the world, which lose nothing far from the origin.
//
// A triangle overlaps a box if no axis parts them (Akenine-Moeller, "Fast 3D Triangle-Box Overlap Testing", 2001): the
// three of the box, the normal, and the nine cross products of an edge and an axis of the box. Those nine are the normals of
// the edges in the three planes of the box (Schwarz and Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs",
// 2010). Both are closed, and the box is larger by a slack that covers what single precision rounds: what touches
// overlaps. Twin: volume::cpu::Shape.
#include "volume/params.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Places { float places[]; };       // at (m), velocity (m/s): `mesh.pose`
layout(set = 0, binding = 1, std430) readonly buffer Triangles { uint corners[]; };    // three a triangle

const float LEAST_SINE = 2.384185791015625e-7;     // 2^-22: below it a triangle is a line
const float NEEDLE_SINE = 9.765625e-4;             // 2^-10
const float SLACK = 2.44140625e-4;                 // 2^-12 (cells)
const float SLACK_SHARE = 4.76837158203125e-7;     // 2^-21: of the farthest coordinate (cells)
const float FARTHEST_CELLS = 1.0e9;                // beyond it, products of four coordinates are no numbers

// What `load_triangle` finds.
const uint SOUND = 0u;
const uint NO_AREA = 1u;     // narrower than its length by more than single precision tells from a line: it has no normal
const uint NOT_FINITE = 2u;  // a corner is no number, or farther out than can be computed with

uvec3 tri_corners;
vec3 tri_a_m;         // first corner
vec3 tri_a;           // the same in cells
vec3 tri_ab, tri_ac;  // from there to the others (cells)
vec3 tri_normal;      // unit, by the order of corners
float tri_sine;       // twice the area by the square of the longest extent
float tri_slack;      // (cells)
ivec3 tri_low, tri_high;  // cells that its own box overlaps, within the grid

vec3 corner_m(uint corner) { return vec3(places[6u * corner], places[6u * corner + 1u], places[6u * corner + 2u]); }
vec3 corner_mps(uint corner) { return vec3(places[6u * corner + 3u], places[6u * corner + 4u], places[6u * corner + 5u]); }

float largest(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }
bool is_finite(vec3 v) { return all(notEqual(floatBitsToUint(v) & 0x7f800000u, uvec3(0x7f800000u))); }

uint set_triangle(vec3 a_m, vec3 b_m, vec3 c_m) {
    tri_a_m = a_m;
    if (!(is_finite(tri_a_m) && is_finite(b_m) && is_finite(c_m))) return NOT_FINITE;
    tri_a = cell_place(p.grid, tri_a_m);
    tri_ab = (b_m - tri_a_m) / p.grid.cell_m;
    tri_ac = (c_m - tri_a_m) / p.grid.cell_m;

    // Edges are scaled to 1 before they are multiplied, as a small triangle's area would be no number.
    float extent = max(largest(tri_ab), largest(tri_ac));
    if (!(max(extent, largest(tri_a)) <= FARTHEST_CELLS)) return NOT_FINITE;
    if (extent < 1e-30) return NO_AREA;
    vec3 ab = tri_ab / extent, ac = tri_ac / extent;
    precise vec3 across = ab.yzx * ac.zxy - ab.zxy * ac.yzx;
    tri_sine = sqrt(precise_dot(across, across));
    if (!(tri_sine > LEAST_SINE)) return NO_AREA;
    tri_normal = across / tri_sine;

    // The same box wherever it is asked for: `volume.extend` numbers its cells.
    precise vec3 b = tri_a + tri_ab, c = tri_a + tri_ac;
    precise float slack = SLACK + SLACK_SHARE * max(max(largest(tri_a), largest(b)), largest(c));
    precise vec3 low = min(min(tri_a, b), c) - slack, high = max(max(tri_a, b), c) + slack;
    tri_slack = slack;
    vec3 cells = vec3(grid_cells(p.grid));
    tri_low = ivec3(clamp(ceil(low) - 1.0, vec3(0.0), cells));
    tri_high = ivec3(clamp(floor(high), vec3(-1.0), cells - 1.0));
    return SOUND;
}

uint load_triangle(uint t) {
    tri_corners = uvec3(corners[3u * t], corners[3u * t + 1u], corners[3u * t + 2u]);
    return set_triangle(corner_m(tri_corners.x), corner_m(tri_corners.y), corner_m(tri_corners.z));
}

// How many cells the triangle's own box overlaps.
uint box_cells() {
    uvec3 n = uvec3(max(tri_high - tri_low + 1, ivec3(0)));
    return n.x * n.y * n.z;
}

// The axis that its normal is nearest to.
int across_axis() {
    vec3 n = abs(tri_normal);
    return n.x > n.y && n.x > n.z ? 0 : n.y > n.z ? 1 : 2;
}

// How many columns of cells along an axis its own box overlaps.
uint box_columns(int axis) {
    uvec3 n = uvec3(max(tri_high - tri_low + 1, ivec3(0)));
    return n[(axis + 1) % 3] * n[(axis + 2) % 3];
}

// In one plane of the box, whose centre is the origin: whether no normal of an edge parts them.
bool overlaps_flat(vec2 a, vec2 b, vec2 c, float half_side) {
    vec2 ab = b - a, bc = c - b, ca = a - c;
    // On the normal of its edge, the two ends are one point, and the third corner the other end of the interval.
    vec3 end = vec3(ab.x * a.y - ab.y * a.x, bc.x * b.y - bc.y * b.x, ca.x * c.y - ca.y * c.x);
    vec3 tip = vec3(ab.x * c.y - ab.y * c.x, bc.x * a.y - bc.y * a.x, ca.x * b.y - ca.y * b.x);
    vec3 reach = half_side * vec3(abs(ab.x) + abs(ab.y), abs(bc.x) + abs(bc.y), abs(ca.x) + abs(ca.y));
    return all(lessThanEqual(min(end, tip), reach)) && all(greaterThanEqual(max(end, tip), -reach));
}

// Whether the triangle overlaps a cell between `tri_low` and `tri_high`, where the axes of the box do not part them.
bool overlaps(ivec3 cell) {
    float half_side = 0.5 + tri_slack;
    vec3 a = tri_a - (vec3(cell) + 0.5);
    if (abs(dot(tri_normal, a)) > half_side * (abs(tri_normal.x) + abs(tri_normal.y) + abs(tri_normal.z))) return false;
    vec3 b = a + tri_ab, c = a + tri_ac;
    return overlaps_flat(a.xy, b.xy, c.xy, half_side) && overlaps_flat(a.yz, b.yz, c.yz, half_side)
        && overlaps_flat(a.zx, b.zx, c.zx, half_side);
}

// Shares of b and c in the point of the triangle that is nearest to a point, given from corner a (cells).
vec2 nearest_shares(vec3 from_a) {
    vec3 across = cross(tri_ab, tri_ac);
    float area = length(across);
    vec2 inside = vec2(dot(cross(from_a, tri_ac), tri_normal), dot(cross(tri_ab, from_a), tri_normal)) / area;
    // What is narrow as a needle is as near along its edges, where a small area divides nothing.
    if (tri_sine > NEEDLE_SINE && inside.x >= 0.0 && inside.y >= 0.0 && inside.x + inside.y <= 1.0) return inside;
    vec3 bc = tri_ac - tri_ab;
    float on_ab = clamp(dot(from_a, tri_ab) / max(dot(tri_ab, tri_ab), 1e-37), 0.0, 1.0);
    float on_ac = clamp(dot(from_a, tri_ac) / max(dot(tri_ac, tri_ac), 1e-37), 0.0, 1.0);
    float on_bc = clamp(dot(from_a - tri_ab, bc) / max(dot(bc, bc), 1e-37), 0.0, 1.0);
    vec3 to_ab = from_a - on_ab * tri_ab, to_ac = from_a - on_ac * tri_ac, to_bc = from_a - tri_ab - on_bc * bc;
    vec3 away = vec3(dot(to_ab, to_ab), dot(to_ac, to_ac), dot(to_bc, to_bc));
    if (away.x <= min(away.y, away.z)) return vec2(on_ab, 0.0);
    return away.y <= away.z ? vec2(0.0, on_ac) : vec2(1.0 - on_bc, on_bc);
}
