/* RigidBody: the checks and the step. */
#include "unit.h"
#include "internal_steps.h"
#include "equations.h"
#include "solvers.c"

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

static Status rigid_body_step(RigidBody *body, double step, Log *log)
{
    RigidBodySolver solve = rigid_body_solver(body->solver);
    double steps = internal_steps(step, body->solver_step, log);
    if (!(steps > 0.0)) {
        return STATUS_ERROR;
    }
    double h = step / steps;
    LinearLoads loads = rigid_body_linear_loads(body);
    Motion motion = {body->position, body->orientation, body->linear_momentum, body->angular_momentum};
    for (double i = 0.0; i < steps; i += 1.0) {
        motion = solve(body, &loads, motion, i * h, h);
    }
    body->position = motion.position;
    body->orientation = motion.orientation;
    body->linear_momentum = motion.linear_momentum;
    body->angular_momentum = motion.angular_momentum;
    return STATUS_OK;
}
