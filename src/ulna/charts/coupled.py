"""Points of the chart of couplings: how far off an arm ends, and what it costs, all in one interleaved run."""

import math
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from time import thread_time

import numpy as np

from ..checks.textbook import load_model
from ..coupling import CouplingError
from ..results import Results
from ..scene import Scene
from ..slave import UnitError
from .arms import JointedArm
from .reference import Array
from .ways import WAYS, Stepping, Way

COMPARED = 0.5
"""s between the rows at which orientations are compared."""
ROWS = 0.02
"""s between the rows where a tolerance chooses the macro steps: no step is longer."""


@dataclass(frozen=True)
class CoupledEffort:
    """How finely macro steps and tolerances are laid out, and how often each run is timed."""

    steps: tuple[float, ...]
    """s, falling: halves, so that orders are seen."""
    tolerances: tuple[float, ...]
    lengths: tuple[int, ...]
    """Of chains."""
    rounds: int
    most: float
    """Steps of units in a run; what is likely to take more is left out."""
    end: float
    """s: until then the arm swings."""
    macro_rounds: int
    """Of the masters' own cost."""


COARSEST = 0.02
FULL = CoupledEffort(
    tuple(COARSEST / 2**k for k in range(8)),
    tuple(10.0**-k for k in range(1, 6)),
    tuple(range(1, 11)),
    rounds=5,
    most=2e5,
    end=5.0,
    macro_rounds=51,
)
QUICK = CoupledEffort((0.01, 0.0025, 0.000625), (1e-2,), (1, 2, 5, 10), rounds=1, most=3e4, end=2.0, macro_rounds=5)


@dataclass(frozen=True)
class CoupledPoint:
    """One way, stepped by one master: error in rad, seconds and steps of units per simulated second."""

    way: str
    master: str
    step: float
    """s; with a tolerance, of the rows."""
    tolerance: float | None
    error: float
    """The largest angle between a body and the reference at the rows compared."""
    seconds: float
    unit_steps: float
    macro_steps: float
    wrong: bool
    """Whether the run itself said so."""
    largest_gap: float | None
    """m, of rigid joints."""

    @property
    def solver(self) -> str:
        """Way and master: what is chosen."""
        return f"{self.way}: {self.master}"


@dataclass(frozen=True)
class Failure:
    """A run that did not get to the end, and why."""

    way: str
    master: str
    step: float
    tolerance: float | None
    reason: str


class Truth:
    """Orientations of the bodies of an arm by the reference in minimal coordinates."""

    def __init__(self, arm: JointedArm):
        """Raises ModuleNotFoundError, with what installs them, without CasADi and SciPy."""
        try:
            model = load_model("jointed_arm")
            self.times = np.arange(round(arm.end / COMPARED) + 1) * COMPARED
            bodies = model.jointed_arm(arm.bodies, arm.joints)
            states = model.reference(bodies, arm.state, self.times)
        except ModuleNotFoundError as error:
            message = f"the reference of the arm needs {error.name}: pip install 'ulna[peers]' brings CasADi and SciPy"
            raise ModuleNotFoundError(message, name=error.name) from None
        self.orientations = bodies.results(states)["orientation"]

    def error(self, results: Results) -> float:
        """rad; the columns are the orientations of the bodies, in order."""
        rows = np.searchsorted(results.time, self.times - 1e-9)
        found = np.stack([results[name][rows] for name in results], axis=1)
        return float(angles(found, self.orientations).max())


def angles(found: Array, true: Array) -> Array:
    """rad between unit quaternions [..., 4], small ones to the last digit."""
    chord = np.minimum(np.linalg.norm(found - true, axis=-1), np.linalg.norm(found + true, axis=-1))
    return 4.0 * np.arcsin(np.minimum(1.0, chord / 2.0))


@dataclass(frozen=True)
class Trial:
    """What a timed run needs, and what is known from the run before it."""

    way: str
    scene: Scene
    stepping: Stepping
    step: float
    tolerance: float | None
    end: float
    results: Results
    unit_steps: int

    def seconds(self) -> float:
        """Processor seconds of one run from its first row to its last."""
        return run(self.scene, self.stepping, self.step, self.tolerance, self.end)[1]


