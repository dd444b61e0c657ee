// The point of a triangle nearest to another point (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5): of the
// seven regions of corners, sides and face, the one that the point is before. CPU twin: impact::cpu::nearest_weights.

float dotted(vec3 a, vec3 b) {
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

// Weights of the corners: not below 0, together 1. A triangle without area counts as its sides.
vec3 nearest_weights(vec3 at, vec3 a, vec3 b, vec3 c) {
    vec3 ab = b - a, ac = c - a, ap = at - a, bp = at - b, cp = at - c;
    float d1 = dotted(ab, ap), d2 = dotted(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) return vec3(1.0, 0.0, 0.0);
    float d3 = dotted(ab, bp), d4 = dotted(ac, bp);
    if (d3 >= 0.0 && d4 <= d3) return vec3(0.0, 1.0, 0.0);
    precise float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        float w = d1 / (d1 - d3);
        return vec3(1.0 - w, w, 0.0);
    }
    float d5 = dotted(ab, cp), d6 = dotted(ac, cp);
    if (d6 >= 0.0 && d5 <= d6) return vec3(0.0, 0.0, 1.0);
    precise float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        float w = d2 / (d2 - d6);
        return vec3(1.0 - w, 0.0, w);
    }
    precise float va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return vec3(0.0, 1.0 - w, w);
    }
    precise float sum = (va + vb) + vc;
    float v = vb / sum, w = vc / sum;
    return vec3((1.0 - v) - w, v, w);
}
