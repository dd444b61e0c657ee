// The sun's shadow: depth of what its light meets first, seen along it, in a square round the place where things happen.
// Outside the square there is no shadow. A shader that draws into the map defines SHADOW_CASTER.

#ifndef SHADOW_BINDING
#define SHADOW_BINDING 1
#endif

// Mirrors `draw::shadow::ShadowView`.
struct Shadow {
    vec4 right;     // unit, across the light; w: half of the square (m)
    vec4 up;        // unit; w: texels along the square
    vec4 to_sun;    // unit; w: depth runs from 1 at so far towards the sun to 0 at so far behind (m)
    vec4 centre_m;
};

layout(set = 0, binding = SHADOW_BINDING, std430) readonly buffer Shadows { Shadow shadow; };

// x and y from -1 to 1 over the square, y up; z: depth, the nearer to the sun the greater.
vec3 shadow_place(vec3 at_m) {
    vec3 from = at_m - shadow.centre_m.xyz;
    vec2 across = vec2(dot(from, shadow.right.xyz), dot(from, shadow.up.xyz)) / shadow.right.w;
    return vec3(across, 0.5 + 0.5 * dot(from, shadow.to_sun.xyz) / shadow.to_sun.w);
}

#ifndef SHADOW_CASTER
layout(set = 0, binding = SHADOW_BINDING + 1, std430) readonly buffer ShadowDepth { float shadow_depth[]; };

// Share of the sun that arrives, 0 to 1: the mean over a square of three by three texels round the place, which moves
// evenly from texel to texel. `normal`: towards the sun, as the place is moved along it by as much as a slanting surface
// would shade itself.
float sun_share(vec3 at_m, vec3 normal) {
    float side = shadow.up.w, texel_m = 2.0 * shadow.right.w / side;
    float slant = sqrt(max(1.0 - pow(dot(normal, shadow.to_sun.xyz), 2.0), 0.0));
    vec3 place = shadow_place(at_m + normal * texel_m * (0.6 + 1.6 * slant) + shadow.to_sun.xyz * 0.5 * texel_m);
    vec2 at = vec2(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y) * side - 0.5;
    if (any(lessThan(at, vec2(2.0))) || any(greaterThan(at, vec2(side - 3.0)))) return 1.0;
    ivec2 c = ivec2(floor(at));
    vec2 f = at - vec2(c);
    float lit = 0.0;
    for (int y = -1; y <= 2; ++y) {
        float row = 0.0;
        for (int x = -1; x <= 2; ++x) {
            float weight = x == -1 ? 1.0 - f.x : x == 2 ? f.x : 1.0;
            uint texel = uint(c.y + y) * uint(side) + uint(c.x + x);
            if (place.z >= shadow_depth[texel]) row += weight;
        }
        lit += row * (y == -1 ? 1.0 - f.y : y == 2 ? f.y : 1.0);
    }
    return lit / 9.0;
}
#endif
