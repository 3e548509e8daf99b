/* RigidBody: the checks and the step. */
#include "unit.h"
#include "internal_steps.h"
#include "equations.h"
#include "solvers.c"
#include "taylor.c"
#include "exact.c"

#include <string.h>

/* No mass distribution has one principal moment larger than the other two together. */
static Status rigid_body_check(const RigidBody *body, Log *log)
{
    const double moments[3] = {body->inertia.x, body->inertia.y, body->inertia.z};
    for (int i = 0; i < 3; i++) {
        double others = moments[(i + 1) % 3] + moments[(i + 2) % 3];
        if (moments[i] > others * (1.0 + 1e-9)) {
            return report(log, STATUS_ERROR,
                          "inertia[%d] = %g kg.m2 is more than the other two principal moments together (%g); "
                          "allowed range: at most their sum", i + 1, moments[i], others);
        }
    }
    return STATUS_OK;
}

static Status fixed_steps(const RigidBody *body, const LinearLoads *loads, double step, Motion *motion, Log *log)
{
    RigidBodySolver solve = rigid_body_solver(body->solver);
    double steps = internal_steps(step, body->solver_step, log);
    if (!(steps > 0.0)) {
        return STATUS_ERROR;
    }
    double h = step / steps;
    for (double i = 0.0; i < steps; i += 1.0) {
        *motion = solve(body, loads, *motion, i * h, h);
    }
    return STATUS_OK;
}

/* Whether anything turns the body over the coming step. */
static bool torque_acts(const RigidBody *body, const LinearLoads *loads)
{
    bool base = !is_zero(body->base) && !(is_zero(loads->start.base_force) && is_zero(loads->slope.base_force));
    bool tip = !is_zero(body->tip) && !(is_zero(loads->start.tip_force) && is_zero(loads->slope.tip_force));
    return base || tip || !is_zero(loads->start.torque) || !is_zero(loads->slope.torque);
}

_Static_assert(sizeof(FreeMotion) == sizeof ((RigidBody *)0)->free_motion, "unit.toml: size of free_motion");

/* The closed form, on from where it has arrived; set up anew where anything else has moved the body. */
static void free_steps(RigidBody *body, double step, Motion *motion)
{
    FreeMotion free;
    if (memcmp(&motion->orientation, &body->free_orientation, sizeof(Quaternion)) != 0 ||
        memcmp(&motion->angular_momentum, &body->free_momentum, sizeof(Vector)) != 0) {
        free = free_motion_setup(body->inertia, motion->orientation, motion->angular_momentum);
        memcpy(body->free_motion, &free, sizeof free);
        body->free_since = body->time;
        body->free_momentum = motion->angular_momentum;
    }
    memcpy(&free, body->free_motion, sizeof free);
    /* a difference of times, not a sum of steps: no rounding adds up */
    motion->orientation = free_motion_attitude(&free, body->time + step - body->free_since);
    body->free_orientation = motion->orientation;
}

/* Translation needs no steps at all; rotation takes those that it needs. */
static Status chosen_steps(RigidBody *body, const LinearLoads *loads, double step, Motion *motion, Log *log)
{
    *motion = translated(body, loads, *motion, step);
    if (body->solver != RIGID_BODY_SOLVER_TAYLOR && !torque_acts(body, loads)) {
        free_steps(body, step, motion);
        return STATUS_OK;
    }
    double tolerance = body->solver == RIGID_BODY_SOLVER_EXACT ? TAYLOR_ROUND_OFF : body->tolerance;
    return taylor_motion(body, loads, tolerance, step, motion, log);
}

static Status rigid_body_step(RigidBody *body, double step, Log *log)
{
    LinearLoads loads = rigid_body_linear_loads(body);
    Motion motion = {body->position, body->orientation, body->linear_momentum, body->angular_momentum};
    Status status = rigid_body_solver(body->solver) ? fixed_steps(body, &loads, step, &motion, log)
                                                    : chosen_steps(body, &loads, step, &motion, log);
    body->position = motion.position;
    body->orientation = motion.orientation;
    body->linear_momentum = motion.linear_momentum;
    body->angular_momentum = motion.angular_momentum;
    return status;
}
