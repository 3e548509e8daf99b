"""Points of the chart: what is run, how far off it ends, and what it costs, all in one interleaved run."""

import math
from collections.abc import Callable, Iterable, Iterator
from ctypes import c_void_p, cast
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from ..bench.measuring import choices
from ..slave import Slave, UnitError
from .counting import counting_fmu
from .driver import compiled
from .problems import Problem

SHORTEST = 2e-4
"""Seconds that one timing lasts at least."""
MOST_COUNTED = 1000
"""Steps over which right-hand sides are counted where all steps are alike."""
COMMUNICATION_STEPS = (10.0, 1.0, 0.1, 0.01, 0.001)
STEP, TOLERANCE, COMMUNICATION = "solver_step", "tolerance", "communication_step"


@dataclass(frozen=True)
class Candidate:
    """One solver with one step or tolerance: a run of the whole problem, which gives the seconds it took."""

    problem: str
    solver: str
    parameter: str
    value: float
    error: float
    """rad, at the end."""
    evaluations: float | None
    """Right-hand sides of the whole run."""
    run: Callable[[], float]


@dataclass(frozen=True)
class Point:
    """What is written down of a candidate: seconds and evaluations per simulated second, error in rad at the end."""

    problem: str
    solver: str
    parameter: str
    value: float
    error: float
    seconds: float
    evaluations: float | None


@dataclass(frozen=True)
class Effort:
    """How finely steps and tolerances are laid out, and how often each is timed."""

    per_decade: int
    finest: float
    """Shortest step over the problem's coarsest."""
    rounds: int
    longest: float
    """Seconds for one run; what takes longer is left out."""
    stride: int
    """Of the tolerances of those peers that call Python, every how many-th is tried."""


FULL = Effort(per_decade=4, finest=1e-4, rounds=5, longest=0.3, stride=1)
QUICK = Effort(per_decade=2, finest=1e-3, rounds=3, longest=0.05, stride=3)


def decades(first: float, last: float, per_decade: int) -> list[float]:
    """Numbers from `first` down to `last`, evenly in the logarithm; powers of ten are among them."""
    high, low = math.floor(math.log10(first) * per_decade + 1e-9), math.ceil(math.log10(last) * per_decade - 1e-9)
    return [float(f"{10 ** (n / per_decade):.3g}") for n in range(high, low - 1, -1)]


class Runner:
    """One instance of a unit, with a saved state for each setting that was tried."""

    def __init__(self, problem: Problem, fmu: str | PathLike | None = None):
        """Raises FileNotFoundError where the unit is not built or there is no C compiler."""
        self.problem = problem
        self.slave = Slave(fmu or problem.unit)
        self._driver = compiled("driver")
        self._functions = [cast(self.slave.function(name), c_void_p) for name in ("fmi3DoStep", "fmi3SetFMUState")]

    def start(self, solver: str, **settings: Any) -> c_void_p:
        """A saved state at 0 s."""
        self.slave.reset()
        for name, value in {**self.problem.values, "solver": solver, **settings}.items():
            self.slave.set(name, value)
        self.slave.initialize()
        return self.slave.save()

    def end(self, state: c_void_p, count: int = 1) -> Any:
        """The orientation or angle after `count` communication steps to the end; raises UnitError."""
        self.slave.restore(state)
        step = self.problem.end / count
        for k in range(count):
            self.slave.step(k * step, step)
        return self.slave.get(self.problem.output)

    def seconds(self, state: c_void_p, count: int, repeats: int) -> float:
        """Mean seconds of a run to the end; negative where a step fails."""
        step = self.problem.end / count
        return self._driver.time_steps(*self._functions, self.slave.component, state, step, count, repeats)


