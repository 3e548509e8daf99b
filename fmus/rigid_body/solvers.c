/* RigidBody: the ladder of solvers, from cheapest to most exact, each one step of size h.
 *
 * Forces and torques are linear in time over the communication step; the levers of the frames
 * turn with the body. P and L are the states that every solver starts from and ends with.
 */
#include "equations.h"

#include <stdbool.h>

typedef struct Motion {
    Vector position;
    Quaternion orientation;
    Vector linear_momentum, angular_momentum;
    bool beyond_limit; /* a step was too long for its solver */
} Motion;

/* Loads at the start of the communication step, and their slopes over it. */
typedef struct LinearLoads {
    Loads start, slope;
} LinearLoads;

static inline LinearLoads rigid_body_linear_loads(const RigidBody *body)
{
    LinearLoads loads;
    loads.start = rigid_body_loads(body);
    loads.slope.force = body->force_rate;
    loads.slope.base_force = body->base_force_rate;
    loads.slope.tip_force = body->tip_force_rate;
    loads.slope.torque = add(body->torque_rate, add(body->base_torque_rate, body->tip_torque_rate));
    return loads;
}

static Loads loads_at(const LinearLoads *loads, real elapsed)
{
    Loads now;
    now.force = add_scaled(loads->start.force, elapsed, loads->slope.force);
    now.base_force = add_scaled(loads->start.base_force, elapsed, loads->slope.base_force);
    now.tip_force = add_scaled(loads->start.tip_force, elapsed, loads->slope.tip_force);
    now.torque = add_scaled(loads->start.torque, elapsed, loads->slope.torque);
    return now;
}

/* Moves position and momentum over a step: the forces are linear in time, so this is exact. */
static inline void translate(const RigidBody *body, const LinearLoads *loads, real step, Vector *position, Vector *momentum)
{
    Vector force = add(loads->start.force, add(loads->start.base_force, loads->start.tip_force));
    Vector slope = add(loads->slope.force, add(loads->slope.base_force, loads->slope.tip_force));
    Vector gain = scale(step, add_scaled(force, step / 2.0, slope));
    Vector mean = add_scaled(*momentum, step / 2.0, add_scaled(force, step / 3.0, slope));
    *position = add_scaled(*position, step / body->mass, mean);
    *momentum = add(*momentum, gain);
}

/* Turns from q with the constant angular velocity w, to first order, back to the unit sphere. */
static Quaternion turned(Quaternion q, real h, Vector w)
{
    return normalized(add_scaled_quaternion(q, h, quaternion_rate(q, w)));
}

/* Everything from the old state. */
static Motion explicit_euler_step(const RigidBody *body, const LinearLoads *loads, Motion m, real elapsed, real h)
{
    Rotation attitude = rotation(m.orientation);
    Wrench total = rigid_body_wrench(body, loads_at(loads, elapsed), attitude);
    Vector w = rigid_body_angular_velocity(body, attitude, m.angular_momentum);
    Motion next = m;
    next.position = add_scaled(m.position, h / body->mass, m.linear_momentum);
    next.orientation = turned(m.orientation, h, w);
    next.linear_momentum = add_scaled(m.linear_momentum, h, total.force);
    next.angular_momentum = add_scaled(m.angular_momentum, h, total.torque);
    return next;
}

/* The class notes: velocities from the new momenta, w1 = I_world(q0)^-1 L1, position and
 * orientation from the new velocities. Symplectic in translation, not in rotation. */
static Motion notes_step(const RigidBody *body, const LinearLoads *loads, Motion m, real elapsed, real h)
{
    Rotation attitude = rotation(m.orientation);
    Wrench total = rigid_body_wrench(body, loads_at(loads, elapsed), attitude);
    Motion next = m;
    next.linear_momentum = add_scaled(m.linear_momentum, h, total.force);
    next.angular_momentum = add_scaled(m.angular_momentum, h, total.torque);
    Vector w = rigid_body_angular_velocity(body, attitude, next.angular_momentum);
    next.position = add_scaled(m.position, h / body->mass, next.linear_momentum);
    next.orientation = turned(m.orientation, h, w);
    return next;
}

/* What one stage of rk4 sees. */
typedef struct Slope {
    Vector velocity;
    Quaternion orientation_rate;
    Vector force, torque;       /* world */
    Vector body_angular_acceleration; /* Euler's equation, body axes */
} Slope;

