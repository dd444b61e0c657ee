// The flight about one hole in closed form, any orbit, any length of time: universal variables, in sums, products,
// quotients and square roots alone, so that every device that rounds them alike gives the same bits.
// Units in which mu is 1: `q` is time times sqrt(mu), `w` is velocity over sqrt(mu). Vectors are from the hole.
// Sources: Danby, "Fundamentals of Celestial Mechanics" (1988), 6.9; Conway, "An improved algorithm due to Laguerre for
// the solution of Kepler's equation" (1986). CPU twin: particles::kepler.
#ifndef KEPLER_GLSL
#define KEPLER_GLSL

struct Flight {
    float r;      // distance at the start (m)
    float sigma;  // r . w: radial speed times r
    float alpha;  // reciprocal of the semi-major axis: positive of an ellipse, 0 of a parabola, negative of a hyperbola
    float beta;   // 1 - alpha r
};

const float TURN = 6.28318530717958647692;
const uint MOST_ITERATIONS = 12u;

float dot3(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// Squared length of a x b.
float cross2(vec3 a, vec3 b) {
    precise vec3 h = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return dot3(h, h);
}

// Cube root of x > 0 to a thousandth: a third of the exponent, and a step of Newton's.
float about_cube_root(float x) {
    float y = uintBitsToFloat(floatBitsToUint(x) / 3u + 0x2a5137a0u);
    precise float root = (2.0 * y + x / (y * y)) * (1.0 / 3.0);
    return root;
}

// Natural logarithm of x > 0, too large by up to 0.06: the exponent, and a straight line within it.
float about_log(float x) {
    precise float l = (float(floatBitsToUint(x) >> 8u) * (1.0 / 32768.0) - 126.914) * 0.6931472;
    return l;
}

// Universal functions u0 .. u3 of anomaly x: x^k c_k(alpha x^2), Stumpff's. Series of a half, quarter, .. of it, doubled.
vec4 universal(float alpha, float x) {
    precise float z = alpha * (x * x);
    precise float y = x;
    uint halvings = 0u;
    for (; abs(z) > 2.5 && halvings < 8u; ++halvings) {
        z = z * 0.25;
        y = y * 0.5;
    }
    precise float c2 = 0.5 - z * ((1.0 / 24.0) - z * ((1.0 / 720.0) - z * ((1.0 / 40320.0) - z * ((1.0 / 3628800.0) -
        z * (1.0 / 479001600.0)))));
    precise float c3 = (1.0 / 6.0) - z * ((1.0 / 120.0) - z * ((1.0 / 5040.0) - z * ((1.0 / 362880.0) -
        z * ((1.0 / 39916800.0) - z * (1.0 / 6227020800.0)))));
    precise float u2 = y * y * c2;
    precise float u3 = y * y * y * c3;
    precise float u1 = y - alpha * u3;
    precise float u0 = 1.0 - alpha * u2;
    for (; halvings > 0u; --halvings) {
        u3 = 2.0 * (u3 + u1 * u2);
        u2 = 2.0 * (u1 * u1);
        u1 = 2.0 * (u0 * u1);
        u0 = 1.0 - alpha * u2;
    }
    return vec4(u0, u1, u2, u3);
}

Flight flight_of(vec3 at, vec3 w) {
    precise float r = sqrt(dot3(at, at));
    precise float alpha = 2.0 / r - dot3(w, w);
    precise float beta = 1.0 - alpha * r;
    return Flight(r, dot3(at, w), alpha, beta);
}

// The anomaly at time q, 0 or more, of a bound orbit no more than half a period:
//     r u1 + sigma u2 + u3 = q,  whose derivative, r u0 + sigma u1 + u2, is the distance: it only rises.
// Starts from a step on its cubic, then one or two of Laguerre's iterations, between bounds.
float anomaly_at(Flight f, float q) {
    float far = about_cube_root(6.0 * q / max(abs(f.beta), 1e-6));
    precise float x = min(q / f.r, far);
    precise float high = 1e30;
    if (f.alpha > 0.0) {
        precise float mean = 0.5 * (f.alpha * q);
        x = max(x, mean);
        high = 6.5 / sqrt(f.alpha);
    }
    precise float missed = x * (f.r + x * (0.5 * f.sigma + x * (f.beta * (1.0 / 6.0)))) - q;
    precise float slope = f.r + x * (f.sigma + x * (0.5 * f.beta));
    precise float bend = f.sigma + f.beta * x;
    precise float root = sqrt(abs(16.0 * slope * slope - 20.0 * missed * bend));
    x = x - 5.0 * missed / (slope + root);
    if (f.alpha < 0.0) {
        // Soon the flight only grows with the exponential of the anomaly: no farther than its logarithm.
        precise float k = sqrt(-f.alpha);
        precise float mean = q * k * k * k;
        precise float most = (1.0 + 2.0 * (mean + max(f.sigma * k, 0.0) + 2.0) / (f.beta + f.sigma * k));
        high = 1.1 * about_log(most) / k;
    }
    precise float low = 0.0;
    if (!(x > low && x < high)) x = 0.5 * min(high, far);
    for (uint i = 0u; i < MOST_ITERATIONS; ++i) {
        vec4 u = universal(f.alpha, x);
        missed = f.r * u.y + f.sigma * u.z + u.w - q;
        slope = f.r * u.x + f.sigma * u.y + u.z;
        bend = f.sigma * u.x + f.beta * u.y;
        if (missed > 0.0) high = x;
        else low = x;
        root = sqrt(abs(16.0 * slope * slope - 20.0 * missed * bend));
        precise float over = 5.0 * missed / (slope + root + 1e-30);
        x = x - over;
        if (abs(over) <= 1e-3 * x) break;  // the next would be below rounding: each cubes the error
        if (!(x > low && x < high)) x = 0.5 * (low + high);
    }
    return x;
}

// When it first comes within `horizon`, as time q; 0 if it starts there, or nowhere; negative if never. h2 = cross2(at, w).
float crossing_of(Flight f, float h2, float horizon) {
    if (!(f.r > horizon)) return 0.0;
    precise float inward2 = 2.0 * horizon - f.alpha * (horizon * horizon) - h2;
    if (inward2 < 0.0 || (f.sigma >= 0.0 && f.alpha <= 0.0)) return -1.0;
    precise float inward = sqrt(inward2);
    // Half of the anomaly from here to there, as a tangent: sums of what has one sign, so nothing cancels.
    precise float half_x = (f.r - horizon) / (inward + abs(f.sigma));
    precise float turn = 0.0;
    if (f.sigma >= 0.0) {
        precise float below = f.alpha * (horizon + f.r) - 2.0;
        half_x = (inward + f.sigma) / max(abs(below), 1e-12);
        if (below < 0.0) {
            half_x = -half_x;
            turn = TURN / sqrt(f.alpha);
        }
    }
    // Its arcus tangens, or the hyperbolic one: halves, until the series is short.
    precise float z = f.alpha * (half_x * half_x);
    float twice = 2.0;
    for (uint i = 0u; i < 8u && abs(z) > 0.05; ++i) {
        half_x = half_x / (1.0 + sqrt(max(1.0 + z, 0.0)));
        z = f.alpha * (half_x * half_x);
        twice = 2.0 * twice;
    }
    precise float series = 1.0 - z * ((1.0 / 3.0) - z * ((1.0 / 5.0) - z * ((1.0 / 7.0) - z * (1.0 / 9.0))));
    precise float x = twice * half_x * series + turn;
    vec4 u = universal(f.alpha, x);
    precise float q = f.r * u.y + f.sigma * u.z + u.w;
    return q;
}

// Time that a bound orbit takes.
float period_of(Flight f) {
    precise float q = TURN / (f.alpha * sqrt(f.alpha));
    return q;
}

// What a flight of time q, of a bound orbit no more than half a period either way, adds to `at` and `w`: small numbers of
// their own, so that a short flight does not round what it hardly changes.
void fly(Flight f, float q, vec3 at, vec3 w, out vec3 to_at, out vec3 to_w) {
    float way = q < 0.0 ? -1.0 : 1.0;
    f.sigma = way * f.sigma;
    float x = anomaly_at(f, way * q);
    vec4 u = universal(f.alpha, x);
    precise float r = f.r * u.x + f.sigma * u.y + u.z;
    precise float g = way * (f.r * u.y + f.sigma * u.z);
    precise float pull = u.z / f.r;
    precise float turn = (way * u.y) / (r * f.r);
    precise float slow = u.z / r;
    precise vec3 more_at = g * w - pull * at;
    precise vec3 more_w = -(turn * at + slow * w);
    to_at = more_at;
    to_w = more_w;
}

// Whether a flight by `to_at` to a place `at` rounds the energy by more than a step usually does: the flight is long for
// where it ends, or ends so deep that energies are far above that of the orbit.
bool is_narrow(float alpha, vec3 at, vec3 to_at) {
    float r2 = dot3(at, at);
    precise float deep = r2 * (16.0 * alpha * alpha);
    precise float far = 4.0 * dot3(to_at, to_at);
    return deep < 1.0 || r2 < far;
}

// Takes away what rounding has added to the energy: both place and speed are scaled, along its gradient, so that little
// is asked of either.
void hold_energy(float alpha, inout vec3 at, inout vec3 w) {
    precise float well = 1.0 / sqrt(dot3(at, at));
    float w2 = dot3(w, w);
    precise float excess = (0.5 * w2 - well) + 0.5 * alpha;
    precise float part = excess / (well * well + w2 * w2);
    precise vec3 held_at = at - (part * well) * at;
    precise vec3 held_w = w - (part * w2) * w;
    at = held_at;
    w = held_w;
}

// The part of q beyond whole periods, from minus half of one to half.
float within_period(Flight f, float q) {
    if (f.alpha <= 0.0) return q;
    float period = period_of(f);
    if (abs(q) <= 0.5 * period) return q;
    precise float rest = q - floor(q / period + 0.5) * period;
    return rest;
}
#endif
