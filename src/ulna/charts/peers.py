"""Other people's integrators on the same problems, as far as they are installed.

MuJoCo's C function runs in the C driver's loop, as the units do. SciPy's DOP853 and CVODE come back into Python for
each right-hand side, so there the evaluations count and not the clock.
"""

import math
from collections.abc import Callable, Iterator
from ctypes import CDLL, c_void_p, cast
from importlib.util import find_spec
from pathlib import Path
from time import thread_time

import numpy as np
from fmpy.fmi3 import FMU3Model

from ..description import read_description
from ..paths import fmu
from .driver import compiled
from .measure import STEP, TOLERANCE, Candidate, Effort, decades
from .problems import Problem
from .reference import Array

# Name in MuJoCo, and the right-hand sides that a step takes.
MUJOCO = {"mujoco_euler": ("Euler", 1), "mujoco_implicitfast": ("implicitfast", 1), "mujoco_rk4": ("RK4", 4)}
MODEL = """<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -{gravity}" integrator="{integrator}" timestep="{step}"/>
  <worldbody><body>{joint}</body></worldbody>
</mujoco>"""


def peer_candidates(problem: Problem, effort: Effort) -> Iterator[Candidate]:
    """All of those that are installed."""
    for package, candidates in PEERS.items():
        if find_spec(package):
            yield from candidates(problem, effort)


class MujocoRun:
    """One model of MuJoCo, moved by its `mj_step` in a C loop."""

    def __init__(self, problem: Problem, integrator: str, step: float):
        """Compiles the model; the joint starts as the problem says."""
        import mujoco

        text = MODEL.format(gravity=problem.gravity, integrator=integrator, step=repr(step), joint=problem.joint)
        self.problem = problem
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.count = round(problem.end / step)
        self.model.opt.timestep = problem.end / self.count
        self._reset = mujoco.mj_resetData
        [library] = Path(mujoco.__file__).parent.glob("libmujoco*")
        loaded = CDLL(str(library))
        self._advance = cast(loaded.mj_step, c_void_p)
        self.profiler = c_void_p.in_dll(loaded, "mjcb_time")
        self._driver = compiled("driver")

    def __call__(self) -> float:
        """Seconds of the run to the end."""
        self._reset(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = self.problem.pose, self.problem.turn
        self.data.qfrc_applied[-1] = self.problem.applied
        # The Python package installs a clock that MuJoCo then reads in every part of a step, which doubles its cost; a
        # program in C has none.
        clock, self.profiler.value = self.profiler.value, None
        try:
            return self._driver.time_advances(self._advance, self.model._address, self.data._address, self.count)
        finally:
            self.profiler.value = clock

    def place(self) -> Array:
        """The orientation [4] or the angle [1] now."""
        return np.array(self.data.qpos[-self.problem.truth.size :])


def mujoco_candidates(problem: Problem, effort: Effort) -> Iterator[Candidate]:
    """MuJoCo's three integrators of general use, over the steps of the units."""
    for name, (integrator, stages) in MUJOCO.items():
        for step in decades(problem.coarsest / 10, problem.coarsest * 10 * effort.finest, effort.per_decade):
            run = MujocoRun(problem, integrator, step)
            seconds = run()
            error = problem.error(run.place())
            if math.isfinite(error) and seconds < effort.longest:
                yield Candidate(problem.name, name, STEP, step, error, stages * run.count, run)


def scipy_candidates(problem: Problem, effort: Effort) -> Iterator[Candidate]:
    """SciPy's DOP853 on the equations of the reference."""
    from scipy.integrate import solve_ivp

    def solve(tolerance: float) -> tuple[float, Array, int]:
        start = thread_time()
        found = solve_ivp(
            problem.system.slope,
            (0.0, problem.end),
            problem.system.first,
            method="DOP853",
            rtol=tolerance,
            atol=tolerance,
        )
        return thread_time() - start, found.y[problem.place, -1], found.nfev

    for tolerance in decades(1e-3, 1e-13, 1)[:: effort.stride]:
        _, place, evaluations = solve(tolerance)
        yield Candidate(
            problem.name,
            "dop853",
            TOLERANCE,
            tolerance,
            problem.error(place),
            evaluations,
            lambda tolerance=tolerance: solve(tolerance)[0],
        )


class CvodeRun:
    """The unit's own equations by model exchange, integrated by the CVODE that FMPy carries."""

    def __init__(self, problem: Problem):
        """Loads the unit for model exchange and keeps its state at 0 s."""
        self.problem = problem
        description = read_description(fmu(problem.unit))
        self.variables = description.variables
        self.model = FMU3Model(
            guid=description.token,
            modelIdentifier=description.identifier,
            unzipDirectory=str(description.folder),
            instanceName="cvode",
        )
        self.model.instantiate()
        for name, value in problem.values.items():
            self.model.setFloat64(list(self.variables[name].references), np.ravel(value).tolist())
        self.model.enterInitializationMode(startTime=0.0)
        self.model.exitInitializationMode()
        self.model.updateDiscreteStates()
        self.model.enterContinuousTimeMode()
        self.start = self.model.getFMUState()
        self.states = self.model.getNumberOfContinuousStates()
        self.evaluations = 0

    def derivatives(self, *arguments: object) -> object:
        """Those of the unit, counted."""
        self.evaluations += 1
        return self.model.getContinuousStateDerivatives(*arguments)

    def seconds(self, tolerance: float) -> float:
        """Runs to the end; raises RuntimeError where CVODE gives up."""
        from fmpy.sundials import CVodeSolver

        self.model.setFMUState(self.start)
        self.evaluations = 0
        solver = CVodeSolver(
            nx=self.states,
            nz=0,
            get_x=self.model.getContinuousStates,
            set_x=self.model.setContinuousStates,
            get_dx=self.derivatives,
            get_z=self.model.getEventIndicators,
            get_nominals=self.model.getNominalsOfContinuousStates,
            set_time=self.model.setTime,
            input=NoInput,
            startTime=0.0,
            relativeTolerance=tolerance,
            maxNumSteps=1_000_000,
        )
        start = thread_time()
        solver.step(0.0, self.problem.end)
        return thread_time() - start

    def place(self) -> Array:
        """The orientation [4] or the angle [1] now."""
        output = self.variables[self.problem.output]
        return np.array(self.model.getFloat64(list(output.references), self.problem.truth.size))


class NoInput:
    """Nothing changes from outside."""

    apply = staticmethod(lambda _: None)


def cvode_candidates(problem: Problem, effort: Effort) -> Iterator[Candidate]:
    """CVODE's BDF, the method that FMPy chooses, over a few tolerances, since each run takes a while."""
    run = CvodeRun(problem)
    for tolerance in decades(1e-4, 1e-10, 1)[:: effort.stride]:
        run.seconds(tolerance)
        yield Candidate(
            problem.name,
            "cvode",
            TOLERANCE,
            tolerance,
            problem.error(run.place()),
            run.evaluations,
            lambda tolerance=tolerance: run.seconds(tolerance),
        )


PEERS: dict[str, Callable[[Problem, Effort], Iterator[Candidate]]] = {
    "mujoco": mujoco_candidates,
    "scipy": scipy_candidates,
    "fmpy.sundials": cvode_candidates,
}
