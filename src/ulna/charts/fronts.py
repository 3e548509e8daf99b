"""What the points say: the front of each solver, what an accuracy costs, and which solver is cheapest for it."""

from collections.abc import Iterable, Sequence
from typing import Protocol, TypeVar

import numpy as np


class Priced(Protocol):
    """A point of a chart: error in rad, seconds per simulated second, and whatever else counts as work."""

    @property
    def solver(self) -> str:
        """What is chosen among."""

    @property
    def error(self) -> float:
        """rad."""

    @property
    def seconds(self) -> float:
        """Per simulated second."""


P = TypeVar("P", bound=Priced)
DEFAULT = "automatic"
AS_CHEAP = 1.15
"""Where the default costs at most this much more than the cheapest, it is the one to take."""


def solvers_of(points: Iterable[Priced]) -> list[str]:
    """Names in the order in which they come."""
    return list(dict.fromkeys(point.solver for point in points))


def front(points: Iterable[P], work: str = "seconds") -> list[P]:
    """Those that no other beats in both error and work, from coarse to accurate."""
    best: list[P] = []
    for point in sorted(points, key=lambda p: (getattr(p, work), p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return best


def cost(points: Iterable[Priced], error: float, work: str = "seconds") -> float:
    """Work per simulated second of one solver at an error (rad), straight in log-log between its points.

    Infinite where it does not get there.
    """
    best = front(points, work)
    if not best or error < best[-1].error:
        return float("inf")
    # np.interp wants rising abscissae; an error of zero is as good as a round-off
    errors = [np.log(max(point.error, 1e-17)) for point in reversed(best)]
    return float(np.exp(np.interp(np.log(error), errors, [np.log(getattr(p, work)) for p in reversed(best)])))


def cheapest(points: Sequence[Priced], error: float, work: str = "seconds") -> str | None:
    """The solver to take for an error (rad): the default where it is as cheap as any; None if none gets there."""
    costs = {name: cost([p for p in points if p.solver == name], error, work) for name in solvers_of(points)}
    least = min(costs.values(), default=float("inf"))
    if not np.isfinite(least):
        return None
    if costs.get(DEFAULT, float("inf")) <= AS_CHEAP * least:
        return DEFAULT
    return min(costs, key=costs.__getitem__)
