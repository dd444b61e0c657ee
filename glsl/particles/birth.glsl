// Births: when, where to, how fast. CPU twin: particles::cpu::birth.
#include "common/random.glsl"

// A rotation, all alike, of three units (Shoemake, "Uniform Random Rotations", Graphics Gems III, 1992).
vec3 turned(vec3 v, vec3 units) {
    precise float a = sqrt(1.0 - units.x);
    precise float b = sqrt(units.x);
    vec2 one = cos_sin_of_turn(units.y), other = cos_sin_of_turn(units.z);
    precise vec4 q = vec4(a * one.y, a * one.x, b * other.y, b * other.x);
    precise vec3 t = 2.0 * vec3(q.y * v.z - q.z * v.y, q.z * v.x - q.x * v.z, q.x * v.y - q.y * v.x);
    precise vec3 u = vec3(q.y * t.z - q.z * t.y, q.z * t.x - q.x * t.z, q.x * t.y - q.y * t.x);
    precise vec3 w = v + (q.w * t + u);
    return w;
}

// Unit vector of the particle `serial`.
vec3 way_of(Emitter emitter, uint serial) {
    if (emitter.corners == 1u) {
        vec3 corner = vec3((serial & 1u) == 0u ? -1.0 : 1.0, (serial & 2u) == 0u ? -1.0 : 1.0,
                           (serial & 4u) == 0u ? -1.0 : 1.0) * 0.57735027;
        return turned(corner, random_units(random_bits(p.seed, emitter.stream, serial >> 3u, 1u)).xyz);
    }
    return direction_of(random_units(random_bits(p.seed, emitter.stream, serial, 0u)).xy);
}

// Birth `local` of this step by one emitter, at the moment of birth; `left_s` is what is left of the step then.
Particle birth_of(Emitter emitter, EmitterState state, uint local, out float left_s) {
    uint batch = local / emitter.batch;
    uint high, low, carry;
    umulExtended(batch, emitter.period_low, high, low);
    low = uaddCarry(low, state.from_low, carry);
    uint tick = high + batch * emitter.period_high + state.from_high + carry;
    // Both terms are exact: 24 bits.
    precise float left = (float(p.now - tick) - float(low >> 8u) * (1.0 / 16777216.0)) * (1.0 / 65536.0);
    left_s = left;
    vec3 drift = vec3(emitter.velocity_x_mps, emitter.velocity_y_mps, emitter.velocity_z_mps);
    vec3 way = way_of(emitter, state.from_serial + local);
    precise vec3 velocity = drift + way * emitter.speed_mps;
    precise vec3 at = vec3(emitter.at_x_m, emitter.at_y_m, emitter.at_z_m) - drift * left;
    return Particle(at, velocity, tick);
}
