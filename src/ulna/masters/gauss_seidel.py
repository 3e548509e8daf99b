"""Gauss-Seidel: the units step one after the other, each with what those before it put out at the end of the step.

Order 1 in the step, with smaller errors than Jacobi where the order of the units follows their dependencies: without
a loop every row is consistent, outputs with the inputs they depend on. Signals are taken at the end of the step, as
if a unit had been stepped first. A connection against the order carries the value at the start of the step;
`Scene.loops` names these.

With extrapolation inputs are lines over the step, to what the units before put out at its end, and against the order
on through the last two steps: order 2.
"""

from collections.abc import Callable

from ..coupling import Coupling
from ..lines import Lines, late_connections
from .jacobi import extrapolated


def prepare(coupling: Coupling, extrapolation: int) -> Callable[[float, float, float], None]:
    """The step of this master for these units."""
    groups = [[unit] for unit in coupling.order]
    if extrapolation:
        return extrapolated(Lines(coupling, groups))
    coupling.late = late_connections(coupling, groups)
    stage = coupling.stage(groups)

    def step(time: float, step: float, end: float) -> None:
        coupling.time.value = time
        coupling.step.value = step
        coupling.run(stage, end)

    return step
