// The heightmap under everything: sampling, material and light. Needs draw/view.glsl.

layout(set = 0, binding = 1, std430) readonly buffer Terrain { float terrain_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Light { uint light[]; };  // share of sun and of sky that arrives, and what is built there

float terrain_sample(ivec2 c) {
    c = clamp(c, ivec2(0), ivec2(view.terrain_cells) - 1);
    return terrain_m[uint(c.y) * view.terrain_cells.x + uint(c.x)];
}

// Position on the grid of samples, which lie in the middle of their cells.
vec2 terrain_grid(vec2 xz_m) { return (xz_m / view.terrain_size_m + 0.5) * vec2(view.terrain_cells) - 0.5; }

float terrain_height(vec2 xz_m) {
    vec2 at = clamp(terrain_grid(xz_m), vec2(0.0), vec2(view.terrain_cells - 1u));
    ivec2 c = ivec2(at);
    vec2 f = at - vec2(c);
    return mix(mix(terrain_sample(c), terrain_sample(c + ivec2(1, 0)), f.x),
               mix(terrain_sample(c + ivec2(0, 1)), terrain_sample(c + ivec2(1, 1)), f.x), f.y);
}

vec3 terrain_normal(ivec2 c) {
    vec2 cell_m = view.terrain_size_m / vec2(view.terrain_cells);
    float dx = terrain_sample(c + ivec2(1, 0)) - terrain_sample(c - ivec2(1, 0));
    float dz = terrain_sample(c + ivec2(0, 1)) - terrain_sample(c - ivec2(0, 1));
    return normalize(vec3(-dx / (2.0 * cell_m.x), 1.0, -dz / (2.0 * cell_m.y)));
}

// Between the four samples round a place, so that no cell is seen.
vec3 terrain_normal_at(vec2 xz) {
    vec2 grid = terrain_grid(xz);
    ivec2 c = ivec2(floor(grid));
    vec2 f = grid - vec2(c);
    vec3 south = mix(terrain_normal(c), terrain_normal(c + ivec2(1, 0)), f.x);
    vec3 north = mix(terrain_normal(c + ivec2(0, 1)), terrain_normal(c + ivec2(1, 1)), f.x);
    return normalize(mix(south, north, f.y));
}

// Shares of sun and of sky, and 0 for ground, 1/2 for stone, 1 for a house.
vec3 light_sample(ivec2 c) {
    c = clamp(c, ivec2(0), ivec2(view.terrain_cells) - 1);
    return unpackUnorm4x8(light[uint(c.y) * view.terrain_cells.x + uint(c.x)]).xyz;
}

vec3 terrain_light(vec2 xz_m) {
    vec2 at = clamp(terrain_grid(xz_m), vec2(0.0), vec2(view.terrain_cells - 1u));
    ivec2 c = ivec2(at);
    vec2 f = at - vec2(c);
    return mix(mix(light_sample(c), light_sample(c + ivec2(1, 0)), f.x),
               mix(light_sample(c + ivec2(0, 1)), light_sample(c + ivec2(1, 1)), f.x), f.y);
}

// Albedo by height over the water and slope, `detail` 1 near and 0 far, where noise would only flicker.
vec3 terrain_albedo(vec3 at_m, float up, float detail) {
    float broad = fbm(at_m.xz * 0.045, 3), fine = detail > 0.02 ? detail * fbm(at_m.xz * 1.1, 4) : 0.0;
    vec3 rock = mix(vec3(0.21, 0.2, 0.19), vec3(0.34, 0.31, 0.28), 0.5 + 0.7 * broad + 0.6 * fine);
    float strata = detail * noise(vec2(at_m.y * 1.7 + 2.0 * broad, 3.1));
    rock *= 1.0 + 0.18 * strata;
    vec3 grass = mix(vec3(0.07, 0.105, 0.035), vec3(0.15, 0.165, 0.06), 0.5 + 0.6 * broad + 0.8 * fine);
    vec3 sand = mix(vec3(0.4, 0.34, 0.25), vec3(0.5, 0.44, 0.33), 0.5 + fine);
    vec3 silt = mix(vec3(0.2, 0.19, 0.13), vec3(0.36, 0.33, 0.24), 0.5 + 0.8 * broad + 0.9 * fine);

    float steep = smoothstep(0.86, 0.7, up + 0.12 * fine + 0.05 * broad);
    vec3 dry = mix(mix(sand, grass, smoothstep(0.35, 1.3, at_m.y + 0.5 * fine + 0.4 * broad)), rock, steep);
    float snow = smoothstep(0.72, 0.86, up + 0.1 * fine) * smoothstep(30.0, 44.0, at_m.y + 8.0 * broad);
    dry = mix(dry, vec3(0.82, 0.85, 0.9), snow);
    vec3 albedo = mix(mix(silt, rock, steep), dry, smoothstep(-0.5, 0.15, at_m.y));
    return albedo * (1.0 - 0.45 * smoothstep(0.3, 0.0, at_m.y));  // wet
}

// Of the lamp, as if it were a third of a metre across: finite where it touches.
vec3 lamp_light(vec3 at_m, vec3 normal) {
    vec3 to_lamp = view.lamp_m.xyz - at_m;
    float far2 = dot(to_lamp, to_lamp);
    return view.lamp.rgb * max(dot(normal, to_lamp) * inversesqrt(far2 + 1e-6), 0.0) / (far2 + 0.1);
}

// Stone, or a house with plastered walls, windows and a roof of tiles.
vec3 built_albedo(vec3 at_m, float up, float built, float detail) {
    vec2 face = vec2(at_m.x + at_m.z, at_m.y);  // along walls that follow the axes, and up
    float grain = detail > 0.02 ? detail * fbm(mix(face * 1.3, at_m.xz * 2.3, up), 3) : 0.0;
    vec3 stone = vec3(0.36, 0.35, 0.33) * (1.0 + 0.35 * grain);
    float which = noise(floor(at_m.xz / 9.0) * 1.7);  // houses differ
    vec3 plaster = mix(vec3(0.46, 0.38, 0.28), vec3(0.5, 0.47, 0.41), 0.5 + 0.5 * which) * (1.0 + 0.12 * grain);
    vec2 window = abs(fract(face / vec2(1.8, 2.3) + vec2(0.0, 0.1)) - 0.5);
    plaster = mix(plaster, vec3(0.05, 0.06, 0.08), step(window.x, 0.2) * step(window.y, 0.26) * step(2.4, at_m.y));
    vec3 tiles = mix(vec3(0.34, 0.13, 0.08), vec3(0.42, 0.21, 0.13), 0.5 + 0.5 * which) * (1.0 + 0.25 * grain);
    tiles *= 0.85 + 0.15 * smoothstep(0.1, 0.3, abs(fract(at_m.z * 1.6) - 0.5));
    vec3 house = mix(plaster, tiles, smoothstep(0.4, 0.6, up));
    return mix(stone, house, smoothstep(0.6, 0.9, built));
}

vec3 terrain_lit(vec3 at_m, vec3 normal, vec3 arrives, float detail) {
    vec3 albedo = terrain_albedo(at_m, normal.y, detail);
    if (arrives.z > 0.0) {
        albedo = mix(albedo, built_albedo(at_m, normal.y, arrives.z, detail), smoothstep(0.1, 0.4, arrives.z));
    }
    float sun = max(dot(normal, view.to_sun.xyz), 0.0) * arrives.x;
    vec3 bounce = vec3(0.16, 0.14, 0.1) * (1.0 - 0.5 * normal.y);
    return albedo * (SUN_LIGHT * sun + (SKY_LIGHT * (0.55 + 0.45 * normal.y) + bounce) * arrives.y);
}
