/* HingedBody: the checks and the step. */
#include "unit.h"
#include "internal_steps.h"
#include "equations.h"
#include "solvers.c"
#include "taylor.c"
#include "adaptive.c"
#include "stability.c"

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

/* Whether the anchor turns at any time of the step. */
static bool anchor_turns(const HingedBody *body)
{
    return norm(body->anchor_angular_velocity) > 0.0 || norm(body->anchor_angular_acceleration) > 0.0
           || norm(body->anchor_angular_acceleration_rate) > 0.0;
}

/* Says once that steps of h are beyond what the solver bears. */
static void warn_of_unstable_steps(HingedBody *body, const Hinge *hinge, double h, Log *log)
{
    if (body->warned) {
        return;
    }
    Oscillator oscillator = stiffest_oscillator(hinge);
    if (step_is_stable(body->solver, oscillator, h)) {
        return;
    }
    body->warned = true;
    report(log, STATUS_WARNING,
           "the solver is unstable with internal steps of %.3g s, stable up to %.3g s (stiffness %.3g 1/s2, damping %.3g "
           "1/s, over the inertia about the axis): lower solver_step, or take automatic",
           h, stable_step(body->solver, oscillator, h), oscillator.stiffness, oscillator.damping);
}

static Status fixed_swing(HingedBody *body, const Hinge *hinge, Swing *swing, double step, Log *log)
{
    HingedBodySolver solve = hinged_body_solver(body->solver);
    double steps = internal_steps(step, body->solver_step, log);
    if (!(steps > 0.0)) {
        return STATUS_ERROR;
    }
    double h = step / steps;
    warn_of_unstable_steps(body, hinge, h, log);
    for (double i = 0.0; i < steps; i += 1.0) {
        *swing = solve(hinge, *swing, i * h, h);
    }
    return STATUS_OK;
}

static Status hinged_body_step(HingedBody *body, double step, Log *log)
{
    Hinge hinge = hinge_of(body, anchor_turns(body));
    Swing swing = {body->angle, body->rate};
    bool fixed = hinged_body_solver(body->solver) != NULL;
    Status status = fixed ? fixed_swing(body, &hinge, &swing, step, log)
                          : adaptive_swing(&hinge, &swing, step, body->tolerance, log);
    body->angle = swing.angle;
    body->rate = swing.rate;
    return status;
}
