"""What the solvers are held to, each from one run against the peer or the method that it names."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from ..bench.measuring import choices
from .driver import compiled
from .fronts import cost
from .measure import COMMUNICATION, STEP, Point, Runner
from .peers import MujocoRun
from .problems import Problem

SINGLE_STEP = 0.01  # s, of the closed form
CALLS = 20_000
PEER_STEP = 0.001  # s
NEAR = 1e-10  # rad
SAME = 1.01
"""No more error: the same method on the same equations differs by roundings only."""


@dataclass(frozen=True)
class Statement:
    """A claim, the number that it rests on, and the bound: `most` says on which side of it the number must be."""

    claim: str
    value: float
    bound: float
    most: bool
    note: str = ""

    @property
    def holds(self) -> bool:
        """Whether it does."""
        return bool(self.value <= self.bound if self.most else self.value >= self.bound)


def statements(problems: Sequence[Problem], points: Sequence[Point], rounds: int) -> list[Statement]:
    """All that can be said with the solvers and peers at hand."""
    by_name = {problem.name: problem for problem in problems}
    solvers = choices("RigidBody", "solver")
    found: list[Statement] = []
    if "exact" in solvers:
        found += exact_anywhere(points)
        found += bare_function(by_name["dzhanibekov"], rounds)
    if "taylor" in solvers:
        found += series_against_rk4(points)
    if find_spec("mujoco"):
        found += against_mujoco([by_name["free_asymmetric"], by_name["driven_hinge"]], rounds)
    return found


def exact_anywhere(points: Sequence[Point]) -> Iterator[Statement]:
    """The closed form at communication steps from 1 ms to 10 s."""
    own = [p for p in points if (p.problem, p.solver, p.parameter) == ("dzhanibekov", "exact", COMMUNICATION)]
    own = [p for p in own if p.value <= 10.0]
    if own:
        each = ", ".join(f"{p.error:.1e} at {p.value:g} s" for p in own)
        yield Statement(
            "Dzhanibekov, exact: error in rad at any communication step", max(p.error for p in own), 1e-12, True, each
        )


def series_against_rk4(points: Sequence[Point]) -> Iterator[Statement]:
    """Taylor series, or what `automatic` chooses, and rk4: how many times less work at NEAR."""
    bounds = {
        "dzhanibekov": (5.0, ("taylor",)),
        "symmetric_top": (30.0, ("taylor", "automatic")),
        "asymmetric_top": (30.0, ("taylor", "automatic")),
    }
    for problem, (bound, names) in bounds.items():
        work = {
            name: cost([p for p in points if (p.problem, p.solver) == (problem, name)], NEAR)
            for name in (*names, "rk4")
        }
        best = min(names, key=work.__getitem__)
        note = ", ".join(f"{name} {1e6 * work[name]:.3g} µs/s" for name in (*names, "rk4") if np.isfinite(work[name]))
        yield Statement(
            f"{problem}: work of rk4 over that of {best} at {NEAR:g} rad", work["rk4"] / work[best], bound, False, note
        )


def bare_function(problem: Problem, rounds: int) -> Iterator[Statement]:
    """One doStep of the closed form through FMI's C interface, and the step function of the unit by itself.

    The note has the attitude in closed form alone besides: what the step adds to that is loads, translation and checks.
    """
    runner = Runner(problem)
    state = runner.start("exact")
    runner.slave.restore(state)
    values = np.concatenate([runner.slave.get(name) for name in ("inertia", "orientation", "angular_momentum")])
    bare = compiled("bare", runner.slave.description.folder / "sources")
    count = round(problem.end / SINGLE_STEP)
    repeats = max(1, CALLS // count)

    def measured() -> tuple[float, float, float]:
        step = runner.seconds(state, count, repeats) / count
        alone = [run(values.ctypes.data, SINGLE_STEP, CALLS) / CALLS for run in (bare.time_bare, bare.time_attitude)]
        return step, *alone

    step, alone, attitude = np.median([measured() for _ in range(4 * rounds + 1)], axis=0)
    yield Statement(
        "exact: one doStep over the step function of the unit",
        step / alone,
        1.3,
        True,
        f"{1e9 * step:.0f} and {1e9 * alone:.0f} ns; over the attitude in closed form alone, {1e9 * attitude:.0f} ns: "
        f"{step / attitude:.2g} times",
    )


def against_mujoco(problems: Sequence[Problem], rounds: int) -> Iterator[Statement]:
    """rk4 of the unit and of MuJoCo at 1 ms, time of one step."""
    for problem in problems:
        runner, peer = Runner(problem), MujocoRun(problem, "RK4", PEER_STEP)
        state = runner.start("rk4", **{STEP: PEER_STEP})
        error = problem.error(runner.end(state))
        peer()
        peer_error = problem.error(peer.place())
        times = np.array([(runner.seconds(state, 1, 1) / peer.count, peer() / peer.count) for _ in range(rounds)])
        own, other = np.median(times, axis=0)
        note = f"{1e9 * own:.0f} and {1e9 * other:.0f} ns; errors {error:.1e} and {peer_error:.1e} rad"
        yield Statement(f"{problem.name}: a step of MuJoCo's RK4 over one of rk4", other / own, 30.0, False, note)
        yield Statement(f"{problem.name}: error of rk4 over that of MuJoCo's RK4", error / peer_error, SAME, True)
