// A wall across an axis: elastic, and exact under a constant pull. CPU twin: `bounce` in disks::cpu.
//
// y: how far inside the end of a step is, below 0 here (m); v: speed inwards; pull: acceleration inwards. The speed at the
// wall is what energy says, and from there the flight goes on for the time that was left; a pull into the wall brings it
// back as often as that takes. A mirror would do without a pull; with one it lifts by 2 |y| for nothing, each time.
// Returns the change of speed at the wall (m/s).
float bounce(inout float y, inout float v, float pull) {
    if (pull == 0.0) {
        float change = 2.0 * max(-v, 0.0);
        y = -y;
        v = abs(v);
        return change;
    }
    float square = v * v - 2.0 * pull * y;
    float speed = sqrt(max(square, 0.0)), since_s = 0.0, change = max(speed - v, 0.0);
    if (v < 0.0 && speed > 0.0) {
        since_s = -2.0 * y / (speed - v);
        change = 2.0 * speed;
        if (pull < 0.0) {
            float turn_s = -2.0 * speed / pull, turns = floor(since_s / turn_s);
            since_s = clamp(since_s - turns * turn_s, 0.0, turn_s);
            change += turns * change;
        }
    }
    y = max((speed + 0.5 * pull * since_s) * since_s, 0.0);  // at the wall if something pushed it there
    v = speed + pull * since_s;
    return change;
}

// The two walls of an axis, for a centre between low and high; nobody is put beyond the other one.
float between_walls(inout float at, inout float velocity, float low, float high, float pull) {
    float change = 0.0, y = at - low, v = velocity;
    if (y < 0.0) {
        change = bounce(y, v, pull);
        at = min(low + y, high);
        velocity = v;
    } else if (at > high) {
        y = high - at;
        v = -v;
        change = bounce(y, v, -pull);
        at = max(high - y, low);
        velocity = -v;
    }
    return change;
}
