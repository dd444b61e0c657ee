// What a box with walls, or one that repeats, is to disks.

layout(constant_id = 1) const bool PERIODIC = false;

// From one point to another, the short way round.
vecd way(vecd from_m, vecd to_m) {
    vecd d = to_m - from_m;
    if (PERIODIC) d -= box_m() * round(d / box_m());
    return d;
}
