// The slab of a slice, a little larger on both sides: clipping spares the work, and the fragment says to the bit which slice
// it is in, so that no texel is lost or found twice where a driver rounds the cut.
const float CUT_MARGIN = 0.125;  // (cells)

vec2 slice_distances(vec3 place, int slice) {
    float above = turned(place).z - float(slice);
    return vec2(above, 1.0 - above) + CUT_MARGIN;
}
