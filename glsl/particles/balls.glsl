// A pool drawn as balls: quads that face the eye, as wide as the outline of a ball, on which the fragment shader finds the
// ball. BALLS_BINDING: of the pool.
#define POOL_BINDING BALLS_BINDING
#define PARTICLES_BINDING (BALLS_BINDING + 1)
#include "particles/pool.glsl"
#include "common/random.glsl"
#include "particles/ball_params.glsl"

// Six vertices a slot: the ball of this one, if there is one. `corner`: -1 to 1 over the quad.
bool ball_of(out Particle particle, out vec2 corner) {
    uint at = uint[6](0u, 1u, 2u, 2u, 1u, 3u)[uint(gl_VertexIndex) % 6u], i = uint(gl_VertexIndex) / 6u;
    corner = vec2(at & 1u, at >> 1u) * 2.0 - 1.0;
    return i < pool.slots && particle_at(i, particle);
}
