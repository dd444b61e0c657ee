#version 460

// A disc: what of its own ball it would shade is behind it. Nothing but depth is kept.

layout(location = 0) in vec2 corner;

void main() {
    if (dot(corner, corner) > 1.0) discard;
}
