// Particles as the book stores them: what each began with, and its age. The emitter is no particle: it cannot be crowded
// out. Where a particle is follows when it is drawn. CPU twin: ballistic::cpu.

struct Stored {
    vec4 at_age;    // where its path begins (m), age (s)
    vec4 velocity;  // xyz (m/s); w: nothing yet
};

// Words: how many there are now, how many found no room since the start, and arguments of the next frame's dispatch
// (workgroups) and draw (vertices, instances, first vertex, first instance).
struct Counter { uint count; uint dropped; uint groups_x; uint groups_y; uint groups_z; uint vertices; uint instances; uint first_vertex; uint first_instance; };
