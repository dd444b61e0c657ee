// Writes the cells that others read: one invocation a cell, 256 a workgroup, whose 8 words of bits are its own.
layout(set = 0, binding = OCCUPIED, std430) writeonly buffer Occupied { uint occupied[]; };
layout(set = 0, binding = PLANES, std430) writeonly buffer Planes { Plane planes[]; };
layout(set = 0, binding = EXTENTS, std430) EXTENTS_ACCESS buffer Extents { uint extents[]; };  // three a cell

shared uint group_bits[8];

// Called by all of a workgroup.
void write_occupied(uint cell, bool is_occupied) {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 8u) group_bits[lane] = 0u;
    barrier();
    if (is_occupied) atomicOr(group_bits[lane >> 5u], 1u << (lane & 31u));
    barrier();
    if (lane < 8u && (cell >> 5u) + lane < uint(occupied.length())) occupied[(cell >> 5u) + lane] = group_bits[lane];
}

// Of what is drawn nothing is known but the plane.
void write_all_extent(uint cell) {
    extents[3u * cell] = EXTENT_ALL;
    extents[3u * cell + 1u] = 0u;
    extents[3u * cell + 2u] = 0u;
}

void write_plane(uint slot, vec3 normal, float distance_m, vec3 velocity_mps, uint triangle) {
    planes[slot].normal = normal;
    planes[slot].distance_m = distance_m;
    planes[slot].velocity_mps = velocity_mps;
    planes[slot].triangle = triangle;
}
