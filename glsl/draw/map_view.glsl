// A map of a mesh to look at, flat: `MapViewParams` mirrors `draw::map_view::MapViewParams`.
#include "paint/map.glsl"

struct MapViewParams {
    vec4 low_m;   // of the positions that are black, and of those that are white
    vec4 high_m;
    vec4 corner;  // where it lies in the picture, from its upper left corner on: corner and size (pixels)
    Map map;
};

layout(push_constant, std430) uniform Push { MapViewParams p; };