def parameter_of(runner: Runner, solver: str) -> str:
    """What rules a solver's accuracy on a problem: found by trying, so that no list of solvers need be kept."""
    coarsest = runner.problem.coarsest
    pairs = {
        STEP: ({STEP: coarsest}, {STEP: coarsest / 7}),
        TOLERANCE: ({TOLERANCE: 1e-3}, {TOLERANCE: 1e-9}),
    }
    for name, settings in pairs.items():
        if name in runner.slave.description.variables:
            first, second = (runner.end(runner.start(solver, **values)) for values in settings)
            if np.max(np.abs(first - second)) > 1e-13:
                return name
    return COMMUNICATION


def unit_candidates(problem: Problem, effort: Effort) -> Iterator[Candidate]:
    """Every solver of the unit at every setting; what fails or takes too long is left out."""
    runner = Runner(problem)
    counter = Counter(problem)
    for solver in choices(problem.unit, "solver"):
        parameter = parameter_of(runner, solver)
        for value in values_of(parameter, problem, effort):
            candidate = unit_candidate(runner, counter, solver, parameter, value, effort.longest)
            if candidate:
                yield candidate


def values_of(parameter: str, problem: Problem, effort: Effort) -> list[float]:
    """The settings that are tried."""
    if parameter == STEP:
        return decades(problem.coarsest, problem.coarsest * effort.finest, effort.per_decade)
    if parameter == TOLERANCE:
        return decades(1e-2, 1e-14, max(1, effort.per_decade // 2))
    return [problem.end, *(step for step in COMMUNICATION_STEPS if step < problem.end)]


def unit_candidate(
    runner: Runner, counter: "Counter", solver: str, parameter: str, value: float, longest: float
) -> Candidate | None:
    """One setting of one solver, after a first run that says how often it must be repeated to be timed."""
    problem = runner.problem
    settings = {} if parameter == COMMUNICATION else {parameter: value}
    count = round(problem.end / value) if parameter == COMMUNICATION else 1
    try:
        state = runner.start(solver, **settings)
        error = problem.error(runner.end(state, count))
    except UnitError:
        return None
    first = runner.seconds(state, count, 1)
    if not (math.isfinite(error) and 0.0 < first < longest):
        return None
    repeats = max(1, math.ceil(SHORTEST / first))
    return Candidate(
        problem.name,
        solver,
        parameter,
        value,
        error,
        counter(solver, parameter, value),
        lambda: runner.seconds(state, count, repeats),
    )


class Counter:
    """Counts the right-hand sides of a run."""

    def __init__(self, problem: Problem):
        """Raises RuntimeError if the unit that counts does not compile."""
        path, self._counted = counting_fmu(problem.unit)
        self._runner = Runner(problem, path)

    def __call__(self, solver: str, parameter: str, value: float) -> float | None:
        """Of the whole run; where all steps are alike, from as many of them as are needed.

        None where nothing was counted of a solver that makes steps: then its functions are unknown to the counter.
        """
        runner = self._runner
        settings = {} if parameter == COMMUNICATION else {parameter: value}
        end = runner.problem.end
        duration = end if parameter == TOLERANCE else min(end, MOST_COUNTED * value)
        count = round(duration / value) if parameter == COMMUNICATION else 1
        runner.slave.restore(runner.start(solver, **settings))
        self._counted.value = 0.0
        for k in range(count):
            runner.slave.step(k * duration / count, duration / count)
        if self._counted.value == 0.0 and parameter != COMMUNICATION:
            return None
        return self._counted.value * end / duration


def timed(candidates: Iterable[Candidate], end: float, rounds: int) -> list[Point]:
    """Median times. Every round times every candidate once: a machine that changes its pace does so for all."""
    candidates = list(candidates)
    seconds = np.array([[candidate.run() for candidate in candidates] for _ in range(rounds)])
    return [
        Point(
            candidate.problem,
            candidate.solver,
            candidate.parameter,
            candidate.value,
            candidate.error,
            float(median) / end,
            None if candidate.evaluations is None else candidate.evaluations / end,
        )
        for candidate, median in zip(candidates, np.median(seconds, axis=0), strict=True)
    ]
