// Mirrors `draw::mesh::MeshParams`.
#include "paint/map.glsl"

struct MeshParams {
    vec4 color;           // linear albedo; w: how much of the sun is mirrored
    uint first_triangle;
    uint first_joint;
    float tile_m;         // edge of the tiles of a checkered floor; 0: plain
    uint reserved;
    Map map;              // of its paint
};

layout(push_constant, std430) uniform Push { MeshParams p; };
