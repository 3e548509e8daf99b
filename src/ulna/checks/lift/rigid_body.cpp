// One internal step of each solver whose step is one formula, `elapsed` seconds after the communication step began.
#include "solvers.c"

static bool lift_step(Lift &lift, const RigidBody &body, int64_t solver)
{
    RigidBodySolver solve = rigid_body_solver(solver);
    if (!solve) {
        return false;
    }
    LinearLoads loads = rigid_body_linear_loads(&body);
    Motion before = {body.position, body.orientation, body.linear_momentum, body.angular_momentum, false};
    Real elapsed = lift.symbols<Real>("elapsed");
    Motion after = solve(&body, &loads, before, elapsed, lift.symbols<Real>("h"));
    lift.output("position", after.position);
    lift.output("orientation", after.orientation);
    lift.output("linear_momentum", after.linear_momentum);
    lift.output("angular_momentum", after.angular_momentum);
    return true;
}
