// One internal step of each solver, `elapsed` seconds after the communication step began.
#include "solvers.c"

static void lift_step(Lift &lift, const RigidBody &body, int64_t solver)
{
    LinearLoads loads = rigid_body_linear_loads(&body);
    Motion before = {body.position, body.orientation, body.linear_momentum, body.angular_momentum};
    Real elapsed = lift.symbols<Real>("elapsed");
    Motion after = rigid_body_solver(solver)(&body, &loads, before, elapsed, lift.symbols<Real>("h"));
    lift.output("position", after.position);
    lift.output("orientation", after.orientation);
    lift.output("linear_momentum", after.linear_momentum);
    lift.output("angular_momentum", after.angular_momentum);
}
