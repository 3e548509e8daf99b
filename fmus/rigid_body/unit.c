/* RigidBody: the checks and the step. */
#include "unit.h"
#include "internal_steps.h"
#include "mechanics_checks.h"
#include "equations.h"
#include "solvers.c"
#include "geometric.c"
#include "taylor.c"
#include "exact.c"

static Status rigid_body_check(const RigidBody *body, Log *log)
{
    return check_inertia(body->inertia, log);
}

/* Whether anything turns the body over the coming step. */
static inline bool torque_acts(const RigidBody *body, const LinearLoads *loads)
{
    if (!is_zero(loads->start.torque) || !is_zero(loads->slope.torque)) {
        return true;
    }
    bool base = !is_zero(body->base) && !(is_zero(loads->start.base_force) && is_zero(loads->slope.base_force));
    bool tip = !is_zero(body->tip) && !(is_zero(loads->start.tip_force) && is_zero(loads->slope.tip_force));
    return base || tip;
}

/* The solvers of a fixed step, one formula or iterated; none for those that choose their steps. */
static RigidBodySolver fixed_step_solver(int64_t solver)
{
    if (solver == RIGID_BODY_SOLVER_MIDPOINT) {
        return midpoint_step;
    }
    return solver == RIGID_BODY_SOLVER_MOSER_VESELOV ? moser_veselov_step : rigid_body_solver(solver);
}

/* The turn in one internal step, rad, beyond which a solver is of no use: where Euler's steps gain 1 % of
 * energy, rk4 is unstable, and half a turn is sampled once. Those that iterate know by themselves. */
static double largest_turn(int64_t solver)
{
    bool euler = solver == RIGID_BODY_SOLVER_EXPLICIT_EULER || solver == RIGID_BODY_SOLVER_NOTES;
    return euler ? 0.14 : solver == RIGID_BODY_SOLVER_RK4 ? 2.83 : 3.14;
}

/* Says once that the internal step is too long. */
static Status check_turn(RigidBody *body, const Motion *motion, double h, Log *log)
{
    Rotation attitude = rotation(motion->orientation);
    double turn = h * norm(rigid_body_angular_velocity(body, attitude, motion->angular_momentum));
    if (body->warned || !(motion->beyond_limit || turn > largest_turn(body->solver))) {
        return STATUS_OK;
    }
    body->warned = true;
    return report(log, STATUS_WARNING,
                  "the body turns by %.3g rad in an internal step of %g s, beyond the limit of its solver: take a smaller "
                  "solver_step, or the solver automatic", turn, h);
}

static Status fixed_steps(RigidBody *body, const LinearLoads *loads, double step, Motion *motion, Log *log)
{
    RigidBodySolver solve = fixed_step_solver(body->solver);
    if (solve == rk4_step && !torque_acts(body, loads)) {
        solve = rk4_free_step;
    }
    double steps = internal_steps(step, body->solver_step, log);
    if (!(steps > 0.0)) {
        return STATUS_ERROR;
    }
    double h = step / steps;
    for (double i = 0.0; i < steps; i += 1.0) {
        *motion = solve(body, loads, *motion, i * h, h);
    }
    return check_turn(body, motion, h, log);
}

_Static_assert(sizeof(FreeMotion) == sizeof ((RigidBody *)0)->free_motion, "unit.toml: size of free_motion");

static bool same_vector(Vector a, Vector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool same_quaternion(Quaternion a, Quaternion b)
{
    return a.w == b.w && a.x == b.x && a.y == b.y && a.z == b.z;
}

/* The closed form, on from where it has arrived; set up anew where anything else has moved the body. */
static inline void turn_freely(RigidBody *body, double step)
{
    FreeMotion *free = (FreeMotion *)(void *)body->free_motion;
    if (!same_quaternion(body->orientation, body->free_orientation) ||
        !same_vector(body->angular_momentum, body->free_momentum)) {
        *free = free_motion_setup(body->inertia, body->orientation, body->angular_momentum);
        body->free_since = body->time;
        body->free_momentum = body->angular_momentum;
    }
    /* a difference of times, not a sum of steps: no rounding adds up */
    Quaternion attitude = free_motion_attitude(free, body->time + step - body->free_since);
    body->orientation = attitude;
    body->free_orientation = attitude;
}

/* Translation and the closed form, where no torque acts; false where one does. */
static bool free_step(RigidBody *body, double step)
{
    LinearLoads loads = rigid_body_linear_loads(body);
    if (torque_acts(body, &loads)) {
        return false;
    }
    translate(body, &loads, step, &body->position, &body->linear_momentum);
    turn_freely(body, step);
    return true;
}

static double least(Vector v)
{
    return fmin(v.x, fmin(v.y, v.z));
}

static double largest(Vector v)
{
    return fmax(v.x, fmax(v.y, v.z));
}

/* Translation needs no steps at all; rotation takes those that it needs. */
static Status chosen_steps(RigidBody *body, const LinearLoads *loads, double step, Motion *motion, Log *log)
{
    translate(body, loads, step, &motion->position, &motion->linear_momentum);
    double tolerance = body->solver == RIGID_BODY_SOLVER_EXACT ? TAYLOR_ROUND_OFF : body->tolerance;
    /* the rate follows from L and the attitude, whose error a slender body multiplies */
    double ratio = least(body->inertia) / largest(body->inertia);
    double slender = ratio < 0.1 ? ratio : 1.0;
    return taylor_motion(body, loads, fmax(slender * tolerance, TAYLOR_ROUND_OFF), step, motion, log);
}

static Status rigid_body_step(RigidBody *body, double step, Log *log)
{
    bool closed = body->solver == RIGID_BODY_SOLVER_EXACT || body->solver == RIGID_BODY_SOLVER_AUTOMATIC;
    if (closed && free_step(body, step)) {
        return STATUS_OK;
    }
    LinearLoads loads = rigid_body_linear_loads(body);
    Motion motion = {body->position, body->orientation, body->linear_momentum, body->angular_momentum, false};
    Status status = fixed_step_solver(body->solver) ? fixed_steps(body, &loads, step, &motion, log)
                                                    : chosen_steps(body, &loads, step, &motion, log);
    body->position = motion.position;
    body->orientation = motion.orientation;
    body->linear_momentum = motion.linear_momentum;
    body->angular_momentum = motion.angular_momentum;
    return status;
}
