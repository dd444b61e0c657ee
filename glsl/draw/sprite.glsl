// A sprite, and how it lies before the eye. Needs draw/view.glsl.
//
// An effect is a file that defines
//     bool sprite_of(uint i, out Sprite sprite)
// for the i-th sprite to draw, the first to draw (the oldest, where it matters) being 0; false: nothing is drawn. It is
// asked for numbers beyond the last one, and answers false. Its numbers come from push constants or from storage blocks of
// its own at bindings from 8 on; below are Views (0), Terrain (1) and Light (2) of draw/terrain.glsl, and drawing's own
// (3 to 7). A shader of it is a file of a few lines:
//     #include "draw/view.glsl"
//     #include "draw/sprite.glsl"
//     #include "the/effect.glsl"
//     #include "draw/sprites_vert.glsl"   // or sprites_geom.glsl, or sprites_splat.glsl

struct Sprite {
    vec3 at_m;     // centre
    vec3 along_m;  // half of a streak, from the centre to its head; zero: a quad that faces the eye
    vec2 half_m;   // half width and half height; of a streak, x: half width
    float turn;    // of a quad, counter-clockwise as seen, part of a turn
    vec4 color;    // linear, premultiplied by its alpha; alpha 0 adds light and covers nothing
};

// The sprite in the picture: its corner (x, y), each -1 or 1, lies at at_m + x right_m + y up_m.
struct Placed {
    vec3 right_m, up_m;
    float stretch;  // length of a streak by its width; 1: not a streak
    vec4 color;     // of what was made as wide as a pixel to be seen, so much less
};

// What covers is seen by the light that falls on it, of the day and of the lamp; what adds is light.
vec4 lit_sprite(vec4 color, vec3 at_m) {
    if (color.a == 0.0) return color;
    vec3 to_lamp = view.lamp_m.xyz - at_m;
    return vec4(color.rgb * (view.daylight + 0.3 * view.lamp.rgb / (dot(to_lamp, to_lamp) + 0.5)), color.a);
}

// Distance from the plane of the eye (m): what depth is made of.
float sprite_distance_m(vec3 at_m) { return dot(at_m - view.eye_m.xyz, view.ray_forward.xyz); }

float distance_of_depth(float depth) { return view.clip_from_world[3][2] / max(depth, 1e-12); }

// Finite for every sprite that is: a streak that points at the eye is a round dot, and no axis is made from a world's up,
// which an eye straight above would have none of. `least_px`: half width that is made up for, at the least.
Placed place(Sprite sprite, float least_px) {
    Placed placed;
    float pixel_m = 2.0 * length(view.ray_up.xyz) * max(sprite_distance_m(sprite.at_m), 0.0) / float(view.pixels.y);
    float least_m = least_px * pixel_m;
    vec2 half_m = max(sprite.half_m, vec2(least_m));
    vec3 right = normalize(view.ray_right.xyz), up = normalize(view.ray_up.xyz);
    placed.stretch = 1.0;
    float length2 = dot(sprite.along_m, sprite.along_m);
    if (length2 > 0.0) {
        vec3 to_eye = normalize(view.eye_m.xyz - sprite.at_m + vec3(0.0, 1e-20, 0.0));
        vec3 side = cross(sprite.along_m, to_eye);
        float seen2 = dot(side, side);  // length^2 as seen
        if (seen2 > 1e-10 * length2) {
            side *= inversesqrt(seen2);
        } else {
            side = right;
        }
        vec3 ahead = cross(to_eye, side);  // along the streak, as seen
        if (dot(ahead, sprite.along_m) < 0.0) ahead = -ahead, side = -side;
        placed.right_m = half_m.x * side;
        placed.up_m = sprite.along_m + half_m.x * ahead;
        placed.stretch = half_m.x > 0.0 ? 1.0 + sqrt(seen2) / half_m.x : 1.0;
        // Light of a line of length L and half width w goes with w (k w + L), its ends being half a disc each.
        const float k = 0.490874;
        float seen = sqrt(seen2), w = sprite.half_m.x, wide = half_m.x;
        placed.color = wide > 0.0 ? sprite.color * (w * (k * w + seen) / (wide * (k * wide + seen))) : vec4(0.0);
    } else {
        float angle = 6.28318530718 * sprite.turn;
        float c = cos(angle), s = sin(angle);
        placed.right_m = half_m.x * (c * right + s * up);
        placed.up_m = half_m.y * (c * up - s * right);
        vec2 share = sprite.half_m / max(half_m, vec2(1e-30));
        placed.color = sprite.color * (share.x * share.y);
    }
    placed.color = lit_sprite(placed.color, sprite.at_m);
    return placed;
}

// A soft disc, or a soft line with round ends: (1 - r^2)^2, whose sum over the pixels hardly depends on where it lies
// between them once it is two pixels wide. `at`: from -1 to 1 over the sprite.
float soft_disc(vec2 at, float stretch) {
    at.y = max(abs(at.y) * stretch - (stretch - 1.0), 0.0);
    float in_disc = max(1.0 - dot(at, at), 0.0);
    return in_disc * in_disc;
}
