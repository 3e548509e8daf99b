"""Masters: how the units of a scene take one step together. One file each.

A master is a function `prepare(coupling)` that returns `step(time, step, end)`, which takes all units from `time` to
`end = time + step` (seconds) and leaves the outputs at `end` in the coupling.
"""

from collections.abc import Callable

from ..coupling import Coupling
from . import gauss_seidel, jacobi

Step = Callable[[float, float, float], None]

MASTERS: dict[str, Callable[[Coupling], Step]] = {
    "jacobi": jacobi.prepare,
    "gauss_seidel": gauss_seidel.prepare,
}
