// Disks (DIMENSIONS 2) and spheres (3): state, box, cells. A state is two arrays, in the order of cells:
//
//               place_m (vec4)           motion
//     flat      x, y, radius, id         vec2: velocity
//     solid     x, y, z, radius          vec4: velocity, id
//
// The mass is radius^2 or radius^3. `DisksParams` mirrors `disks::Params`.

#include "disks/id.glsl"

#if DIMENSIONS == 2
#define vecd vec2
#define ivecd ivec2
#define Motion_t vec2
#else
#define vecd vec3
#define ivecd ivec3
#define Motion_t vec4
#endif

struct DisksParams {
    vec4 size_m;        // the box, from the origin
    uvec4 cells;        // along x, y, z
    vec4 cells_per_m;   // the host divides, so that every pass finds a disk in the same cell to the bit
    vec4 gravity_mps2;  // w: speed to which stirring may bring a disk (m/s)
    vec4 stir_at_m;     // w: how far stirring reaches (m)
    float stir_mps2;    // away from there; 0: nothing is stirred
    float dt_s;
    uint disks;
    uint large;         // disks that are wider than a cell: the first ones, in no cell
    float small_m;      // radius of the largest of the others
    uint step;          // number of this step, from 1
    uint color;         // of cells, in disks.sweep
    uint is_first;      // round, in disks.propose
};

layout(push_constant, std430) uniform Push { DisksParams p; };
layout(local_size_x_id = 0) in;

const uint NONE = 0xffffffffu;   // no contact
const uint MANY = 0xfffffffeu;   // several
const uint AWAKE = 0xfffffffdu;  // none to collide with now, but to be looked at again

// One invocation an item, also where there are more than one row of workgroups takes.
uint item() { return gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x; }

#if DIMENSIONS == 2
vecd at_of(vec4 place) { return place.xy; }
float radius_of(vec4 place) { return place.z; }
uint id_of(vec4 place, Motion_t motion) { return id_of_word(place.w); }
vec4 place_of(vecd at_m, float radius_m, uint id) { return vec4(at_m, radius_m, word_of_id(id)); }
Motion_t motion_of(vecd velocity_mps, uint id) { return velocity_mps; }
vecd velocity_of(Motion_t motion) { return motion; }
float mass_of(float radius_m) { return radius_m * radius_m; }
vecd box_m() { return p.size_m.xy; }
vecd cells_per_m() { return p.cells_per_m.xy; }
ivecd box_cells() { return ivec2(p.cells.xy); }
uint cell_index(ivecd c) { return uint(c.y) * p.cells.x + uint(c.x); }
#else
vecd at_of(vec4 place) { return place.xyz; }
float radius_of(vec4 place) { return place.w; }
uint id_of(vec4 place, Motion_t motion) { return id_of_word(motion.w); }
vec4 place_of(vecd at_m, float radius_m, uint id) { return vec4(at_m, radius_m); }
Motion_t motion_of(vecd velocity_mps, uint id) { return vec4(velocity_mps, word_of_id(id)); }
vecd velocity_of(Motion_t motion) { return motion.xyz; }
float mass_of(float radius_m) { return radius_m * radius_m * radius_m; }
vecd box_m() { return p.size_m.xyz; }
vecd cells_per_m() { return p.cells_per_m.xyz; }
ivecd box_cells() { return ivec3(p.cells.xyz); }
uint cell_index(ivecd c) { return (uint(c.z) * p.cells.y + uint(c.y)) * p.cells.x + uint(c.x); }
#endif

// Cells are numbered along x first, so that the cells beside each other in a row hold one run of disks.
ivecd cell_of(vecd at_m) {
    return clamp(ivecd(floor(at_m * cells_per_m())), ivecd(0), box_cells() - 1);
}
