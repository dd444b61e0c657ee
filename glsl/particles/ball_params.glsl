// Mirrors `particles::balls::BallParams`.
struct BallParams {
    vec4 color;      // linear albedo; w: radius (m)
    vec4 far_color;  // colours are between the two, by the time of birth; w: how much of the sun is mirrored
};

layout(push_constant, std430) uniform Push { BallParams p; };
