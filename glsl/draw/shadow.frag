#version 460

// Nothing but depth is kept.

void main() {}
