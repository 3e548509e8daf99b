// One internal step of each solver of a fixed step, `elapsed` seconds after the communication step began.
#include "solvers.c"

static bool lift_step(Lift &lift, const HingedBody &body, int64_t solver)
{
    HingedBodySolver step = hinged_body_solver(solver);
    if (!step) {
        return false;
    }
    Hinge hinge = hinge_of(&body, true);
    Swing before = {body.angle, body.rate};
    Real elapsed = lift.symbols<Real>("elapsed"), h = lift.symbols<Real>("h");
    Swing after = step(&hinge, before, elapsed, h);
    lift.output("angle", after.angle);
    lift.output("rate", after.rate);
    return true;
}
