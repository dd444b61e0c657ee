// What of an effect lands in a step, as impacts: an invocation a particle that may. When it lands is counted from an epoch, a
// birth that is the same in whatever step asks, so each lands in just one of steps that follow each other: in (from, to].
// Nothing is stored. Needs the effect's file, which has a ground. CPU twin: ballistic::land::landings.
#include "ballistic/flight.glsl"
#define IMPACTS_BINDING 0
#define IMPACT_COUNT_BINDING 1
#define IMPACT_PRODUCER
#include "impact/impact.glsl"

layout(local_size_x = 64) in;

// Mirrors `ballistic::LandParams`, 64 bytes. `effect` has the rest: of it since_s, newest and births are 0, and where the
// emitter is stands here.
struct Landing {
    vec4 emitter_m;    // xyz: where it was at the epoch, without its circling; w: radius of the circle
    vec2 from_s;       // the step, since the epoch: from, without it; two floats
    vec2 to_s;         // up to, with it
    float turn;        // where on the circle the emitter was at the epoch
    uint epoch;        // serial number of the birth that is the epoch, low and high word
    uint epoch_high;
    uint first;        // births after the epoch: the first that may land
    uint particles;    // of this birth and those after it
    uint before;       // particles that other dispatches of this step have looked at
    uint source;       // of the impacts
    uint reserved;
};

layout(push_constant, std430) uniform Push { Landing p; };

// What `precise` reaches stays in functions like these: glslang, which compiles the effects of users, was seen to run out of
// its stack where it was led from there through a birth.
Wide later(Wide a, float s) {
    precise float high = a.high + s, back = high - a.high, low = (a.high - (high - back)) + (s - back) + a.low;
    precise float sum = high + low, left = low - (sum - high);
    return Wide(sum, left);
}

bool is_after(Wide a, vec2 b) { return a.high > b.x || (a.high == b.x && a.low > b.y); }

float along(vec3 v, vec3 normal) {
    precise float sum = (v.x * normal.x + v.y * normal.y) + v.z * normal.z;
    return sum;
}

void main() {
    uint i = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x;
    if (i >= p.particles) return;
    uint back = p.first + i / effect.burst, carry;
    Who who;
    who.low = uaddCarry(p.epoch, back, carry);
    who.high = p.epoch_high + carry;
    who.member = i % effect.burst;
    Wide since = age_of(back);
    Birth start = birth(who, emitter_before(p.emitter_m, p.turn, Wide(-since.high, -since.low)));

    float end = ground_hit(start);
    if (!(end > 0.0)) return;  // it began in the ground
    float delay_s = max(start.delay_s, 0.0), share = (delay_s + end) * effect.lives_per_s;
    if (!(share < 1.0)) return;  // gone before, or never down
    Wide landed = later(later(since, delay_s), end);
    if (!is_after(landed, p.from_s) || is_after(landed, p.to_s)) return;

    Reach r = reach_of(Wide(end, 0.0), effect.acceleration.w);
    Flight f;
    f.at_m = position(start.at_m, start.velocity_mps, effect.acceleration.xyz, r);
    f.velocity_mps = velocity(start.velocity_mps, effect.acceleration.xyz, r);
    f.age_s = end;
    f.share = share;
    f.down_s = 0.0;
    vec3 v = f.velocity_mps;
    look(who, f);  // what sways lands where it is seen
    vec3 at = vec3(f.at_m.x, ground_height(f.at_m.xz), f.at_m.z), normal = ground_normal(at.xz);
    append_impact(at, normal, v, max(-along(v, normal), 0.0), 0u, 8u * (p.before + i), p.source);
}
