// Four columns of a row and the one on either side.
struct Row {
    float west;
    vec4 mid;
    float east;
};
