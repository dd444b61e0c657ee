// Offers a triangle as the second plane of a cell: of those that overlap it, the one whose normal differs most from the
// first plane's, if by more than 10 degrees; or, where all are parallel, another plane. What is asked first is what costs
// least: on a smooth surface hardly any overlap is tested here.
layout(set = 0, binding = 2, std430) readonly buffer Normals { vec4 normals[]; };
layout(set = 0, binding = 3, std430) readonly buffer FirstKeys { uint first_keys[]; };
layout(set = 0, binding = 4, std430) readonly buffer StillKeys { uvec2 still_keys[]; };
layout(set = 0, binding = 5, std430) buffer SecondKeys { uint second_keys[]; };

const float COS_OTHER = 0.98480775;     // 10 degrees
const float COS_PARALLEL = 0.99984770;  // 1 degree
const float APART = 0.0625;             // of parallel planes, at the centre of the cell (cells)

void offer(uint t, ivec3 cell) {
    uint i = cell_index(p.grid, cell), first = first_keys[i];
    if (first == EMPTY || key_triangle(first) == t) return;
    if (p.only_changed != 0u && first == still_keys[i].x) return;
    vec4 mine = normals[t], other = normals[key_triangle(first)];
    float cosine = dot(mine.xyz, other.xyz);
    if (cosine >= COS_OTHER) {
        vec3 centre = vec3(cell) + 0.5;
        float apart = abs((dot(mine.xyz, centre) - mine.w) - (dot(other.xyz, centre) - other.w));
        if (cosine < COS_PARALLEL || apart < APART) return;
    }
    uint key = key_of(0.5 + 0.5 * cosine, t);
    if (key < second_keys[i] && overlaps(cell)) atomicMin(second_keys[i], key);
}
