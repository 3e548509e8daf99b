"""What all benchmarks share: units made ready, times taken side by side, and an independent integrator."""

from collections.abc import Callable, Hashable, Mapping
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..slave import Slave

Array = NDArray[np.float64]
TOLERANCE = 3e-14  # the least that SciPy takes is 2.2e-14


def started(unit: str, **values: Any) -> Slave:
    """A unit with these parameters and inputs, initialized at 0 s."""
    slave = Slave(unit)
    for name, value in values.items():
        slave.set(name, value)
    slave.initialize()
    return slave


def choices(unit: str, parameter: str) -> list[str]:
    """Entries of an enumeration, in the order in which the unit declares them."""
    with Slave(unit) as slave:
        return [entry for entry, _ in slave.variable(parameter).entries]


# Their work does not depend on solver_step: `ulna chart` shows them.
CHOOSE_THEIR_STEPS = {"taylor", "exact", "automatic"}


def fixed_step_solvers(unit: str) -> list[str]:
    """The solvers of a unit that take equal steps."""
    return [solver for solver in choices(unit, "solver") if solver not in CHOOSE_THEIR_STEPS]


def repeated_step(slave: Slave, duration: float) -> Callable[[], None]:
    """A call that takes the same one step from the present state, each time anew."""
    state = slave.save()

    def step() -> None:
        slave.restore(state)
        slave.step(0.0, duration)

    return step


def side_by_side(calls: Mapping[Hashable, Callable[[], Any]], rounds: int) -> dict[Hashable, tuple[float, float]]:
    """Median seconds of each call over the rounds, and the ratio to the cheapest.

    Every round times every call once, so that a machine that changes its pace does so for all. One round before is not
    counted.
    """

    def clocked(call: Callable[[], Any]) -> float:
        start = perf_counter()
        call()
        return perf_counter() - start

    medians = interleaved({name: partial(clocked, call) for name, call in calls.items()}, rounds)
    least = min(medians.values())
    return {name: (s, s / least) for name, s in medians.items()}


def interleaved(runs: Mapping[Hashable, Callable[[], float]], rounds: int) -> dict[Hashable, float]:
    """Median over the rounds of the seconds that each run returns; every round runs each once, one before uncounted."""
    times = np.array([[run() for run in runs.values()] for _ in range(rounds + 1)])
    return dict(zip(runs, np.median(times[1:], axis=0).tolist(), strict=True))


def integrated(slope: Callable[[float, Array], Any], first: Any, end: float) -> Array:
    """State [n] at `end` s by SciPy's DOP853 at TOLERANCE; raises ModuleNotFoundError without SciPy."""
    try:
        from scipy.integrate import solve_ivp
    except ModuleNotFoundError:
        raise ModuleNotFoundError("the references need SciPy: pip install 'ulna[test]'") from None
    return solve_ivp(slope, (0.0, end), first, method="DOP853", rtol=TOLERANCE, atol=0.01 * TOLERANCE).y[:, -1]
