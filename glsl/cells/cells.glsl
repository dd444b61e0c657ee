// A grid of cubic cells in the world, each with up to two planes of the scene's surface: what `volume` writes and others
// collide with. Twin and host side: `cells`.
//
//     index of a cell       x + cells_x (y + cells_y z)
//     Occupied              one bit a cell: the only flag that says whether its planes mean anything
//     Planes                two a cell, 2 i and 2 i + 1; the second is there if its `triangle` is not 0
//     Extents               three words a cell, from 3 i on: where in it is what its first plane stands for, what its second
//                           does, and what neither does
//
// A plane stands for the triangles of its cell that are near it there, and ends where they do: without an end it would go on
// in the air, a cell wide. An extent is the shadow of what lies in a cell on each of the three axes: ten bits an axis, x lowest,
// each for an eighth of a cell, from 5/8 before the centre of the cell to 5/8 behind. It is wider than a cell because a plane
// is not its triangles: where a surface bends, it leaves a cell a little elsewhere than the plane does.
//
// Outside the grid everything is empty. A point of the world is in one cell, which `cell_of` says: for whoever stores and
// for whoever looks up. Before the include, CELLS_OCCUPIED and CELLS_PLANES may name the bindings of the two buffers, to be
// read here.

// Mirrors `cells::Grid`.
struct Grid {
    float low_x_m, low_y_m, low_z_m;  // least corner
    float cell_m;                     // side of a cell
    uint cells_x, cells_y, cells_z;
    uint mesh_triangles;              // of all meshes
};

// Mirrors `cells::Plane`.
struct Plane {
    vec3 normal;        // unit
    float distance_m;   // of the cell's centre from the plane, along the normal
    vec3 velocity_mps;  // of the surface, at its point nearest to the centre
    uint triangle;      // of all meshes, plus 1; 0: no plane
};

vec3 grid_low_m(Grid grid) { return vec3(grid.low_x_m, grid.low_y_m, grid.low_z_m); }
ivec3 grid_cells(Grid grid) { return ivec3(grid.cells_x, grid.cells_y, grid.cells_z); }

// A place in the world, in cells from the least corner.
vec3 cell_place(Grid grid, vec3 at_m) {
    precise vec3 place = (at_m - grid_low_m(grid)) / grid.cell_m;
    return place;
}

// The cell that a place is in; what is outside the grid, or no number, is in none that `in_grid` knows.
ivec3 cell_of(Grid grid, vec3 at_m) {
    vec3 place = cell_place(grid, at_m);
    if (any(isnan(place))) return ivec3(-1);
    return ivec3(clamp(floor(place), vec3(-1.0), vec3(grid_cells(grid))));
}

bool in_grid(Grid grid, ivec3 cell) {
    return all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, grid_cells(grid)));
}

// Of a cell in the grid.
uint cell_index(Grid grid, ivec3 cell) {
    return uint(cell.x) + grid.cells_x * (uint(cell.y) + grid.cells_y * uint(cell.z));
}

vec3 cell_centre_m(Grid grid, ivec3 cell) {
    precise vec3 centre_m = grid_low_m(grid) + (vec3(cell) + 0.5) * grid.cell_m;
    return centre_m;
}

const float EXTENT_BINS = 10.0;        // an axis
const float EXTENT_PER_CELL = 8.0;     // of them
const uint EXTENT_ALL = 0x3fffffffu;   // the cell, and an eighth of it around

// Of a box, in cells from the centre of its cell.
uint extent_of(vec3 low, vec3 high) {
    uvec3 first = uvec3(clamp(floor(low * EXTENT_PER_CELL + 0.5 * EXTENT_BINS), 0.0, EXTENT_BINS - 1.0));
    uvec3 last = uvec3(clamp(floor(high * EXTENT_PER_CELL + 0.5 * EXTENT_BINS), 0.0, EXTENT_BINS - 1.0));
    uvec3 bits = (uvec3(2u) << last) - (uvec3(1u) << first);
    return bits.x | bits.y << 10u | bits.z << 20u;
}

// The box in which an extent is that has any bit, in cells from the centre of its cell.
void bounds_of_extent(uint extent, out vec3 low, out vec3 high) {
    uvec3 bins = uvec3(extent & 0x3ffu, extent >> 10u & 0x3ffu, extent >> 20u);
    low = (vec3(findLSB(bins)) - 0.5 * EXTENT_BINS) * (1.0 / EXTENT_PER_CELL);
    high = (vec3(findMSB(bins) + 1) - 0.5 * EXTENT_BINS) * (1.0 / EXTENT_PER_CELL);
}

// Whether an extent has the point that is `from_centre_m` from the centre of its cell.
bool is_in_extent(uint extent, vec3 from_centre_m, float cell_m) {
    precise vec3 place = from_centre_m * (EXTENT_PER_CELL / cell_m) + 0.5 * EXTENT_BINS;
    if (!(all(greaterThanEqual(place, vec3(0.0))) && all(lessThan(place, vec3(EXTENT_BINS))))) return false;
    uvec3 bin = uvec3(place);
    return (extent >> bin.x & extent >> (10u + bin.y) & extent >> (20u + bin.z) & 1u) != 0u;
}

// Signed, of a point in the plane's cell (m).
float plane_distance_m(Plane plane, vec3 at_m, vec3 centre_m) {
    precise float distance_m = dot(plane.normal, at_m - centre_m) + plane.distance_m;
    return distance_m;
}

#ifdef CELLS_OCCUPIED
layout(set = 0, binding = CELLS_OCCUPIED, std430) readonly buffer Occupied { uint occupied[]; };

bool is_occupied(uint cell) { return (occupied[cell >> 5u] >> (cell & 31u) & 1u) != 0u; }
#endif

#ifdef CELLS_PLANES
layout(set = 0, binding = CELLS_PLANES, std430) readonly buffer Planes { Plane planes[]; };

// Of an occupied cell: the one nearest to its centre, which is always there, and the other (`slot` 1).
Plane plane_of(uint cell, uint slot) { return planes[2u * cell + slot]; }
#endif
