"""Jacobi: every unit steps with what the others put out, and with the signals, at the start of the step.

Order 1 in the step. The order of the units does not matter, and no unit waits for another. A value needs one step
for every unit that it passes directly, so an output that depends directly on an input shows the input of the step's
start.
"""

from collections.abc import Callable

from ..coupling import Coupling


def prepare(coupling: Coupling) -> Callable[[float, float, float], None]:
    """The step of this master for these units."""
    stage = coupling.stage(coupling.units)

    def step(time: float, step: float, end: float) -> None:
        coupling.time.value = time
        coupling.step.value = step
        coupling.run(stage, time)

    return step
