/* HingedBody: the ladder of solvers of a fixed step, each one step of size h.
 *
 * Inputs with a slope are linear in time over the communication step. The anchor moves on with
 * them: its angular velocity is the integral of its acceleration, its orientation turns with that.
 *
 * Seen from the anchor, a vector fixed in the body turns about the axis n alone, so the component of
 * Newton and Euler along n is a short sum (c, r: centre of mass and tip; I: inertia about the hinge;
 * W, dW: angular velocity and acceleration of the anchor):
 *
 *   J angle'' = stiffness (target - angle) - (damping + friction) rate + torque + n . tip_torque
 *             + m (n x c) . (g - a) + (n x r) . tip_force - I n . dW - n . W x I W
 *
 * With u(angle) = u + (cos(angle) - 1) u_across + sin(angle) n x u for each of the vectors of the body
 * that is even + A cos(angle) + B sin(angle) + C cos(2 angle) + D sin(2 angle), of which C and D and
 * what changes other than linearly come with an anchor that turns.
 */
#include "equations.h"

#include <math.h>
#include <stdbool.h>

typedef struct Swing {
    real angle, rate;
} Swing;

/* All that drives the hinge, in the world, at one time; or its slopes. */
typedef struct Drive {
    real torque;                   /* about the axis, a muscle at angle 0 included */
    Vector fall;                   /* gravity less the acceleration of the hinge */
    Vector tip_force, tip_torque;
    Vector spin, spin_rate;        /* of the anchor */
} Drive;

/* Angular acceleration by angle, muscle's stiffness and all damping aside. */
typedef struct Turning {
    real cosine, double_cosine, even, sine, double_sine;
} Turning;

/* What a vector of the world gives about the axis per unit: `even` at any angle, the others by its cosine and sine. */
typedef struct Lever {
    Vector even, cosine, sine;
} Lever;

/* A body on its hinge, made ready for the steps within one communication step. All but `inertia`, the tensor about
 * the hinge in body axes, is over the moment of inertia about the axis. */
typedef struct Hinge {
    const HingedBody *body;
    bool turned; /* the anchor has an angular velocity, or will have */
    real stiffness, damping;
    real per_torque;
    Rotation inertia;
    Vector tip_torque;
    Lever fall, tip_force, spin_rate, spin_product;
    Drive start, slope;
    Turning resting, resting_slope; /* where the anchor does not turn */
} Hinge;

static Lever lever(Vector axis, real share, Vector v)
{
    real even = dot(axis, v);
    Lever parts = {scale(share * even, axis), scale(share, add_scaled(v, -even, axis)), scale(share, cross(axis, v))};
    return parts;
}

/* The moment of inertia about the hinge, m (c^2 1 - c c^T) + I in body axes, by its columns. */
static Rotation inertia_about_hinge(const HingedBody *body)
{
    Vector c = body->center_of_mass;
    Vector d = scale(-body->mass, c);
    real all = body->mass * dot(c, c);
    Rotation inertia = {scale(d.x, c), scale(d.y, c), scale(d.z, c)};
    inertia.x.x += body->inertia.x + all;
    inertia.y.y += body->inertia.y + all;
    inertia.z.z += body->inertia.z + all;
    return inertia;
}

/* By weight and tip: linear in time where the anchor rests. */
static Turning turning_by_loads(const Hinge *hinge, Rotation anchor, const Drive *drive)
{
    Vector fall = to_body(anchor, drive->fall), force = to_body(anchor, drive->tip_force);
    Turning turning = {0};
    turning.even = dot(hinge->tip_torque, to_body(anchor, drive->tip_torque));
    turning.cosine = dot(hinge->fall.cosine, fall) + dot(hinge->tip_force.cosine, force);
    turning.sine = dot(hinge->fall.sine, fall) + dot(hinge->tip_force.sine, force);
    return turning;
}

/* Adds what the turning of the anchor brings; `spin_rate` in anchor axes. */
static void add_turning_by_spin_rate(Turning *turning, const Hinge *hinge, Vector spin_rate)
{
    turning->even += dot(hinge->spin_rate.even, spin_rate);
    turning->cosine += dot(hinge->spin_rate.cosine, spin_rate);
    turning->sine += dot(hinge->spin_rate.sine, spin_rate);
}

/* The angular velocity of the anchor, twice, as -n . W x I W takes it; all in anchor axes. */
typedef struct Spin {
    real along;            /* the axis */
    Vector across, beside; /* n x beside = across */
    Vector across_momentum, beside_momentum;
    real cosine, sine;
} Spin;

