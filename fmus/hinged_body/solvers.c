/* HingedBody: the ladder of solvers, from cheapest to most exact, each one step of size h.
 *
 * Inputs with a slope are linear in time over the communication step. The anchor moves on with
 * them: its velocities are the integrals of its accelerations, its pose that of its velocities.
 */
#include "equations.h"

#include <math.h>

typedef struct Swing {
    real angle, rate;
} Swing;

/* The integral of a velocity whose acceleration is linear in time. */
static Vector displacement(Vector velocity, Vector acceleration, Vector acceleration_rate, real elapsed)
{
    Vector mean = add_scaled(add_scaled(velocity, elapsed / 2.0, acceleration), elapsed * elapsed / 6.0,
                             acceleration_rate);
    return scale(elapsed, mean);
}

static Vector later_velocity(Vector velocity, Vector acceleration, Vector acceleration_rate, real elapsed)
{
    return add_scaled(add_scaled(velocity, elapsed, acceleration), elapsed * elapsed / 2.0, acceleration_rate);
}

/* The rotation by the vector `turn`: its length in rad, about its direction. The tiny summand is below
 * any rounding, and gives no turn at all its limit without a branch. */
static Quaternion rotation_by(Vector turn)
{
    real angle = sqrt(dot(turn, turn) + 1e-300);
    return rotation_about(scale(1.0 / angle, turn), angle);
}

/* The inputs `elapsed` seconds after the start of the communication step. */
static HingedBody hinged_body_at(const HingedBody *body, real elapsed, Swing swing)
{
    HingedBody later = *body;
    later.angle = swing.angle;
    later.rate = swing.rate;
    later.torque += elapsed * body->torque_rate;
    later.target_angle += elapsed * body->target_angle_rate;
    later.tip_force = add_scaled(body->tip_force, elapsed, body->tip_force_rate);
    later.tip_torque = add_scaled(body->tip_torque, elapsed, body->tip_torque_rate);
    later.anchor_acceleration = add_scaled(body->anchor_acceleration, elapsed, body->anchor_acceleration_rate);
    later.anchor_angular_acceleration =
        add_scaled(body->anchor_angular_acceleration, elapsed, body->anchor_angular_acceleration_rate);
    later.anchor_angular_velocity = later_velocity(body->anchor_angular_velocity, body->anchor_angular_acceleration,
                                                   body->anchor_angular_acceleration_rate, elapsed);
    Vector turn = displacement(body->anchor_angular_velocity, body->anchor_angular_acceleration,
                               body->anchor_angular_acceleration_rate, elapsed);
    later.anchor_orientation = compose(rotation_by(turn), body->anchor_orientation);
    return later;
}

/* The slopes of angle and rate. */
static Swing swing_slope(const HingedBody *body, real elapsed, Swing swing)
{
    HingedBody now = hinged_body_at(body, elapsed, swing);
    hinged_body_derivatives(&now);
    Swing slope = {now.der_angle, now.der_rate};
    return slope;
}

static Swing add_scaled_swing(Swing a, real factor, Swing b)
{
    Swing sum = {a.angle + factor * b.angle, a.rate + factor * b.rate};
    return sum;
}

static Swing explicit_euler_step(const HingedBody *body, Swing swing, real elapsed, real h)
{
    return add_scaled_swing(swing, h, swing_slope(body, elapsed, swing));
}

/* Symplectic where nothing damps and the anchor rests. */
static Swing semi_implicit_euler_step(const HingedBody *body, Swing swing, real elapsed, real h)
{
    swing.rate += h * swing_slope(body, elapsed, swing).rate;
    swing.angle += h * swing.rate;
    return swing;
}

static Swing rk4_step(const HingedBody *body, Swing swing, real elapsed, real h)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    Swing next = swing;
    Swing slope = {0.0, 0.0};
    for (int stage = 0; stage < 4; stage++) {
        real reach = at[stage] * h;
        slope = swing_slope(body, elapsed + reach, add_scaled_swing(swing, reach, slope));
        next = add_scaled_swing(next, weight[stage] * h, slope);
    }
    return next;
}

typedef Swing (*HingedBodySolver)(const HingedBody *body, Swing swing, real elapsed, real h);

static HingedBodySolver hinged_body_solver(int64_t solver)
{
    switch ((HingedBodySolverKind)solver) {
    case HINGED_BODY_SOLVER_EXPLICIT_EULER: return explicit_euler_step;
    case HINGED_BODY_SOLVER_SEMI_IMPLICIT_EULER: return semi_implicit_euler_step;
    case HINGED_BODY_SOLVER_RK4: return rk4_step;
    }
    return rk4_step;
}
