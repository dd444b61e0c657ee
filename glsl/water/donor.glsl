// How water moves between columns, none of which gives more than it has: for `wet` and `shallow`.
//     moved = dt / dx * flow,  K = min(1, depth / sum of what moves out),  moved' = K of the donor * moved
//     rise' = rise + moved'_west - moved'_east + moved'_north - moved'_south + rain
// What moves is rounded to units that both columns can hold, so that what one loses the other gains, to the bit.

// K of a column that must give less than its flows ask for: less than all, so that rounding leaves no debt.
const float MOST = 1.0 - 1.0 / 1048576.0;

// A multiple of the last place of the larger rise: added to either, it is not rounded again.
float in_whole_units(float moved, float rise_a, float rise_b) {
    float size = max(abs(rise_a), abs(rise_b));
    precise float whole = (moved + size) - size;
    return whole;
}

float share(float depth, float west, float east, float north, float south) {
    precise float gone = (max(east, 0.0) + max(-west, 0.0)) + (max(south, 0.0) + max(-north, 0.0));
    precise float most = MOST * depth;
    precise float limited = most / gone;
    return gone > most ? limited : 1.0;
}

float limited(float flow, float share_a, float share_b) {
    precise float limited = flow * (flow > 0.0 ? share_a : share_b);
    return limited;
}

// The same of four columns.
vec4 in_whole_units(vec4 moved, vec4 rise_a, vec4 rise_b) {
    vec4 size = max(abs(rise_a), abs(rise_b));
    precise vec4 whole = (moved + size) - size;
    return whole;
}

vec4 share(vec4 depth, vec4 west, vec4 east, vec4 north, vec4 south) {
    return vec4(share(depth.x, west.x, east.x, north.x, south.x), share(depth.y, west.y, east.y, north.y, south.y),
                share(depth.z, west.z, east.z, north.z, south.z), share(depth.w, west.w, east.w, north.w, south.w));
}

vec4 limited(vec4 flow, vec4 share_a, vec4 share_b) {
    precise vec4 limited = flow * mix(share_b, share_a, greaterThan(flow, vec4(0.0)));
    return limited;
}
