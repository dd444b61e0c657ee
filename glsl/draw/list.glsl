// The plainest effect: sprites that stand in a list, word k of sprite i at 13 i + k. Needs draw/sprite.glsl.

layout(set = 0, binding = 8, std430) readonly buffer List { float list[]; };

vec3 list_vec3(uint word) { return vec3(list[word], list[word + 1u], list[word + 2u]); }

bool sprite_of(uint i, out Sprite sprite) {
    if (i >= uint(list.length()) / 13u) return false;
    uint word = 13u * i;
    sprite.at_m = list_vec3(word);
    sprite.along_m = list_vec3(word + 3u);
    sprite.half_m = vec2(list[word + 6u], list[word + 7u]);
    sprite.turn = list[word + 8u];
    sprite.color = vec4(list_vec3(word + 9u), list[word + 12u]);
    return true;
}
