// Appending, one atomic a workgroup: particles count themselves in shared memory, one invocation reserves for all. Every
// invocation must come here. Needs stored.glsl and the blocks `After` and `Counts` of the pass.

shared uint appended;
shared uint first_of_group;

void append(bool is_there, Stored stored, uint capacity) {
    if (gl_LocalInvocationIndex == 0u) appended = 0u;
    barrier();
    uint rank = is_there ? atomicAdd(appended, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u && appended > 0u) first_of_group = atomicAdd(counter.count, appended);
    barrier();
    if (!is_there) return;
    uint i = first_of_group + rank;
    if (i < capacity) after[i] = stored;
}
