// Of the scan of counts: 4096 cells a workgroup of 256, as four rows of 256 vectors.
layout(local_size_x = 256) in;
const uint ROW = 256u, BLOCK = 4096u;
