/* RigidBody: Taylor series of attitude and body rate, order and step chosen as they are needed.
 *
 * With loads linear in time over the communication step the equations are polynomial in body axes:
 *
 *   I dw/dt = I w x w + torque,   dq/dt = q (0, w) / 2,   dg/dt = g x w + R^T b
 *
 * where g = R^T (a + b t) is a force or torque a + b t of the world seen from the body. So every
 * coefficient follows from those before it by sums of products (Jorba & Zou 2005, Experimental
 * Mathematics 14:99). Translation is a polynomial by itself, and exact.
 */
#include "unit.h"
#include "equations.h"

#include <math.h>
#include <string.h>

enum { TAYLOR_MOST = 24, CARRIED_MOST = 3 };

#define TAYLOR_ROUND_OFF 1e-15 /* rad/s; less is lost in rounding */

/* A force or a torque of the world, a + b t, seen from the body. */
typedef struct Carried {
    Vector lever; /* where a force acts; a torque acts anywhere */
    bool torque;
    bool sloped;
    Vector value[TAYLOR_MOST + 1], slope[TAYLOR_MOST + 1];
} Carried;

typedef struct TaylorSeries {
    Vector rate[TAYLOR_MOST + 1]; /* body axes */
    Quaternion attitude[TAYLOR_MOST + 1];
    Carried carried[CARRIED_MOST];
    int count; /* of what is carried */
} TaylorSeries;

static bool is_zero(Vector v)
{
    return v.x == 0.0 && v.y == 0.0 && v.z == 0.0;
}

static void carry(TaylorSeries *series, Rotation attitude, Vector lever, bool torque, Vector value, Vector slope)
{
    bool acts = torque || !is_zero(lever);
    if (acts && !(is_zero(value) && is_zero(slope))) {
        Carried *carried = &series->carried[series->count++];
        carried->lever = lever;
        carried->torque = torque;
        carried->sloped = !is_zero(slope);
        carried->value[0] = to_body(attitude, value);
        carried->slope[0] = to_body(attitude, slope);
    }
}

/* Coefficient n of g x w, for a vector g of the world seen from the turning body. */
static inline Vector cross_coefficient(const Vector *g, const Vector *w, int n)
{
    Vector sum = {0.0, 0.0, 0.0};
    for (int i = 0; i <= n; i++) {
        sum = add(sum, cross(g[i], w[n - i]));
    }
    return sum;
}

/* The torque's coefficient n, and the carried vectors' coefficients n + 1. */
static Vector next_torque(TaylorSeries *series, int n)
{
    Vector torque = {0.0, 0.0, 0.0};
    double share = 1.0 / (n + 1);
    for (int k = 0; k < series->count; k++) {
        Carried *c = &series->carried[k];
        torque = add(torque, c->torque ? c->value[n] : cross(c->lever, c->value[n]));
        Vector value = cross_coefficient(c->value, series->rate, n);
        if (c->sloped) {
            value = add(value, c->slope[n]);
            c->slope[n + 1] = scale(share, cross_coefficient(c->slope, series->rate, n));
        }
        c->value[n + 1] = scale(share, value);
    }
    return torque;
}

/* From the coefficients up to n to those of n + 1. */
static void next_coefficients(Vector inertia, Vector inverse, TaylorSeries *series, int n)
{
    const Vector *w = series->rate;
    const Quaternion *q = series->attitude;
    Vector product = {0.0, 0.0, 0.0}; /* w_y w_z, w_z w_x, w_x w_y */
    Quaternion turn = {0.0, 0.0, 0.0, 0.0};
    for (int i = 0; i <= n; i++) {
        Vector a = w[i], b = w[n - i];
        Quaternion p = q[i];
        product = add(product, vector(a.y * b.z, a.z * b.x, a.x * b.y));
        turn.w += p.x * b.x + p.y * b.y + p.z * b.z;
        turn.x += p.w * b.x + p.y * b.z - p.z * b.y;
        turn.y += p.w * b.y + p.z * b.x - p.x * b.z;
        turn.z += p.w * b.z + p.x * b.y - p.y * b.x;
    }
    Vector difference = {inertia.y - inertia.z, inertia.z - inertia.x, inertia.x - inertia.y};
    Vector gyroscopic = multiply_elements(difference, product);
    double share = 1.0 / (n + 1), half = 0.5 * share;
    series->rate[n + 1] = scale(share, multiply_elements(inverse, add(gyroscopic, next_torque(series, n))));
    series->attitude[n + 1] = quaternion(-half * turn.w, half * turn.x, half * turn.y, half * turn.z);
}

