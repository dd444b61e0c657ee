// Linear drag and a constant pull, in closed form: v' = pull - drag v, exactly, whatever the step.
//     v(t) = v0 e + pull s,  x(t) = x0 + v0 s + pull (t - s) / drag,  with e = exp(-drag t), s = (1 - e) / drag
// For a small drag t both differences cancel: there they are series. CPU twin: particles::cpu::Drag.
#include "particles/particle.glsl"

// Mirrors `particles::Drag`.
struct DragLaw {
    float pull_x;      // (m/s^2)
    float pull_y;
    float pull_z;
    float drag_per_s;  // (1/s), 0 or more
};

layout(set = 0, binding = LAW_BINDING, std140) uniform Law { DragLaw law; };

// (1 - exp(-x)) / x and (x - 1 + exp(-x)) / x^2.
vec2 faded(float x) {
    if (x < 0.25) {  // Taylor; what is left out is below 5e-8
        precise float first =
            1.0 + x * (-0.5 + x * (1.0 / 6.0 + x * (-1.0 / 24.0 + x * (1.0 / 120.0 + x * (-1.0 / 720.0)))));
        precise float second =
            0.5 + x * (-1.0 / 6.0 + x * (1.0 / 24.0 + x * (-1.0 / 120.0 + x * (1.0 / 720.0 + x * (-1.0 / 5040.0)))));
        return vec2(first, second);
    }
    float first = (1.0 - exp(-x)) / x;
    return vec2(first, (1.0 - first) / x);
}

bool advance(inout Particle it, float dt_s) {
    vec3 pull = vec3(law.pull_x, law.pull_y, law.pull_z);
    precise float x = law.drag_per_s * dt_s;
    vec2 f = faded(x);
    precise float s = f.x * dt_s;
    precise float ss = f.y * dt_s * dt_s;
    precise vec3 at = it.at_m + (it.velocity_mps * s + pull * ss);
    precise vec3 velocity = it.velocity_mps + (pull - it.velocity_mps * law.drag_per_s) * s;
    it.at_m = at;
    it.velocity_mps = velocity;
    return true;
}