def run(scene: Scene, stepping: Stepping, step: float, tolerance: float | None, end: float) -> tuple[Results, float]:
    """A run, and its processor seconds without those of setting up; raises UnitError and CouplingError."""
    marks: list[float] = []
    with warnings.catch_warnings():
        # that initial values do not settle, and that the coupling is wrong: errors show the one, the summary the other
        warnings.simplefilter("ignore", UserWarning)
        results = scene.run(
            end,
            step,
            master=stepping.master,
            extrapolation=stepping.extrapolation,
            tolerance=tolerance,
            progress=lambda _: marks.append(thread_time()),
        )
    return results, marks[-1] - marks[0]


def counted(scene: Scene, *how: object) -> tuple[Results, int]:
    """As `run`, but gives how many steps units took, repeated ones included."""
    count = 0

    def counting(plain: Callable) -> Callable:
        def step_call(*places: object) -> tuple[Callable, tuple]:
            function, arguments = plain(*places)

            def step(*given: object) -> int:
                nonlocal count
                count += 1
                return function(*given)

            return step, arguments

        return step_call

    slaves = [unit.slave for unit in scene.units.values()]
    for slave in slaves:
        slave.step_call = counting(slave.step_call)
    try:
        return run(scene, *how)[0], count
    finally:
        for slave in slaves:
            del slave.step_call


def settings(stepping: Stepping, effort: CoupledEffort) -> list[tuple[float, float | None]]:
    """Steps and tolerances, coarse ones first."""
    if stepping.chosen:
        return [(ROWS, tolerance) for tolerance in effort.tolerances]
    return [(step, None) for step in effort.steps]


def trials(way: Way, scene: Scene, truth: Truth, end: float, effort: CoupledEffort) -> Iterator[Trial | Failure]:
    """All steps and tolerances of a way, coarse ones first."""
    for stepping in way.steppings:
        coarser: tuple[float, float] | None = None
        for step, tolerance in settings(stepping, effort):
            # steps of units go with the number of macro steps, and that, by a tolerance, as with order 2
            fineness = 1.0 / step if tolerance is None else tolerance**-0.5
            if coarser and coarser[1] * fineness / coarser[0] > effort.most:
                break
            try:
                results, unit_steps = counted(scene, stepping, step, tolerance, end)
            except (UnitError, CouplingError) as error:
                yield Failure(way.name, stepping.name, step, tolerance, str(error))
                continue
            coarser = fineness, unit_steps
            if math.isfinite(truth.error(results)):
                yield Trial(way.name, scene, stepping, step, tolerance, end, results, unit_steps)
            else:
                yield Failure(way.name, stepping.name, step, tolerance, "orientations that are no numbers")


def measured(
    arm: JointedArm, effort: CoupledEffort, say: Callable[[str], None] = lambda _: None
) -> tuple[list[CoupledPoint], list[Failure]]:
    """All points, timed in turn, and the runs that failed; raises ModuleNotFoundError without the reference."""
    truth = Truth(arm)
    tried: list[Trial | Failure] = []
    with ExitStack() as stack:
        for way in WAYS:
            say(way.name)
            tried += trials(way, stack.enter_context(way.build(arm)), truth, arm.end, effort)
        found = [trial for trial in tried if isinstance(trial, Trial)]
        times = np.empty((effort.rounds, len(found)))
        for number, row in enumerate(times):
            say(f"timing, round {number + 1} of {effort.rounds}")
            row[:] = [trial.seconds() for trial in found]
    medians = np.median(times, axis=0).tolist()
    points = [point(trial, truth, seconds) for trial, seconds in zip(found, medians, strict=True)]
    return points, [failure for failure in tried if isinstance(failure, Failure)]


def point(trial: Trial, truth: Truth, seconds: float) -> CoupledPoint:
    """What is written down of a run."""
    summary, end = trial.results.summary, trial.end
    return CoupledPoint(
        way=trial.way,
        master=trial.stepping.name,
        step=trial.step,
        tolerance=trial.tolerance,
        error=truth.error(trial.results),
        seconds=seconds / end,
        unit_steps=trial.unit_steps / end,
        macro_steps=summary.get("macro_steps", summary["steps"]) / end,
        wrong=bool(summary.get("wrong", False)),
        largest_gap=summary.get("largest_gap"),
    )
