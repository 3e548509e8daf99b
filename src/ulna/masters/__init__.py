"""Masters: how the units of a scene take one step together. One file each.

A master is a function `prepare(coupling, extrapolation)` that returns `step(time, step, end)`, which takes all units
from `time` to `end = time + step` (seconds) and leaves the outputs at `end` in the coupling. `extrapolation` is the
order, 0 or 1, in which explicit masters continue inputs over a step.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..coupling import Coupling
from . import gauss_seidel, iterated, jacobi, newton, rigid

Step = Callable[[float, float, float], None]


@dataclass(frozen=True)
class Master:
    """A master, and the order of its error in the step, by the order of extrapolation."""

    prepare: Callable[[Coupling, int], Step]
    orders: tuple[int, int]
    implicit: bool = False
    """Whether it solves algebraic loops, the initial values' included."""


MASTERS = {
    "jacobi": Master(jacobi.prepare, (1, 2)),
    "gauss_seidel": Master(gauss_seidel.prepare, (1, 2)),
    "iterated": Master(iterated.prepare, (2, 2), implicit=True),
    "newton": Master(newton.prepare, (2, 2), implicit=True),
    "rigid": Master(rigid.prepare, (4, 4)),
}