/* Square of the size of the terms of order n, as an angle: that of the attitude, and of the rate where
 * it is not taken from L afterwards. */
static double term_square(const TaylorSeries *series, int n)
{
    double attitude = 4.0 * quaternion_square(series->attitude[n]);
    return series->count ? fmax(attitude, dot(series->rate[n], series->rate[n])) : attitude;
}

/* The order from which on a longer series costs more than a shorter step saves. */
static int most_order(double tolerance)
{
    return (int)fmin(ceil(4.0 - 0.7 * log(fmin(tolerance, 1e-2))), TAYLOR_MOST);
}

/* The step at which the last terms are within the tolerance. They fall as a geometric series at the
 * rate that the last three show; the largest of them, carried on to the last, counts. */
static double reach(const TaylorSeries *series, double tolerance, int n)
{
    double a = term_square(series, n - 2), b = term_square(series, n - 1), c = term_square(series, n);
    double fall = c / fmax(a, 1e-300); /* fourth power of the inverse radius of convergence */
    double last = fmax(c, fmax(b * sqrt(fall), a * fall));
    return pow(tolerance * tolerance / fmax(last, 1e-300), 0.5 / (n - 1));
}

/* Coefficients until three terms in a row are below what the step may miss; three, because symmetry
 * can leave out two of them. Where the order runs out, `h` is made shorter. Returns the order. */
static int expand(Vector inertia, TaylorSeries *series, double tolerance, int most, double *h)
{
    Vector inverse = {1.0 / inertia.x, 1.0 / inertia.y, 1.0 / inertia.z};
    double square = *h * *h, power = 1.0, allowed = tolerance * tolerance * square;
    int small = 0;
    for (int n = 1; n <= most; n++) {
        next_coefficients(inertia, inverse, series, n - 1);
        power *= square;
        small = term_square(series, n) * power <= allowed ? small + 1 : 0;
        if (small == 3) {
            return n;
        }
    }
    *h = fmin(*h, 0.9 * reach(series, tolerance, most));
    return most;
}

/* One step of at most `h` seconds; makes `h` what it was. */
static Motion taylor_step(const RigidBody *body, const LinearLoads *loads, double tolerance, int most, Motion m,
                          double elapsed, double *h)
{
    TaylorSeries series;
    Rotation attitude = rotation(m.orientation);
    Loads now = loads_at(loads, elapsed);
    Vector none = {0.0, 0.0, 0.0};
    series.count = 0;
    carry(&series, attitude, none, true, now.torque, loads->slope.torque);
    carry(&series, attitude, body->base, false, now.base_force, loads->slope.base_force);
    carry(&series, attitude, body->tip, false, now.tip_force, loads->slope.tip_force);
    series.attitude[0] = m.orientation;
    series.rate[0] = divide_elements(to_body(attitude, m.angular_momentum), body->inertia);

    int order = expand(body->inertia, &series, tolerance, most, h);
    Quaternion q = series.attitude[order];
    Vector w = series.rate[order];
    for (int n = order - 1; n >= 0; n--) {
        q = add_scaled_quaternion(series.attitude[n], *h, q);
        w = add_scaled(series.rate[n], *h, w);
    }
    Motion next = m;
    next.orientation = normalized(q);
    if (series.count) {
        Vector momentum = multiply_elements(body->inertia, w);
        next.angular_momentum = to_world(rotation(next.orientation), momentum);
    }
    return next;
}

/* Attitude and angular momentum over a whole communication step. */
static Status taylor_motion(const RigidBody *body, const LinearLoads *loads, double tolerance, double step,
                            Motion *motion, Log *log)
{
    int most = most_order(tolerance);
    double elapsed = 0.0;
    while (elapsed < step) {
        double left = step - elapsed, h = left;
        Motion next = taylor_step(body, loads, tolerance, most, *motion, elapsed, &h);
        if (!(h > 1e-6 * step)) {
            return report(log, STATUS_ERROR,
                          "the body turns so fast that tolerance = %g rad/s takes more than 1e6 steps in %g s",
                          tolerance, step);
        }
        *motion = next;
        elapsed = h < left ? elapsed + h : step;
    }
    return STATUS_OK;
}
