// What `particles.near` and `particles.met` are told. Mirrors `particles::NearParams`.
struct NearParams {
    uint cells_x;
    uint cells_y;
    uint cells_z;
    uint reach;  // cells
    float cell_m;
};

layout(push_constant, std430) uniform Push { NearParams p; };

uint near_item() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
}
