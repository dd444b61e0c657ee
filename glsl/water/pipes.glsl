// Pipes between columns, for the kernel that takes one step and for the one that takes several: both must round alike.
//     Q' = keep (Q + pull W (h_other - h)),  h' = h + dt (sum of what flows in)
// Flow is positive into the column that stores it, as rise of its surface (m/s). W is 1, w for a diagonal pipe, and
// 1 + w for a pipe along a wall that folds the diagonal pipes that it cuts off (1 + 2 w between two walls); 0 where there
// is no pipe. An invocation steps the pipes of 4 columns and those of its neighbours that end here, from the same numbers
// in the same order, so each pipe has one flow, and what one column gains another loses.
// CPU twin: water::cpu_pipes::Pipes.
#include "water/row.glsl"

struct Along {  // to the right
    float west;  // of the column on the west
    vec4 mid;
};

struct Down {  // between a row and the next
    vec4 below;
    float right_w;  // to the lower right: of the column on the west, and of the four
    vec4 right;
    vec4 left;  // to the lower left: of the four, and of the column on the east
    float left_e;
};

const Down NO_FLOW = Down(vec4(0.0), 0.0, vec4(0.0), vec4(0.0), 0.0);

vec4 flow_of(vec4 flow, vec4 pull, vec4 slope, float keep) {
    precise vec4 next = keep * fma(pull, slope, flow);
    return next;
}

float flow_of(float flow, float pull, float slope, float keep) {
    precise float next = keep * fma(pull, slope, flow);
    return next;
}

// `pull` has the same layout as the flows: pull W of each pipe.
void step_along(inout Along q, Row c, Along pull, float keep) {
    precise vec4 slope = vec4(c.mid.yzw, c.east) - c.mid;
    precise float slope_w = c.mid.x - c.west;
    q.mid = flow_of(q.mid, pull.mid, slope, keep);
    q.west = flow_of(q.west, pull.west, slope_w, keep);
}

void step_down(inout Down q, Row c, Row s, Down pull, float keep, bool has_diagonals) {
    precise vec4 below = s.mid - c.mid;
    q.below = flow_of(q.below, pull.below, below, keep);
    if (has_diagonals) {
        precise vec4 right = vec4(s.mid.yzw, s.east) - c.mid, left = vec4(s.west, s.mid.xyz) - c.mid;
        precise float right_w = s.mid.x - c.west, left_e = s.mid.w - c.east;
        q.right_w = flow_of(q.right_w, pull.right_w, right_w, keep);
        q.right = flow_of(q.right, pull.right, right, keep);
        q.left = flow_of(q.left, pull.left, left, keep);
        q.left_e = flow_of(q.left_e, pull.left_e, left_e, keep);
    }
}

vec4 height_after(vec4 h, Along along, Down above, Down below, float dt_s) {
    precise vec4 gain = (along.mid + below.right) + (below.below + below.left);
    precise vec4 loss = (vec4(along.west, along.mid.xyz) + vec4(above.right_w, above.right.xyz)) +
                        (above.below + vec4(above.left.yzw, above.left_e));
    precise vec4 next = fma(vec4(dt_s), gain - loss, h);
    return next;
}

// Where there is no land, pulls depend on the column alone, but for the rows at walls.
struct Pulls {
    Along along;
    Down down;
};

float weight_along_wall(WaterParams p, int walls) {
    precise float weight = 1.0 + float(p.folded == 1u ? walls : 0) * p.diagonal;
    return weight;
}

Pulls pulls_of(int x, WaterParams p) {
    int last = int(p.cells.x) - 1;
    precise float diagonal = p.pull * p.diagonal;
    float open[5];  // between columns x + k - 1 and x + k
    Pulls pulls;
    for (int k = 0; k < 5; ++k) open[k] = x + k == 0 || x + k == last + 1 ? 0.0 : 1.0;
    for (int k = 0; k < 4; ++k) {
        pulls.along.mid[k] = p.pull * open[k + 1];
        pulls.down.right[k] = diagonal * open[k + 1];
        pulls.down.left[k] = diagonal * open[k];
        precise float below = p.pull * weight_along_wall(p, int(x + k == 0) + int(x + k == last));
        pulls.down.below[k] = below;
    }
    pulls.along.west = p.pull * open[0];
    pulls.down.right_w = diagonal * open[0];
    pulls.down.left_e = diagonal * open[4];
    return pulls;
}

Along along_wall(Along pull, int y, WaterParams p) {
    int walls = int(y == 0) + int(y + 1 == int(p.cells.y));
    if (walls == 0) return pull;
    precise float weight = weight_along_wall(p, walls);
    precise float west = pull.west * weight;
    precise vec4 mid = pull.mid * weight;
    return Along(west, mid);
}

// Pulls beside land, which lies beyond the grid too. `a` and `b` are the ends, the others what lies beside the pipe.
float pull_between(float a, float b, float a1, float b1, float a2, float b2, WaterParams p) {
    if (a == LAND_M || b == LAND_M) return 0.0;
    int walls = int(a1 == LAND_M && b1 == LAND_M) + int(a2 == LAND_M && b2 == LAND_M);
    precise float pull = p.pull * weight_along_wall(p, walls);
    return pull;
}

float pull_across(float a, float b, float flank, float other_flank, WaterParams p) {
    bool is_open = a != LAND_M && b != LAND_M && (flank != LAND_M || other_flank != LAND_M);
    precise float pull = is_open ? p.pull * p.diagonal : 0.0;
    return pull;
}

float[6] six(Row r) { return float[6](r.west, r.mid.x, r.mid.y, r.mid.z, r.mid.w, r.east); }

Along along_beside_land(Row above, Row row, Row below, WaterParams p) {
    float n[6] = six(above), c[6] = six(row), s[6] = six(below);
    Along pull;
    pull.west = pull_between(c[0], c[1], n[0], n[1], s[0], s[1], p);
    for (int k = 0; k < 4; ++k)
        pull.mid[k] = pull_between(c[k + 1], c[k + 2], n[k + 1], n[k + 2], s[k + 1], s[k + 2], p);
    return pull;
}

Down down_beside_land(Row row, Row below, WaterParams p) {
    float c[6] = six(row), s[6] = six(below);
    Down pull;
    for (int k = 0; k < 4; ++k) {
        int i = k + 1;
        pull.below[k] = pull_between(c[i], s[i], c[i - 1], s[i - 1], c[i + 1], s[i + 1], p);
        pull.right[k] = pull_across(c[i], s[i + 1], c[i + 1], s[i], p);
        pull.left[k] = pull_across(c[i], s[i - 1], c[i - 1], s[i], p);
    }
    pull.right_w = pull_across(c[0], s[1], c[1], s[0], p);
    pull.left_e = pull_across(c[5], s[4], c[4], s[5], p);
    return pull;
}
