#version 460

// Damps the strips along absorbing borders, after a step of water.waves or water.fourth: that step's velocity keeps a
// share e of itself, and the height takes back what the rest had moved. Nothing else is read or written, so the kernels
// of the step know nothing of it. One dispatch for each rectangle that the strips are made of; CPU twin:
// water::cpu_absorb::absorb.

layout(local_size_x = 32, local_size_y = 4) in;

layout(set = 0, binding = 0, std430) buffer Height { float height_m[]; };
layout(set = 0, binding = 1, std430) buffer Velocity { float velocity_mps[]; };
layout(set = 0, binding = 2, std430) readonly buffer Keep { float keep[]; };  // by columns from the border

// Mirrors `water::AbsorbParams`.
layout(push_constant, std430) uniform Push {
    uvec2 cells;   // size of the grid
    uvec2 origin;  // of the rectangle
    uvec2 size;    // of the rectangle
    uint pitch;    // columns from one row to the next
    uint strip;    // width of a strip (columns)
    uint sides;    // bits: west, east, north, south
    float dt_s;    // step (s)
} p;

float kept(uint from_border, uint side) {
    return (p.sides & side) != 0u && from_border < p.strip ? keep[from_border] : 1.0;
}

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, p.size))) return;
    uvec2 c = p.origin + gl_GlobalInvocationID.xy, back = p.cells - 1u - c;
    precise float e = (kept(c.x, 1u) * kept(back.x, 2u)) * (kept(c.y, 4u) * kept(back.y, 8u));
    uint i = c.y * p.pitch + c.x;
    precise float v = velocity_mps[i];
    precise float slower = e * v;
    precise float h = height_m[i] - p.dt_s * (v - slower);
    velocity_mps[i] = slower;
    height_m[i] = h;
}
