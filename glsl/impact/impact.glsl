// The impact stream: what hits what, from those who move to those who paint, splash or count.
//
// A producer defines IMPACTS_BINDING, IMPACT_COUNT_BINDING and IMPACT_PRODUCER, includes this and calls `append_impact`. A
// consumer leaves IMPACT_PRODUCER out and reads `impacts[i]` for i below `impact_count.count`: workgroups of 64 come from
// `impact_count.groups_x` and after. Impacts lie as they come, in no order; whoever needs the same bits again and again goes
// by `order`. CPU twin: impact::cpu.
#ifndef IMPACT_GLSL
#define IMPACT_GLSL

// Mirrors `impact::Impact`, 64 bytes.
struct Impact {
    vec3 at_m;  // where they touch, on the surface
    uint order;  // place of the particle in its step, times 8, plus the number of the bounce: tells all impacts of a step apart
    vec3 normal;  // of the surface, unit, towards the particle
    float impulse_mps;  // change of the velocity along it: impulse a mass
    vec3 velocity_mps;  // of the particle before, seen from the surface
    uint triangle;      // of all meshes' one after the other, plus 1; 0: none (water, terrain)
    float u;            // texture coordinates, once `impact.locate` has run
    float v;
    uint mesh;    // likewise; NO_MESH: none
    uint source;  // who threw the particle, as the law's numbers say
};

// Mirrors `impact::Count`. All but `appended` is what `impact.close` has made of the last step.
struct ImpactCount {
    uint count;         // impacts that are stored
    uint capacity;      // most of a step
    uint dropped_low;   // for which there was no room, since the start: low word, high word
    uint dropped_high;
    uint groups_x;      // indirect dispatch of workgroups of 64, an invocation an impact
    uint groups_y;
    uint groups_z;
    uint appended;      // of the step under way, stored or not
    uint quad_vertices;  // indirect draw of six vertices an impact: `gl_VertexIndex / 6` is its number
    uint quad_instances;
    uint quad_first_vertex;
    uint quad_first_instance;
    uint stored_low;    // since the start
    uint stored_high;
};

const uint NO_MESH = 0xffffffffu;
const uint IMPACT_GROUP = 64u;

#ifndef IMPACTS_ACCESS
#ifdef IMPACT_PRODUCER
#define IMPACTS_ACCESS writeonly
#else
#define IMPACTS_ACCESS readonly
#endif
#endif
#ifndef IMPACT_COUNT_ACCESS
#ifdef IMPACT_PRODUCER
#define IMPACT_COUNT_ACCESS
#else
#define IMPACT_COUNT_ACCESS readonly
#endif
#endif

#ifdef IMPACTS_BINDING
layout(set = 0, binding = IMPACTS_BINDING, std430) IMPACTS_ACCESS buffer Impacts { Impact impacts[]; };
#endif
layout(set = 0, binding = IMPACT_COUNT_BINDING, std430) IMPACT_COUNT_ACCESS buffer Count { ImpactCount impact_count; };

#ifdef IMPACT_PRODUCER
// Stores it, or counts it as dropped if the step has had as many as there is room for.
void append_impact(vec3 at_m, vec3 normal, vec3 velocity_mps, float impulse_mps, uint triangle, uint order, uint source) {
    uint i = atomicAdd(impact_count.appended, 1u);
    if (i >= impact_count.capacity) return;
    impacts[i].at_m = at_m;
    impacts[i].order = order;
    impacts[i].normal = normal;
    impacts[i].impulse_mps = impulse_mps;
    impacts[i].velocity_mps = velocity_mps;
    impacts[i].triangle = triangle;
    impacts[i].u = 0.0;
    impacts[i].v = 0.0;
    impacts[i].mesh = NO_MESH;
    impacts[i].source = source;
}
#endif

#endif