static Spin spin_parts(const Hinge *hinge, Vector spin)
{
    Vector n = hinge->body->axis;
    Spin parts;
    parts.along = dot(n, spin);
    parts.across = add_scaled(spin, -parts.along, n);
    parts.beside = cross(spin, n);
    parts.across_momentum = scale(hinge->per_torque, to_world(hinge->inertia, parts.across));
    parts.beside_momentum = scale(hinge->per_torque, to_world(hinge->inertia, parts.beside));
    parts.cosine = dot(hinge->spin_product.cosine, spin);
    parts.sine = dot(hinge->spin_product.sine, spin);
    return parts;
}

/* Adds a product of two coefficients of the angular velocity, or of the whole with itself. */
static void add_turning_by_spins(Turning *turning, const Spin *a, const Spin *b)
{
    turning->cosine += a->along * b->cosine;
    turning->sine += a->along * b->sine;
    turning->double_cosine += dot(a->beside, b->across_momentum);
    turning->double_sine += 0.5 * (dot(a->beside, b->beside_momentum) - dot(a->across, b->across_momentum));
}

/* The rotation by the vector `turn`: its length in rad, about its direction. The tiny summand is below
 * any rounding, and gives no turn at all its limit without a branch. */
static Quaternion rotation_by(Vector turn)
{
    real angle = sqrt(dot(turn, turn) + 1e-300), half = 0.5 * angle;
    Vector u = scale(sin(half) / angle, turn);
    return quaternion(cos(half), u.x, u.y, u.z);
}

/* The turn of the anchor: the integral of its angular velocity w + w' t + w'' t^2 / 2, and the next term of
 * Magnus (1954) for an axis of turn that wanders; what is left is of order 5 in `elapsed`. */
static Quaternion anchor_orientation_at(const HingedBody *body, real elapsed)
{
    Vector w0 = body->anchor_angular_velocity, w1 = body->anchor_angular_acceleration;
    Vector w2 = body->anchor_angular_acceleration_rate;
    real t = elapsed, t2 = t * t;
    Vector turn = scale(t, add_scaled(add_scaled(w0, t / 2.0, w1), t2 / 6.0, w2));
    Vector wander = add_scaled(cross(add_scaled(w1, t / 2.0, w2), w0), t2 / 10.0, cross(w2, w1));
    turn = add_scaled(turn, t2 * t / 12.0, wander);
    return compose(rotation_by(turn), body->anchor_orientation);
}

static Drive hinge_drive(const Hinge *hinge, real elapsed)
{
    const Drive *start = &hinge->start, *slope = &hinge->slope;
    Drive now;
    now.torque = start->torque + elapsed * slope->torque;
    now.fall = add_scaled(start->fall, elapsed, slope->fall);
    now.tip_force = add_scaled(start->tip_force, elapsed, slope->tip_force);
    now.tip_torque = add_scaled(start->tip_torque, elapsed, slope->tip_torque);
    now.spin_rate = add_scaled(start->spin_rate, elapsed, slope->spin_rate);
    now.spin = add_scaled(start->spin, elapsed, add_scaled(start->spin_rate, elapsed / 2.0, slope->spin_rate));
    return now;
}

static Drive drive_at_start(const HingedBody *body)
{
    Drive drive;
    drive.torque = body->torque + body->stiffness * body->target_angle;
    drive.fall = subtract(body->gravity, body->anchor_acceleration);
    drive.tip_force = body->tip_force;
    drive.tip_torque = body->tip_torque;
    drive.spin = body->anchor_angular_velocity;
    drive.spin_rate = body->anchor_angular_acceleration;
    return drive;
}

static Drive drive_slope(const HingedBody *body)
{
    Drive slope;
    slope.torque = body->torque_rate + body->stiffness * body->target_angle_rate;
    slope.fall = scale(-1.0, body->anchor_acceleration_rate);
    slope.tip_force = body->tip_force_rate;
    slope.tip_torque = body->tip_torque_rate;
    slope.spin = body->anchor_angular_acceleration;
    slope.spin_rate = body->anchor_angular_acceleration_rate;
    return slope;
}

static Hinge hinge_of(const HingedBody *body, bool turned)
{
    Rotation inertia = inertia_about_hinge(body);
    Vector n = body->axis, momentum = to_world(inertia, n);
    real share = 1.0 / dot(n, momentum);
    Hinge hinge;
    hinge.body = body;
    hinge.turned = turned;
    hinge.stiffness = share * body->stiffness;
    hinge.damping = share * (body->damping + body->friction);
    hinge.per_torque = share;
    hinge.inertia = inertia;
    hinge.fall = lever(n, share * body->mass, cross(n, body->center_of_mass));
    hinge.tip_force = lever(n, share, cross(n, body->tip));
    hinge.tip_torque = scale(share, n);
    hinge.spin_rate = lever(n, -share, momentum);
    hinge.spin_product = lever(n, share, cross(n, momentum));
    hinge.start = drive_at_start(body);
    hinge.slope = drive_slope(body);
    Rotation anchor = rotation(body->anchor_orientation);
    hinge.resting = turning_by_loads(&hinge, anchor, &hinge.start);
    hinge.resting.even += share * hinge.start.torque;
    hinge.resting_slope = turning_by_loads(&hinge, anchor, &hinge.slope);
    hinge.resting_slope.even += share * hinge.slope.torque;
    return hinge;
}

