// What every drawing shader knows of the picture: `View` mirrors `draw::View`. World: y up, metres.

struct View {
    mat4 clip_from_world;  // reversed depth, infinitely far
    vec4 eye_m;            // w: time of the scene (s)
    vec4 ray_right;        // direction through a pixel = forward + x right + y up, x and y from -1 to 1
    vec4 ray_up;
    vec4 ray_forward;
    vec4 to_sun;           // unit; w: exposure
    vec2 terrain_size_m;   // extent along x and z, round the origin
    uvec2 terrain_cells;   // samples along x and z
    uvec2 pixels;          // of the finished picture
    float daylight;        // 1: noon and blue sky, 0: none
    uint reserved;
    vec4 lamp_m;           // a light that is no sun: where it is
    vec4 lamp;             // its light at a distance of 1 m; black: none
};

layout(set = 0, binding = 0, std430) readonly buffer Views { View view; };

// Colours are linear, and 1 is what a white wall sends back under the noon sun.
const vec3 SUN_LIGHT = vec3(3.2, 2.85, 2.4);
const vec3 SKY_LIGHT = vec3(0.42, 0.58, 0.85);

// PCG hash of two integers (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020), 0 to 1.
float hash2(ivec2 c) {
    uint x = uint(c.x) * 1664525u + uint(c.y) * 22695477u + 1013904223u;
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
    return float((x >> 22u) ^ x) * (1.0 / 4294967296.0);
}

// Value noise and its gradient, -1 to 1, one bump a unit.
vec3 noise_and_slope(vec2 at) {
    ivec2 c = ivec2(floor(at));
    vec2 f = at - vec2(c), u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0), du = 30.0 * f * f * (f * (f - 2.0) + 1.0);
    float a = hash2(c), b = hash2(c + ivec2(1, 0)), d = hash2(c + ivec2(0, 1)), e = hash2(c + ivec2(1, 1));
    float k1 = b - a, k2 = d - a, k3 = a - b - d + e;
    return 2.0 * vec3(a + k1 * u.x + k2 * u.y + k3 * u.x * u.y - 0.5, du * (vec2(k1, k2) + k3 * u.yx));
}

float noise(vec2 at) { return noise_and_slope(at).x; }

float fbm(vec2 at, int octaves) {
    float sum = 0.0, weight = 0.5;
    for (int i = 0; i < octaves; ++i) {
        sum += weight * noise(at);
        at = mat2(1.6, 1.2, -1.2, 1.6) * at + 7.3;
        weight *= 0.5;
    }
    return sum;
}

// Sky without the disc of the sun: what water mirrors and haze takes its colour from.
vec3 haze_color(vec3 dir) {
    float sun = max(dot(dir, view.to_sun.xyz), 0.0);
    return mix(vec3(0.62, 0.74, 0.88), vec3(1.15, 0.92, 0.68), 0.75 * pow(sun, 6.0));
}

vec3 sky_color(vec3 dir) {
    float up = max(dir.y, 0.0);
    vec3 sky = mix(haze_color(dir), vec3(0.16, 0.34, 0.72), 1.0 - exp(-3.2 * up));
    float sun = max(dot(dir, view.to_sun.xyz), 0.0);
    sky += SUN_LIGHT * (0.06 * pow(sun, 24.0) + 0.22 * pow(sun, 350.0));
    return sky;
}

vec3 clouded_sky(vec3 dir) {
    vec3 sky = sky_color(dir);
    if (dir.y <= 0.02) return sky;
    vec2 at = dir.xz / (dir.y + 0.12) * 1.3 + view.eye_m.w * 0.004;
    float cover = smoothstep(0.02, 0.5, fbm(at, 5) + 0.12) * smoothstep(0.02, 0.22, dir.y);
    float sun = max(dot(dir, view.to_sun.xyz), 0.0);
    vec3 cloud = mix(vec3(0.86, 0.89, 0.94), vec3(1.7, 1.55, 1.35), pow(sun, 4.0));
    return mix(sky, cloud, 0.75 * cover);
}

vec3 with_haze(vec3 color, vec3 from_eye_m) {
    float far = length(from_eye_m);
    float haze = 1.0 - exp(-pow(far / 900.0, 1.4));
    return mix(color, haze_color(from_eye_m / max(far, 1e-3)), haze);
}
