// One invocation an item, also where there are more than one row of workgroups takes.
uint item() { return gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x; }