static Turning hinge_turning(const Hinge *hinge, real elapsed)
{
    if (!hinge->turned) {
        Turning turning = hinge->resting;
        turning.even += elapsed * hinge->resting_slope.even;
        turning.cosine += elapsed * hinge->resting_slope.cosine;
        turning.sine += elapsed * hinge->resting_slope.sine;
        return turning;
    }
    Rotation anchor = rotation(anchor_orientation_at(hinge->body, elapsed));
    Drive drive = hinge_drive(hinge, elapsed);
    Spin spin = spin_parts(hinge, to_body(anchor, drive.spin));
    Turning turning = turning_by_loads(hinge, anchor, &drive);
    turning.even += hinge->per_torque * drive.torque;
    add_turning_by_spin_rate(&turning, hinge, to_body(anchor, drive.spin_rate));
    add_turning_by_spins(&turning, &spin, &spin);
    return turning;
}

static real angular_acceleration(const Hinge *hinge, const Turning *by, real angle, real rate)
{
    real c = cos(angle), s = sin(angle);
    real turning = by->even + by->cosine * c + by->sine * s;
    if (hinge->turned) {
        turning += by->double_cosine * (c * c - s * s) + 2.0 * by->double_sine * s * c;
    }
    return turning - hinge->stiffness * angle - hinge->damping * rate;
}

static Swing explicit_euler_step(const Hinge *hinge, Swing swing, real elapsed, real h)
{
    Turning by = hinge_turning(hinge, elapsed);
    real acceleration = angular_acceleration(hinge, &by, swing.angle, swing.rate);
    Swing next = {swing.angle + h * swing.rate, swing.rate + h * acceleration};
    return next;
}

/* Symplectic where nothing damps and the anchor rests. */
static Swing semi_implicit_euler_step(const Hinge *hinge, Swing swing, real elapsed, real h)
{
    Turning by = hinge_turning(hinge, elapsed);
    swing.rate += h * angular_acceleration(hinge, &by, swing.angle, swing.rate);
    swing.angle += h * swing.rate;
    return swing;
}

static Swing rk4_step(const Hinge *hinge, Swing swing, real elapsed, real h)
{
    real half = 0.5 * h, sixth = h / 6.0, angle = swing.angle;
    Turning by = hinge_turning(hinge, elapsed);
    real rate1 = swing.rate;
    real acceleration1 = angular_acceleration(hinge, &by, angle, rate1);
    by = hinge_turning(hinge, elapsed + half);
    real rate2 = swing.rate + half * acceleration1;
    real acceleration2 = angular_acceleration(hinge, &by, angle + half * rate1, rate2);
    real rate3 = swing.rate + half * acceleration2;
    real acceleration3 = angular_acceleration(hinge, &by, angle + half * rate2, rate3);
    by = hinge_turning(hinge, elapsed + h);
    real rate4 = swing.rate + h * acceleration3;
    real acceleration4 = angular_acceleration(hinge, &by, angle + h * rate3, rate4);
    Swing next;
    next.angle = angle + sixth * (rate1 + 2.0 * (rate2 + rate3) + rate4);
    next.rate = rate1 + sixth * (acceleration1 + 2.0 * (acceleration2 + acceleration3) + acceleration4);
    return next;
}

typedef Swing (*HingedBodySolver)(const Hinge *hinge, Swing swing, real elapsed, real h);

/* The step of a solver whose steps are fixed; none for one that chooses them. */
static HingedBodySolver hinged_body_solver(int64_t solver)
{
    switch ((HingedBodySolverKind)solver) {
    case HINGED_BODY_SOLVER_EXPLICIT_EULER: return explicit_euler_step;
    case HINGED_BODY_SOLVER_SEMI_IMPLICIT_EULER: return semi_implicit_euler_step;
    case HINGED_BODY_SOLVER_RK4: return rk4_step;
    case HINGED_BODY_SOLVER_TAYLOR: return NULL;
    case HINGED_BODY_SOLVER_AUTOMATIC: return NULL;
    }
    return NULL;
}
