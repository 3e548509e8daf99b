"""Jacobi: every unit steps with what the others put out, and with the signals, at the start of the step.

Order 1 in the step. The order of the units does not matter, and no unit waits for another. A value needs one step
for every unit that it passes directly, so an output that depends directly on an input shows the input of the step's
start.

With extrapolation the inputs go on along the line through the last two steps, and outputs are read with the inputs
where that line ends: order 2, and a value passes several units directly in one step.
"""

from collections.abc import Callable

from ..coupling import Coupling
from ..lines import Lines, late_connections


def prepare(coupling: Coupling, extrapolation: int) -> Callable[[float, float, float], None]:
    """The step of this master for these units."""
    if extrapolation:
        return extrapolated(Lines(coupling, [coupling.units]))
    coupling.late = late_connections(coupling, [coupling.units])
    stage = coupling.stage([coupling.units])

    def step(time: float, step: float, end: float) -> None:
        coupling.time.value = time
        coupling.step.value = step
        coupling.run(stage, time)

    return step


def extrapolated(lines: Lines) -> Callable[[float, float, float], None]:
    """The step with inputs that are lines, of which none is corrected."""

    def step(time: float, step: float, end: float) -> None:
        lines.begin(time, step, end)
        lines.sweep()
        lines.finish()

    return step
