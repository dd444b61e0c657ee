#version 460
// Places and velocities of the vertices of a mesh: each is the mean, by weight, of where its joints would take it.
//     at = sum of w_j M_j x,  velocity = rate (sum of w_j B_j x  -  sum of w_j A_j x)
// with M the joints now, and A and B those of two times whose difference is the velocity. CPU twin: mesh::cpu::pose.

layout(local_size_x = 64) in;

// Mirrors `mesh::PoseParams`.
struct PoseParams {
    uint vertices;
    uint joints;
    float rate_per_s;
    uint first_vertex;  // of the mesh, where several share the buffers
    uint first_joint;
};

layout(set = 0, binding = 0, std430) readonly buffer Rest { uint rest[]; };             // 13 words a vertex
layout(set = 0, binding = 1, std430) readonly buffer Matrices { vec4 matrix_rows[]; };  // three rows a joint: M, A, B
layout(set = 0, binding = 2, std430) writeonly buffer Places { float places[]; };       // at (m), velocity (m/s)

layout(push_constant, std430) uniform Push { PoseParams p; };

// In three dimensions one row is one coordinate: columns are summed in the order of the twin.
vec3 placed(uint pose, uint joint, vec3 at) {
    uint row = 3u * (3u * p.first_joint + pose * p.joints + joint);
    vec4 a = matrix_rows[row], b = matrix_rows[row + 1u], c = matrix_rows[row + 2u];
    precise vec3 sum = ((vec3(a.x, b.x, c.x) * at.x + vec3(a.y, b.y, c.y) * at.y) + vec3(a.z, b.z, c.z) * at.z) + vec3(a.w, b.w, c.w);
    return sum;
}

vec3 held(uint pose, vec3 at, uvec4 joints, vec4 weights) {
    precise vec3 sum = placed(pose, joints.x, at) * weights.x;
    if (weights.y > 0.0) sum += placed(pose, joints.y, at) * weights.y;
    if (weights.z > 0.0) sum += placed(pose, joints.z, at) * weights.z;
    if (weights.w > 0.0) sum += placed(pose, joints.w, at) * weights.w;
    return sum;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= p.vertices) return;
    i += p.first_vertex;
    uint word = 13u * i;
    vec3 at = uintBitsToFloat(uvec3(rest[word], rest[word + 1u], rest[word + 2u]));
    uvec4 joints = uvec4(rest[word + 8u], rest[word + 8u] >> 16u, rest[word + 9u], rest[word + 9u] >> 16u) & 0xffffu;
    vec3 three = uintBitsToFloat(uvec3(rest[word + 10u], rest[word + 11u], rest[word + 12u]));
    precise float left = 1.0 - (three.x + three.y + three.z);
    vec4 weights = vec4(three, max(left, 0.0));
    vec3 now = held(0u, at, joints, weights);
    vec3 velocity = p.rate_per_s == 0.0 ? vec3(0.0) : (held(2u, at, joints, weights) - held(1u, at, joints, weights)) * p.rate_per_s;
    for (uint k = 0u; k < 3u; ++k) {
        places[6u * i + k] = now[k];
        places[6u * i + 3u + k] = velocity[k];
    }
}
