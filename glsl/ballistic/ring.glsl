// The ring of an effect that impacts throw: its births, each with its impact, in the order of their serial numbers, which is
// that of their times. The newest take the slots of the oldest. Mirrors of ballistic::{Strike, Ring}; CPU twin:
// ballistic::cpu_kindled.

// 48 bytes.
struct Strike {
    vec3 at_m;          // as in the impact
    uint born_low;      // end of the step that it was in: ticks of 2^-32 s since the start
    vec3 normal;
    uint born_high;
    vec3 velocity_mps;
    float impulse_mps;
};

struct Ring {
    uint next_low;      // serial number of the next birth: so many there have been
    uint next_high;
    uint slot;          // that it takes
    uint step_births;   // of the last step
    uint now_low;       // the moment of `living`: ticks
    uint now_high;
    uint living;        // births that live then, the newest
    uint lost;          // impacts beyond what their source said; since the start
    uint overwritten_low;  // births that lived when others took their slots; since the start
    uint overwritten_high;
    uint twice;         // impacts with the order of another; since the start
    uint quad_vertices;  // indirect draw of six vertices a particle
    uint quad_instances;
    uint quad_first_vertex;
    uint quad_first_instance;
    uint points;        // indirect draw of a vertex a particle
    uint point_instances;
    uint point_first_vertex;
    uint point_first_instance;
    uint groups_x;      // indirect dispatch of 512 particles a workgroup
    uint groups_y;
    uint groups_z;
    uint splat_x;       // indirect dispatch of 128 particles a workgroup
    uint splat_y;
    uint splat_z;
};

// The slot of the birth `back` before the next, 1 to `capacity`, where the next takes `slot`.
uint slot_before(uint slot, uint back, uint capacity) {
    return slot >= back ? slot - back : slot + (capacity - back);
}
