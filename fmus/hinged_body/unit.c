/* HingedBody: the checks and the step. */
#include "unit.h"
#include "internal_steps.h"
#include "equations.h"
#include "solvers.c"

#include <math.h>

static Status hinged_body_check(const HingedBody *body, Log *log)
{
    double length = norm(body->axis);
    if (fabs(length - 1.0) > 1e-9) {
        return report(log, STATUS_ERROR,
                      "axis = [%g, %g, %g] has length %.12g; allowed range: 1 within 1e-9, divide it by its length",
                      body->axis.x, body->axis.y, body->axis.z, length);
    }
    /* No mass distribution has one principal moment larger than the other two together. */
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

static Status hinged_body_step(HingedBody *body, double step, Log *log)
{
    HingedBodySolver solve = hinged_body_solver(body->solver);
    double steps = internal_steps(step, body->solver_step, log);
    if (!(steps > 0.0)) {
        return STATUS_ERROR;
    }
    double h = step / steps;
    Swing swing = {body->angle, body->rate};
    for (double i = 0.0; i < steps; i += 1.0) {
        swing = solve(body, swing, i * h, h);
    }
    body->angle = swing.angle;
    body->rate = swing.rate;
    return STATUS_OK;
}
