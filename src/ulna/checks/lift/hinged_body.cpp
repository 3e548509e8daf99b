// One internal step of each solver whose step is one formula, `elapsed` seconds after the communication step began.
#include "solvers.c"

static bool lift_step(Lift &lift, const HingedBody &body, int64_t solver)
{
    Swing before = {body.angle, body.rate};
    Real elapsed = lift.symbols<Real>("elapsed");
    Swing after = hinged_body_solver(solver)(&body, before, elapsed, lift.symbols<Real>("h"));
    lift.output("angle", after.angle);
    lift.output("rate", after.rate);
    return true;
}
