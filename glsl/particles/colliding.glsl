// Flight in a scene that lies as planes in cells. Between impacts a particle is on a parabola, and so is its distance from a
// plane that moves evenly:
//     x(t) = x + v t + g t^2 / 2,   d(t) = n.(x(t) - c) + d - n.u t
// so the time of an impact, d(t) = R, is a root of a quadratic: energy is kept, whatever the step. There
//     v' = v - (1 + e) min(0, (v - u).n) n,   and friction takes at most mu (1 + e) |(v - u).n| of what slides
// with u the velocity of the surface. The rest of the step goes on, up to eight impacts. Who has come to rest on a plane is
// held there: in `held_pull` gravity and friction act along it.
// CPU twin: particles::cpu_colliding.
#include "particles/particle.glsl"
#define CELLS_OCCUPIED (LAW_BLOCKS + 1)
#define CELLS_PLANES (LAW_BLOCKS + 2)
#define NEAR_BINDING (LAW_BLOCKS + 3)
#include "cells/cells.glsl"
#include "particles/cell_bits.glsl"
#define IMPACTS_BINDING (LAW_BLOCKS + 4)
#define IMPACT_COUNT_BINDING (LAW_BLOCKS + 5)
#define IMPACT_PRODUCER
#include "impact/impact.glsl"
#include "common/random.glsl"

// Mirrors `particles::Colliding`.
struct CollidingLaw {
    Grid grid;
    float gravity_x_mps2;
    float gravity_y_mps2;
    float gravity_z_mps2;
    float radius_m;       // of a particle
    float restitution;    // e, 0 to 1
    float friction;       // mu, 0 or more
    float slack_m;        // how deep a particle may lie in a plane before that counts
    float surface_mps;    // no surface is faster
    float lead_s;         // by how much the cells are ahead of the start of the step
    uint source;          // what impacts say
    uint sources;         // particles take turns: `source`, `source` + 1, ...
    uint respawns;        // 1: below the floor a particle begins anew
    float floor_m;
    float emitter_x_m;    // where it does: as far as the radius from here, at rest
    float emitter_y_m;
    float emitter_z_m;
    float emitter_radius_m;
    uint seed;            // of the directions
};

layout(set = 0, binding = LAW_BINDING, std140) uniform Law { CollidingLaw law; };

const uint METHOD_SEED = 0u;      // look up the cell it is in, push out and reflect
const uint METHOD_APPROACH = 1u;  // the same, unless it is leaving
const uint METHOD_SUBSTEPS = 2u;  // the same, no step longer than a cell
const uint METHOD_ONE = 3u;       // sweep, first plane of a cell
const uint METHOD_TWO = 4u;       // sweep, both
layout(constant_id = LAW_CONSTANT) const uint method = METHOD_TWO;

uint law_tick();
float law_step_s();
uint law_slot();

vec3 gravity_mps2() { return vec3(law.gravity_x_mps2, law.gravity_y_mps2, law.gravity_z_mps2); }

uint source_now() { return law.source + (law.sources > 1u ? law_slot() % law.sources : 0u); }

#include "particles/collide_look.glsl"
#include "particles/collide_seed.glsl"

// Begins anew, somewhere round the emitter, at rest.
void respawn(inout Particle it) {
    vec3 way = direction_of(random_units(random_bits(law.seed, law_slot(), law_tick(), 0u)).xy);
    precise vec3 at = vec3(law.emitter_x_m, law.emitter_y_m, law.emitter_z_m) + way * law.emitter_radius_m;
    it.at_m = at;
    it.velocity_mps = vec3(0.0);
    it.born = law_tick();
}

// Moves who has nothing in the way, and those of the seed's methods; false: it must fly (`colliding_flight.glsl`).
bool advance_at_once(inout Particle it, float dt_s) {
    if (dt_s > 0.0) {
        if (method >= METHOD_ONE) {
            vec3 gravity = gravity_mps2(), from = it.at_m, to = moved(from, it.velocity_mps, gravity, dt_s);
            if (!flies_freely(from, to, gravity)) return false;
            precise vec3 end = it.velocity_mps + gravity * dt_s;
            it.at_m = to;
            it.velocity_mps = end;
        } else {
            step_as_seed(it, dt_s);
        }
    }
    if (law.respawns != 0u && !(it.at_m.y >= law.floor_m)) respawn(it);
    return true;
}
