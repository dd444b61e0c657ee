// A large triangle, column by column along the axis that its normal is nearest to: there the plane passes few cells of a
// column. `gl_NumWorkGroups.y` workgroups share the columns of a triangle, and VISIT is called for the cells.
// After Schwarz and Seidel (2010), section 3.1.

void visit_columns(uint t) {
    vec3 n = abs(tri_normal);
    int w = across_axis(), u = (w + 1) % 3, v = (w + 2) % 3;
    uint wide = uint(max(tri_high[u] - tri_low[u] + 1, 0)), columns = box_columns(w);
    // How far the plane rises over half a column, and the slack of both.
    float rise = (0.5 + tri_slack) * (n[u] + n[v]) / n[w] + 3.0 * tri_slack;
    uint step = gl_WorkGroupSize.x * gl_NumWorkGroups.y;
    for (uint column = gl_WorkGroupID.y * gl_WorkGroupSize.x + gl_LocalInvocationIndex; column < columns; column += step) {
        ivec3 cell = tri_low;
        cell[u] += int(column % wide);
        cell[v] += int(column / wide);
        vec3 from_a = vec3(cell) + 0.5 - tri_a;
        float plane = tri_a[w] - (tri_normal[u] * from_a[u] + tri_normal[v] * from_a[v]) / tri_normal[w];
        float low = float(tri_low[w]), high = float(tri_high[w]);
        int from = int(clamp(ceil(plane - rise) - 1.0, low, high + 1.0)), to = int(clamp(floor(plane + rise), low - 1.0, high));
        for (cell[w] = from; cell[w] <= to; ++cell[w]) VISIT(t, cell);
    }
}