static Slope rk4_slope(const RigidBody *body, Loads loads, Vector linear_momentum, Quaternion q, Vector body_rate)
{
    Rotation attitude = rotation(q);
    Wrench total = rigid_body_wrench(body, loads, attitude);
    Vector gyroscopic = cross(multiply_elements(body->inertia, body_rate), body_rate);
    Quaternion p = compose(q, quaternion(0.0, body_rate.x, body_rate.y, body_rate.z));
    Slope slope;
    slope.velocity = scale(1.0 / body->mass, linear_momentum);
    slope.orientation_rate = quaternion(0.5 * p.w, 0.5 * p.x, 0.5 * p.y, 0.5 * p.z);
    slope.force = total.force;
    slope.torque = total.torque;
    slope.body_angular_acceleration =
        divide_elements(add(to_body(attitude, total.torque), gyroscopic), body->inertia);
    return slope;
}

/* Runge-Kutta on x, P, q and the body rate, which costs fewer digits than q and L; L itself is
 * the integral of the stages' torques, so that without torque it does not change at all. */
static Motion rk4_step(const RigidBody *body, const LinearLoads *loads, Motion m, real elapsed, real h)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    Vector body_rate = divide_elements(to_body(rotation(m.orientation), m.angular_momentum), body->inertia);
    Motion next = m;
    Slope k = {0};
    for (int stage = 0; stage < 4; stage++) {
        real reach = at[stage] * h, share = weight[stage] * h;
        k = rk4_slope(body, loads_at(loads, elapsed + reach), add_scaled(m.linear_momentum, reach, k.force),
                      add_scaled_quaternion(m.orientation, reach, k.orientation_rate),
                      add_scaled(body_rate, reach, k.body_angular_acceleration));
        next.position = add_scaled(next.position, share, k.velocity);
        next.orientation = add_scaled_quaternion(next.orientation, share, k.orientation_rate);
        next.linear_momentum = add_scaled(next.linear_momentum, share, k.force);
        next.angular_momentum = add_scaled(next.angular_momentum, share, k.torque);
    }
    next.orientation = normalized(next.orientation);
    return next;
}

/* The same where nothing turns the body: the body rate and the attitude alone. */
static Motion rk4_free_step(const RigidBody *body, const LinearLoads *loads, Motion m, real elapsed, real h)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0, 2.0, 2.0, 1.0};
    LinearLoads here = {loads_at(loads, elapsed), loads->slope};
    Motion next = m;
    translate(body, &here, h, &next.position, &next.linear_momentum);
    Vector i = body->inertia;
    Vector ratio = vector((i.y - i.z) / i.x, (i.z - i.x) / i.y, (i.x - i.y) / i.z);
    Vector inverse = vector(1.0 / i.x, 1.0 / i.y, 1.0 / i.z);
    Vector body_rate = multiply_elements(inverse, unit_rotate_back(m.orientation, m.angular_momentum));
    Vector slope = vector(0.0, 0.0, 0.0);
    Quaternion rate = {0.0, 0.0, 0.0, 0.0};
    for (int stage = 0; stage < 4; stage++) {
        real reach = at[stage] * h;
        Vector w = add_scaled(body_rate, reach, slope);
        Quaternion q = add_scaled_quaternion(m.orientation, 0.5 * reach, rate);
        slope = multiply_elements(ratio, vector(w.y * w.z, w.z * w.x, w.x * w.y));
        rate = compose_vector(q, w);
        next.orientation = add_scaled_quaternion(next.orientation, weight[stage] * h / 12.0, rate);
    }
    next.orientation = normalized(next.orientation);
    return next;
}

#include "splitting.c"

typedef Motion (*RigidBodySolver)(const RigidBody *body, const LinearLoads *loads, Motion motion, real elapsed, real h);

/* The solvers whose step is one formula; none for those that iterate or choose their steps. */
static RigidBodySolver rigid_body_solver(int64_t solver)
{
    switch ((RigidBodySolverKind)solver) {
    case RIGID_BODY_SOLVER_EXPLICIT_EULER: return explicit_euler_step;
    case RIGID_BODY_SOLVER_NOTES: return notes_step;
    case RIGID_BODY_SOLVER_RK4: return rk4_step;
    case RIGID_BODY_SOLVER_SPLITTING: return splitting_step;
    case RIGID_BODY_SOLVER_MIDPOINT:
    case RIGID_BODY_SOLVER_MOSER_VESELOV:
    case RIGID_BODY_SOLVER_TAYLOR:
    case RIGID_BODY_SOLVER_EXACT:
    case RIGID_BODY_SOLVER_AUTOMATIC: break;
    }
    return 0;
}
