"""CompliantJoint: what its wrenches cost through FMI, beside the exchange with a body that it holds."""

from collections.abc import Callable, Sequence
from typing import Any

from ..slave import Slave
from .measuring import side_by_side, started
from .tables import Table

CALLS = 1000
STEP = 0.0005  # s
FRAME = ("position", "orientation", "velocity", "angular_velocity")
MOTION = [f"{body}_{name}" for body in ("first", "second") for name in FRAME]
WRENCHES = [f"{body}_{name}" for body in ("first", "second") for name in ("force", "torque")]
BENT = {"second_position": [1e-4, 0, -2e-4], "second_orientation": [0.8, 0, 0.6, 0], "second_velocity": [0, 0.01, 0]}
LOADS = {"tip_force": [1.0, 2.0, 3.0], "tip_torque": [0.1, 0.2, 0.3]}
TIP = ("tip_position", "orientation", "tip_velocity", "angular_velocity")


def exchange(unit: str, inputs: Sequence[str], outputs: Sequence[str], step: bool, **values: Any) -> Callable[[], None]:
    """A call that CALLS times sets inputs, if any, to what they are, steps if told to, and reads outputs."""
    slave: Slave = started(unit, **values)
    state = slave.save()
    calls = [slave.getter(outputs)]
    if inputs:
        setter = slave.setter(inputs)
        setter.values[:] = [element for name in inputs for element in slave.get(name)]
        calls.insert(0, setter)

    def run() -> None:
        slave.restore(state)
        for row in range(CALLS):
            calls[0]()
            if step:
                slave.step(row * STEP, STEP)
            calls[-1]()

    return run


def bench(rounds: int) -> list[Table]:
    """Time of a read, of an evaluation, and of the exchange of one communication step, of the joint and of a body."""
    body = {"tip": [0.3, 0.0, 0.0], "solver_step": STEP, **LOADS}
    calls = {
        "wrenches read twice": exchange("CompliantJoint", [], WRENCHES, False, **BENT),
        "motion set, wrenches read": exchange("CompliantJoint", MOTION, WRENCHES, False, **BENT),
        "motion set, stepped, wrenches read": exchange("CompliantJoint", MOTION, WRENCHES, True, **BENT),
        **{
            f"RigidBody, {solver}: wrench set, stepped, tip read": exchange(
                "RigidBody", list(LOADS), TIP, True, solver=solver, **body
            )
            for solver in ("rk4", "automatic")
        },
    }
    cost = side_by_side(calls, rounds)
    return [
        Table(
            "CompliantJoint: exchange",
            f"{CALLS} times in a row from Python, whose calls of C are most of it; steps of {1e3 * STEP:g} ms, "
            "the body with a force and a torque at its tip.",
            ("what is done", "us", "ratio"),
            [(name, seconds / CALLS * 1e6, ratio) for name, (seconds, ratio) in cost.items()],
        )
    ]
