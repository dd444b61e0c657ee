// Where in a cell its planes stand for a triangle: what is left of that in the cell, as a box, and wider by as far as it lies off
// the plane that it is nearest to. On a surface that bends, that is a little. What lies farther off both planes than STANDS_FOR
// is told apart, for those who look for a third plane beside the cell. There need be none: so a plane that is parallel goes
// on there as well, and who comes is stopped a little late, as on stairs whose steps are lower than a cell.
layout(set = 0, binding = 2, std430) readonly buffer Normals { vec4 normals[]; };
layout(set = 0, binding = 3, std430) readonly buffer FirstKeys { uint first_keys[]; };
layout(set = 0, binding = 4, std430) readonly buffer StillKeys { uvec2 still_keys[]; };
layout(set = 0, binding = 5, std430) readonly buffer SecondKeys { uint second_keys[]; };
layout(set = 0, binding = 6, std430) buffer Extents { uint extents[]; };

const float STANDS_FOR = 0.15;  // of a plane, what is no farther off it (cells)
const float WIDER = 0.02;       // (cells)
const float ALIKE = 0.985;      // cosine of 10 degrees

// Half of the box that is cut by, larger than what overlaps by rounding (cells).
float cut_half() { return 0.501 + tri_slack; }

// From the centre of the cell (cells): planes as a normal and how far the centre is along it, and what has been found.
struct Part {
    vec4 one, two;  // a second that is not there is 9 cells off everything
    vec3 low, high;
    float off_one, off_two;
};

void take(vec3 at, inout Part part) {
    part.low = min(part.low, at);
    part.high = max(part.high, at);
    part.off_one = max(part.off_one, abs(dot(part.one.xyz, at) + part.one.w));
    part.off_two = max(part.off_two, abs(dot(part.two.xyz, at) + part.two.w));
}

// The ends of what is left of an edge.
void take_edge(vec3 from, vec3 way, inout Part part) {
    float side = cut_half();
    vec3 per = 1.0 / mix(way, vec3(1e-30), lessThan(abs(way), vec3(1e-30)));
    vec3 one = (-side - from) * per, other = (side - from) * per;
    vec3 enters = min(one, other), leaves = max(one, other);
    float first = max(max(enters.x, enters.y), max(enters.z, 0.0));
    float last = min(min(leaves.x, leaves.y), min(leaves.z, 1.0));
    if (first > last) return;
    take(from + first * way, part);
    take(from + last * way, part);
}

float across(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

// The next axis becomes z; after three turns all is as it was.
void turn(inout Part part) {
    part.one.xyz = part.one.yzx;
    part.two.xyz = part.two.yzx;
    part.low = part.low.yzx;
    part.high = part.high.yzx;
}

// Where the edges of the cell along z go through the triangle.
void take_rims(vec3 a, vec3 b, vec3 c, vec3 normal, inout Part part) {
    if (abs(normal.z) < 1e-6) return;  // its own edges say it
    for (uint k = 0u; k < 4u; ++k) {
        vec2 at = cut_half() * (2.0 * vec2(k & 1u, k >> 1u) - 1.0);
        vec3 sides = vec3(across((b - a).xy, at - a.xy), across((c - b).xy, at - b.xy),
                          across((a - c).xy, at - c.xy));
        float z = a.z - dot(normal.xy, at - a.xy) / normal.z;
        bool is_in = all(greaterThanEqual(sides, vec3(0.0))) || all(lessThanEqual(sides, vec3(0.0)));
        if (is_in && abs(z) <= cut_half()) take(vec3(at, z), part);
    }
}

// What of the triangle is in the cell. Most triangles of a fine mesh are small beside a cell: in it, or through one of its faces.
void take_triangle(vec3 a, vec3 b, vec3 c, inout Part part) {
    vec3 side = vec3(cut_half());
    bvec3 below = lessThan(min(min(a, b), c), -side), above = greaterThan(max(max(a, b), c), side);
    if (!any(below) && !any(above)) {
        take(a, part);
        take(b, part);
        take(c, part);
        return;
    }
    take_edge(a, b - a, part);
    take_edge(a, c - a, part);
    take_edge(b, c - b, part);
    uvec3 through = uvec3(below) | uvec3(above);  // faces across an axis
    if (through.x + through.y + through.z < 2u) return;
    vec3 normal = tri_normal;
    for (uint axis = 0u; axis < 3u; ++axis) {
        a = a.yzx;
        b = b.yzx;
        c = c.yzx;
        normal = normal.yzx;
        through = through.yzx;
        turn(part);
        if (through.x + through.y == 2u) take_rims(a, b, c, normal, part);
    }
}

vec4 plane_from(uint key, vec3 centre) {
    vec4 plane = normals[key_triangle(key)];
    return vec4(plane.xyz, dot(plane.xyz, centre) - plane.w);
}

// Bits are only set: one that is read late is at worst set once more.
void set_bits(uint word, Part part, vec3 wider) {
    uint extent = extent_of(part.low - wider, part.high + wider);
    if ((extents[word] & extent) != extent) atomicOr(extents[word], extent);
}

// Keys of the planes of a cell; no first: it is empty.
uvec2 keys_of(uint i) {
    uint first = first_keys[i];
    return uvec2(first, second_with(first, second_keys[i], still_keys[i]));
}

// Whether it is any use to `extend` a cell by a triangle.
bool is_asked(uint t, ivec3 cell) {
    uint i = cell_index(p.grid, cell);
    uvec2 keys = keys_of(i);
    bool has_second = keys.y != EMPTY;
    if (keys.x == EMPTY || (p.only_changed != 0u && keys == still_keys[i])) return false;
    // Not asked again of the two that won: compiled elsewhere, the same sum may be rounded otherwise.
    return key_triangle(keys.x) == t || (has_second && key_triangle(keys.y) == t) || overlaps(cell);
}

void extend(ivec3 cell) {
    uint i = cell_index(p.grid, cell);
    uvec2 keys = keys_of(i);
    bool has_second = keys.y != EMPTY;
    vec3 centre = vec3(cell) + 0.5;
    vec4 two = has_second ? plane_from(keys.y, centre) : vec4(0.0, 0.0, 0.0, 9.0);
    Part part = Part(plane_from(keys.x, centre), two, vec3(9.0), vec3(-9.0), 0.0, 0.0);
    vec3 a = tri_a - centre;
    take_triangle(a, a + tri_ab, a + tri_ac, part);
    if (part.low.x > part.high.x) {  // it touches the cell, but for rounding
        vec2 shares = nearest_shares(-a);
        take(clamp(a + shares.x * tri_ab + shares.y * tri_ac, -cut_half(), cut_half()), part);
    }
    uint slot = part.off_two < part.off_one ? 1u : 0u;
    float off = min(part.off_one, part.off_two);
    vec3 n = slot == 0u ? part.one.xyz : part.two.xyz;
    bool is_told_apart = off > STANDS_FOR && has_second;
    set_bits(3u * i + (is_told_apart ? 2u : slot), part, abs(n) * min(off, STANDS_FOR) + WIDER);
    if (!is_told_apart) return;
    if (abs(dot(part.one.xyz, tri_normal)) > ALIKE) set_bits(3u * i, part, abs(part.one.xyz) * part.off_one + WIDER);
    if (abs(dot(part.two.xyz, tri_normal)) > ALIKE) set_bits(3u * i + 1u, part, abs(part.two.xyz) * part.off_two + WIDER);
}
