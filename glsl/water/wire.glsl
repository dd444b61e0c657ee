// The book's debug view, of a surface whose heights are HEIGHT(column) (m above rest): the surface as lines, in two colours that change from one workgroup's tile of 16 x 16 columns
// to the next, so that its borders can be seen. Three lines a column: to the right, down, and across.

layout(location = 0) flat out vec3 tint;

void main() {
    uint column = uint(gl_VertexIndex) / 6u, corner = uint(gl_VertexIndex) % 6u;
    uvec2 c = uvec2(column % p.cells.x, column / p.cells.x);
    tint = ((c.x / 16u + c.y / 16u) & 1u) == 0u ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    const uvec2 TO[3] = uvec2[3](uvec2(1u, 0u), uvec2(0u, 1u), uvec2(1u, 1u));
    if ((corner & 1u) == 1u) c = min(c + TO[corner / 2u], p.cells - 1u);
    vec2 xz = column_centre_m(c);
    vec4 at = vec4(xz.x, p.level_m + HEIGHT(ivec2(c)), xz.y, 1.0);
    gl_Position = view.clip_from_world * at;
}
