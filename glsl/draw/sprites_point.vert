#version 460

// One vertex a sprite, for sprites_geom.glsl: all it has is its number.

layout(location = 0) out flat uint number;

void main() {
    number = uint(gl_VertexIndex) + uint(gl_InstanceIndex);
    gl_Position = vec4(0.0);
    gl_PointSize = 1.0;
}
