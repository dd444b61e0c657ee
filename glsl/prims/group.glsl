// Sums over a workgroup of 256, in subgroups where the device has their arithmetic (define SUBGROUPS), else in shared
// memory: sixteen invocations add up sixteen values each, then everyone adds up at most sixteen sums.
#ifdef SUBGROUPS
#extension GL_KHR_shader_subgroup_arithmetic : require
shared uint group_sums[256];

// Sum of the values of the invocations before this one, and of all.
uint group_exclusive(uint value, out uint total) {
    uint before = subgroupExclusiveAdd(value);
    uint sum_here = subgroupAdd(value);
    if (subgroupElect()) group_sums[gl_SubgroupID] = sum_here;
    barrier();
    uint base = 0u;
    total = 0u;
    for (uint i = 0u; i < gl_NumSubgroups; ++i) {
        uint sum = group_sums[i];
        if (i < gl_SubgroupID) base += sum;
        total += sum;
    }
    barrier();  // the sums may be written again
    return base + before;
}
#else
shared uint group_values[256 + 16];  // rows of 16, set apart so that rows begin in different banks
shared uint group_sums[16];

uint group_exclusive(uint value, out uint total) {
    uint i = gl_LocalInvocationIndex, row = i >> 4u;
    group_values[i + row] = value;
    barrier();
    if (i < 16u) {
        uint sum = 0u;
        for (uint k = 0u; k < 16u; ++k) {
            uint next = group_values[17u * i + k];
            group_values[17u * i + k] = sum;
            sum += next;
        }
        group_sums[i] = sum;
    }
    barrier();
    uint before = group_values[i + row];
    total = 0u;
    for (uint k = 0u; k < 16u; ++k) {
        uint sum = group_sums[k];
        if (k < row) before += sum;
        total += sum;
    }
    barrier();  // the values may be written again
    return before;
}
#endif
