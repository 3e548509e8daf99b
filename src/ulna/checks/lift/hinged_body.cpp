// One internal step of each solver, and of the Taylor series at a fixed order, `elapsed` seconds after the communication step began.
#include "solvers.c"
#include "taylor.c"

// What `automatic` and `taylor` sum, at a fixed order and for one step of the series.
static const int TAYLOR_ORDER = 5;

static Swing taylor_step(const Hinge *hinge, Swing swing, Real elapsed, Real h)
{
    static SwingSeries series;
    series.swayed = true;
    Rotation anchor = rotation(anchor_orientation_at(hinge->body, elapsed));
    start_series(&series, hinge, swing, anchor, elapsed, h);
    for (int n = 1; n <= TAYLOR_ORDER; n++) {
        extend_series(&series, n);
    }
    return swing_of_series(&series, TAYLOR_ORDER, 1.0);
}

static bool lift_step(Lift &lift, const HingedBody &body, int64_t solver)
{
    Hinge hinge = hinge_of(&body, true);
    Swing before = {body.angle, body.rate};
    Real elapsed = lift.symbols<Real>("elapsed"), h = lift.symbols<Real>("h");
    HingedBodySolver step = hinged_body_solver(solver);
    Swing after = (step ? step : taylor_step)(&hinge, before, elapsed, h);
    lift.output("angle", after.angle);
    lift.output("rate", after.rate);
    return true;
}
