// A surface in the light, seen from either side. PAINTED: with its map of paint over it.

layout(location = 0) in vec3 at_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 0) out vec4 color;

#ifdef PAINTED
layout(set = 0, binding = 7, std430) readonly buffer Paint { uvec2 paint[]; };
#define FORMAT_CONSTANT 0
#include "paint/lookup.glsl"
#endif

// Of a triangle whose vertices say nothing.
vec3 flat_normal() { return cross(dFdx(at_m), dFdy(at_m)); }

void main() {
    vec3 n = dot(normal, normal) > 1e-20 ? normalize(normal) : normalize(flat_normal() + vec3(0.0, 1e-20, 0.0));
    if (dot(n, at_m - view.eye_m.xyz) > 0.0) n = -n;
    vec3 albedo = p.color.rgb;
    if (p.tile_m > 0.0) {  // of the two axes that the surface runs along most
        vec3 a = abs(n);
        vec2 at = (a.y > max(a.x, a.z) ? at_m.xz : a.x > a.z ? at_m.yz : at_m.xy) / p.tile_m + 0.001;
        vec2 c = floor(at);
        float width = 1.5 * max(fwidth(at.x), fwidth(at.y)), odd = mod(c.x + c.y, 2.0);
        vec2 edge = min(at - c, 1.0 - (at - c));
        float sharp = clamp(min(edge.x, edge.y) / max(width, 1e-6), 0.0, 1.0);  // both colours where a tile is below a pixel
        albedo *= mix(0.86, odd > 0.5 ? 0.72 : 1.0, sharp);
    }
    float mirrors = p.color.w;
#ifdef PAINTED
    vec4 coat = paint_at(p.map, uv);
    albedo = coat.rgb + (1.0 - min(coat.a, 1.0)) * albedo;
    mirrors = max(mirrors, 0.25 * min(coat.a, 1.0));  // wet
#endif
    color = vec4(surface_lit(albedo, mirrors, at_m, n), 1.0);
}
