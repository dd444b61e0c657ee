// Heights of water over ground for drawing. Needs water/surface.glsl, whose heights are the rise of each column; see
// water/depth.glsl for what is stored.

layout(set = 0, binding = 5, std430) readonly buffer Bed { float bed_m[]; };

const float WALL_M = 1.0e30;
const float FILM_M = 2.0e-4;  // less water is not seen (m)

struct Column {
    float bed;      // above the level at rest (m)
    float depth;    // (m)
    float surface;  // above the level at rest (m)
    bool is_wet;
};

Column column_at(ivec2 c) {
    c = clamp(c, ivec2(0), ivec2(p.cells) - 1);
    uint i = uint(c.y) * p.pitch + uint(c.x);
    float bed = bed_m[i], rise = height_m[i];
    float depth = max(max(-bed, 0.0) + rise, 0.0);
    return Column(bed, depth, max(bed, 0.0) + max(rise, -max(-bed, 0.0)), bed < WALL_M && depth > FILM_M);
}

// Height of the vertex in a column. A dry one takes the mean surface of the water beside it, but lies below its ground: so
// the surface runs into a bank or a wall and is cut off there by the ground, without a gap, and where a flood comes over
// dry ground its front is a wedge. Farther from water it lies below the ground, unseen.
float drawn_height(ivec2 c, Column here) {
    if (here.is_wet) return here.surface;
    float sum = 0.0, count = 0.0, lowest = WALL_M;
    for (int k = 0; k < 9; ++k) {
        Column other = column_at(c + ivec2(k % 3, k / 3) - 1);
        lowest = min(lowest, other.bed);
        if (other.is_wet) {
            sum += other.surface;
            count += 1.0;
        }
    }
    float under = 0.02 * p.size_m.x / float(p.cells.x);
    if (count > 0.0) return min(sum / count, here.bed - under);
    return lowest < WALL_M ? lowest - under : 0.0;
}
