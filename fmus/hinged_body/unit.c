/* HingedBody: the checks and the step. */
#include "unit.h"
#include "internal_steps.h"
#include "mechanics_checks.h"
#include "equations.h"
#include "solvers.c"
#include "taylor.c"
#include "adaptive.c"
#include "stability.c"

static Status hinged_body_check(const HingedBody *body, Log *log)
{
    Status status = check_axis(body->axis, log);
    return status == STATUS_OK ? check_inertia(body->inertia, log) : status;
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
