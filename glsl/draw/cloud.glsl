// A cloud of drops without a memory: place and colour of the i-th are a hash of i, so that what is timed is drawing.
// Needs draw/sprite.glsl.

#include "common/random.glsl"

layout(push_constant) uniform Push {
    uint count;
    float half_m;   // half width
    float along_m;  // half of a streak, down; 0: discs
    float light;    // of each, against a dim one
} p;

bool sprite_of(uint i, out Sprite sprite) {
    if (i >= p.count) return false;
    vec4 place = random_units(random_bits(1u, 0u, i, 0u));
    sprite.at_m = (place.xyz - 0.5) * vec3(36.0, 20.0, 10.0);
    sprite.along_m = vec3(0.0, -p.along_m, 0.0);
    sprite.half_m = vec2(p.half_m * (0.5 + 0.5 * place.w));
    sprite.turn = 0.0;
    sprite.color = vec4(p.light * (0.02 + 0.02 * place.xyz), 0.0);
    return true;
}
