// What the last step left to be done for each disk, then a step forward, and the count of each cell.
//     seed:      out of every overlap by 0.51 of it; one contact that is the only one of both is elastic, several reverse
//     matching:  out of what still overlaps, the lighter one more, by a radius at most
//     all:       x' = x + v dt + g dt^2 / 2,  v' = v + g dt,  then walls (disks/walls.glsl), or led round
// CPU twin: disks::cpu::Disks::travel.
#include "disks/disks.glsl"
#include "disks/box.glsl"
#include "disks/walls.glsl"
layout(constant_id = 3) const uint RESPONSE = 0u;
layout(constant_id = 4) const bool MEASURES = false;

layout(set = 0, binding = 0, std430) readonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Motion { Motion_t motion[]; };
layout(set = 0, binding = 2, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 3, std430) readonly buffer Partner { uint partner[]; };
layout(set = 0, binding = 4, std430) buffer Wake { uint wake[]; };
layout(set = 0, binding = 5, std430) writeonly buffer NewPlace { vec4 new_place_m[]; };
layout(set = 0, binding = 6, std430) writeonly buffer NewMotion { Motion_t new_motion[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Key { uvec2 key[]; };  // cell, rank in it
layout(set = 0, binding = 8, std430) buffer Count { uint count[]; };
layout(set = 0, binding = 9, std430) buffer Impulse { vec2 impulse[]; };     // by id: of pairs times distance, of walls

#include "disks/contact.glsl"

const uint SEED = 0u, GAUSS_SEIDEL = 1u, MATCHING = 2u;
const float RELAX = 0.5;  // part of an overlap that a step takes away: with more, dense layers swing
const uint CROWD = DIMENSIONS == 2 ? 6u : 12u;  // disks of one size that can touch another: who has more flees

vec4 place;
uint id;
vecd push_m = vecd(0.0);
uint contacts = 0u;

void meet(uint k) {
    vec4 other = place_m[k];
    vecd d = way(at_of(place), at_of(other));
    float far = length(d), radius = radius_of(place), reach = radius + radius_of(other);
    if (far >= reach) return;
    ++contacts;
    if (RESPONSE == SEED) {
        push_m -= d / far * (0.51 * (reach - far));
    } else {
        float mass = mass_of(radius), other_mass = mass_of(radius_of(other));
        push_m -= axis_of(d, reach, id, id_of(other, motion[k])) * (RELAX * other_mass / (mass + other_mass) * (reach - far));
    }
}

#include "disks/neighbours.glsl"

void main() {
    uint i = item();
    if (i >= p.disks) return;
    place = place_m[i];
    Motion_t moves = motion[i];
    id = id_of(place, moves);
    float radius = radius_of(place);
    vecd at = at_of(place), velocity = velocity_of(moves);

    if (RESPONSE == SEED) {
        uint k = partner[i];
        if (k != NONE) {
            visit(i, place);
            at += push_m;
            if (k == MANY) {
                velocity = -velocity;
            } else if (partner[k] == i) {
                vec4 other = place_m[k];
                vecd n = normalize(way(at_of(place), at_of(other)));
                float mass = mass_of(radius), other_mass = mass_of(radius_of(other));
                velocity += n * (2.0 * other_mass / (mass + other_mass) * dot(n, velocity_of(motion[k]) - velocity));
            }
        }
    } else if (RESPONSE == MATCHING) {
        bool is_awake = wake[i] != 0u;
        if (is_awake) wake[i] = 0u;
        if (is_awake || partner[i] != NONE) {
            visit(i, place);
            float far = length(push_m);
            bool is_crowded = contacts > CROWD && !(HAS_LARGE && i < p.large) && far > 0.0;
            if (far > radius || is_crowded) push_m *= radius / far;
            at += push_m;
        }
    }

    if (p.stir_mps2 != 0.0) {
        vecd from = way(vecd(p.stir_at_m), at);
        float far = length(from);
        if (far < p.stir_at_m.w && far > 0.0) {
            // No faster than steps are cut for, or as fast as it is.
            float most = max(p.gravity_mps2.w, length(velocity));
            velocity += from * (p.stir_mps2 * p.dt_s * (1.0 / far - 1.0 / p.stir_at_m.w));
            float fast = length(velocity);
            if (fast > most) velocity *= most / fast;
        }
    }
    vecd pull = vecd(p.gravity_mps2) * p.dt_s;
    at += (velocity + 0.5 * pull) * p.dt_s;
    velocity += pull;

    vecd box = box_m();
    if (PERIODIC) {
        at -= box * floor(at / box);
    } else {
        float sum = 0.0;
        for (int axis = 0; axis < DIMENSIONS; ++axis) {
            sum += between_walls(at[axis], velocity[axis], radius, box[axis] - radius, p.gravity_mps2[axis]);
        }
        if (MEASURES && sum > 0.0) impulse[id].y += mass_of(radius) * sum;
    }
    new_place_m[i] = place_of(at, radius, id);
    new_motion[i] = motion_of(velocity, id);
    if (HAS_LARGE && i < p.large) return;
    uint cell = cell_index(cell_of(at));
    key[i] = uvec2(cell, atomicAdd(count[cell], 1u));
}
