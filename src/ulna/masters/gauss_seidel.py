"""Gauss-Seidel: the units step one after the other, each with what those before it put out at the end of the step.

Order 1 in the step, with smaller errors than Jacobi where the order of the units follows their dependencies: without
a loop every row is consistent, outputs with the inputs they depend on. Signals are taken at the end of the step, as
if a unit had been stepped first. A connection against the order carries the value at the start of the step;
`Scene.loops` names these.
"""

from collections.abc import Callable

from ..coupling import Coupling


def prepare(coupling: Coupling) -> Callable[[float, float, float], None]:
    """The step of this master for these units."""
    stages = [coupling.stage([unit]) for unit in coupling.order]

    def step(time: float, step: float, end: float) -> None:
        coupling.time.value = time
        coupling.step.value = step
        for stage in stages:
            coupling.run(stage, end)

    return step
