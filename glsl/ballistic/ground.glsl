// Where a flight ends on a heightmap, or on the water that stands in it. Needs path.glsl. CPU twin: ballistic::ground.

layout(set = 0, binding = GROUND_BINDING, std430) readonly buffer Ground { float ground_m[]; };

float ground_sample(ivec2 c) {
    c = clamp(c, ivec2(0), ivec2(effect.ground_cells) - 1);
    return ground_m[uint(c.y) * effect.ground_cells.x + uint(c.x)];
}

// Ground or water, whichever is higher. Samples lie in the middle of their cells.
float ground_height(vec2 xz_m) {
    precise vec2 grid = (xz_m / effect.ground_size_m + 0.5) * vec2(effect.ground_cells) - 0.5;
    vec2 at = clamp(grid, vec2(0.0), vec2(effect.ground_cells - 1u));
    ivec2 c = ivec2(at);
    precise vec2 f = at - vec2(c);
    precise float south = ground_sample(c) * (1.0 - f.x) + ground_sample(c + ivec2(1, 0)) * f.x;
    precise float north = ground_sample(c + ivec2(0, 1)) * (1.0 - f.x) + ground_sample(c + ivec2(1, 1)) * f.x;
    precise float height = south * (1.0 - f.y) + north * f.y;
    return max(height, effect.water_m);
}

// Of ground_height, unit, upwards.
vec3 ground_normal(vec2 xz_m) {
    if (ground_height(xz_m) <= effect.water_m) return vec3(0.0, 1.0, 0.0);
    precise vec2 grid = (xz_m / effect.ground_size_m + 0.5) * vec2(effect.ground_cells) - 0.5;
    vec2 at = clamp(grid, vec2(0.0), vec2(effect.ground_cells - 1u));
    ivec2 c = ivec2(at);
    precise vec2 f = at - vec2(c), samples_a_m = vec2(effect.ground_cells) / effect.ground_size_m;
    float here = ground_sample(c), east = ground_sample(c + ivec2(1, 0));
    float north = ground_sample(c + ivec2(0, 1)), across = ground_sample(c + ivec2(1, 1));
    precise float along_x = (east - here) * (1.0 - f.y) + (across - north) * f.y;
    precise float along_z = (north - here) * (1.0 - f.x) + (across - east) * f.x;
    precise float x = along_x * samples_a_m.x, z = along_z * samples_a_m.y;
    precise float length = sqrt(1.0 + (x * x + z * z));
    return vec3(-x / length, 1.0 / length, -z / length);
}

// Age at which a flight from `birth` meets the ground (s), 1e30 if it does not fall. It falls to the level under its start
// first, then to the one under where that was, and so on: what is left is the last change of level over the speed of fall,
// and each round multiplies it by the slope of the ground over the slope of the flight. Drag moves the time that gravity
// alone gives: Newton's method, on a path whose curvature has one sign.
float ground_hit(Birth birth) {
    vec3 a = effect.acceleration.xyz;
    float drag = effect.acceleration.w;
    vec2 under = birth.at_m.xz;
    float t = 1e30;
    for (uint round = 0u; round < 6u; ++round) {
        float level = ground_height(under);
        precise float above = birth.at_m.y - level;
        t = fall_time(above, birth.velocity_mps.y, a.y);
        if (t <= 0.0 || t >= 1e30) return t;
        for (uint step = 0u; step < 5u && drag > 0.0; ++step) {
            Reach r = reach_of(Wide(t, 0.0), drag);
            float left = position(vec3(0.0, above, 0.0), birth.velocity_mps, a, r).y;
            float fall = velocity(birth.velocity_mps, a, r).y;
            if (fall >= 0.0) return 1e30;
            precise float next = t - left / fall;
            t = next;
        }
        under = position(birth.at_m, birth.velocity_mps, a, reach_of(Wide(t, 0.0), drag)).xz;
    }
    return t;
}
