// Those whom a law puts off (LAW_DEFERS): where `advance` has written them, for `advance_deferred` to move. It is the first of
// the law's own blocks.
#ifndef DEFERRED_BINDING
#define DEFERRED_BINDING LAW_BLOCKS
#endif

struct DeferredOne {
    uint place;  // where it lies now
    uint slot;   // what it was in this step: `law_slot`
    float dt_s;  // of the step, or what is left of it at its birth
};

layout(set = 0, binding = DEFERRED_BINDING, std430) buffer Deferred {
    uint groups_x;  // indirect dispatch of workgroups of DEFERRED_GROUP, which take turns if they are too many
    uint groups_y;
    uint groups_z;
    uint count;
    DeferredOne list[];
} deferred;

const uint DEFERRED_GROUP = 64u;
const uint MOST_DEFERRED_GROUPS = 65535u;
