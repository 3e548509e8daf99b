"""masters: what a macro step of three units costs in Python, beside a loop in C and other tools that do the same."""

import ctypes
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from ctypes import byref, c_double, c_long, c_void_p
from itertools import pairwise
from pathlib import Path
from time import thread_time

from ..charts.driver import compiled
from ..paths import fmu
from ..scene import Scene
from .measuring import interleaved, started
from .tables import Table

UNIT, INPUT, OUTPUT = "HingedBody", "target_angle", "angle"
NAMES = ("first", "second", "third")
PULL = 1.0
"""rad: what the first takes."""
STEP = 1 / 512  # s; whole nanoseconds, in which Ecos counts
COUNT = 1000
VERSIONS = ("2.0", "3.0")
LOOP, GETTERS, ECOS = "the units in a loop of C", "FMPy's getters and setters", "Ecos"
EXPLICIT = [(master, order) for order in (0, 1) for master in ("jacobi", "gauss_seidel")]

Run = Callable[[], float]
"""Takes COUNT macro steps and returns the processor seconds of one."""


def name_of(what: str, version: str) -> str:
    """Of a row."""
    return f"{what}, FMI {version[0]}"


def master_name(master: str, order: int) -> str:
    """Of one of ours, with its order of extrapolation."""
    return f"{master}, extrapolation {order}" if order else master


def chain(version: str) -> Scene:
    """Three forearms whose muscles pull each to the angle of the one before, where the last one is recorded."""
    scene = Scene("chain")
    units = [scene.add(UNIT, name, version=version) for name in NAMES]
    units[0].set(INPUT, PULL)
    for one, other in pairwise(units):
        scene.connect(one[OUTPUT], other[INPUT])
    scene.record(units[-1][OUTPUT])
    return scene


def with_master(version: str, master: str, order: int) -> tuple[Run, Scene]:
    """`Scene.run` from its first row to its last, without what it takes to set up."""
    scene = chain(version)

    def run() -> float:
        marks: list[float] = []
        scene.run(
            COUNT * STEP, STEP, master=master, extrapolation=order, progress=lambda _: marks.append(thread_time())
        )
        return (marks[-1] - marks[0]) / COUNT

    return run, scene


class Loop:
    """The same three units without a scene, in the order of `gauss_seidel`, where they have got to."""

    def __init__(self, version: str):
        """Starts them at 0 s."""
        self.units = [started(fmu(UNIT, version)) for _ in NAMES]
        self.version, self.row = version, 0
        variables = self.units[0].description.variables
        self.places = [variables[name].references[0] for name in (INPUT, OUTPUT)]

    def close(self) -> None:
        """Frees the units."""
        for unit in self.units:
            unit.close()

    def in_c(self) -> Run:
        """A loop in C of set, step and get, which is the units' own time; raises FileNotFoundError without a compiler.

        The run raises RuntimeError where a unit fails.
        """
        loop = getattr(compiled("chain"), f"chain{self.version[0]}")
        kind = {"2.0": "Real", "3.0": "Float64"}[self.version]
        calls = [
            ctypes.cast(self.units[0].function(f"fmi{self.version[0]}{name}"), c_void_p)
            for name in (f"Set{kind}", "DoStep", f"Get{kind}")
        ]
        components = (c_void_p * len(self.units))(*(unit.component for unit in self.units))

        def run() -> float:
            start, value = thread_time(), c_double(PULL)
            counts = c_long(self.row), c_long(COUNT)
            worst = loop(*calls, components, c_long(len(NAMES)), *self.places, c_double(STEP), *counts, byref(value))
            self.row += COUNT
            if worst > 1:
                raise RuntimeError(f"{UNIT} fails in the loop of C with status {worst}")
            return (thread_time() - start) / COUNT

        return run

    def by_fmpy(self) -> Run:
        """The loop that users of FMPy write: lists in, lists out."""
        # the objects of FMPy by which Slave leads the units
        units = [unit._fmu for unit in self.units]
        getters = {"2.0": ("setReal", "getReal"), "3.0": ("setFloat64", "getFloat64")}[self.version]
        calls = [(getattr(unit, getters[0]), unit.doStep, getattr(unit, getters[1])) for unit in units]
        taken, given = ([place] for place in self.places)

        def run() -> float:
            start = thread_time()
            for row in range(self.row, self.row + COUNT):
                values = [PULL]
                for set_values, step, get_values in calls:
                    set_values(taken, values)
                    step(row * STEP, STEP)
                    values = get_values(given)
            self.row += COUNT
            return (thread_time() - start) / COUNT

        return run

    def angle(self) -> float:
        """Of the last unit, rad."""
        return self.units[-1].get(OUTPUT)


def ecos_simulation(stack: ExitStack) -> object | None:
    """The chain in Ecos, which takes FMI 2; None where ecospy, or the TBB that it loads, is not installed."""
    with suppress(OSError):
        ctypes.CDLL(str(Path(sys.prefix) / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
    try:
        import ecospy
    except (ImportError, OSError):
        return None
    ecospy.EcosLib.set_log_level("off")
    structure = stack.enter_context(ecospy.EcosSimulationStructure())
    for name in NAMES:
        structure.add_model(name, str(fmu(UNIT, "2.0")))
    structure.add_parameter_set("start", {f"{NAMES[0]}::{INPUT}": PULL})
    for one, other in pairwise(NAMES):
        structure.make_real_connection(f"{one}::{OUTPUT}", f"{other}::{INPUT}")
    simulation = stack.enter_context(ecospy.EcosSimulation(STEP, structure=structure))
    if not simulation.init(0, "start"):
        raise RuntimeError(f"Ecos: {ecospy.EcosLib.get_last_error()}")
    return simulation


def by_ecos(simulation: object, together: int) -> Run:
    """So many macro steps a call; of its threads the one that calls counts, which does nearly all."""

    def run() -> float:
        start = thread_time()
        for _ in range(COUNT // together):
            simulation.step(together)
        return (thread_time() - start) / COUNT

    return run


def runs(stack: ExitStack) -> Iterator[tuple[str, Run]]:
    """All that there is to compare, by the name of its row; what it loads is freed with the stack."""
    for version in VERSIONS:
        for what, make in ((LOOP, Loop.in_c), (GETTERS, Loop.by_fmpy)):
            loop = Loop(version)
            stack.callback(loop.close)
            yield name_of(what, version), make(loop)
        for master, order in EXPLICIT:
            run, scene = with_master(version, master, order)
            stack.enter_context(scene)
            yield name_of(master_name(master, order), version), run
    if simulation := ecos_simulation(stack):
        for together in (COUNT, 1):
            yield name_of(f"{ECOS}, {together} a call", "2.0"), by_ecos(simulation, together)


def macro_steps(rounds: int) -> dict[str, float]:
    """Median seconds of a macro step, by the name of the row; raises FileNotFoundError without a C compiler."""
    with ExitStack() as stack:
        return interleaved(dict(runs(stack)), rounds)


def over_units(found: dict[str, float], name: str) -> float:
    """Seconds of a macro step beyond what the units take themselves."""
    return found[name] - found[name_of(LOOP, f"{name[-1]}.0")]


def bench(rounds: int) -> list[Table]:
    """Time of a macro step of three units, whoever makes it."""
    found = macro_steps(rounds)
    least = min(found.values())
    rows = [(name, 1e6 * s, 1e6 * over_units(found, name), s / least) for name, s in sorted(found.items(), key=_order)]
    others = "" if any(name.startswith(ECOS) for name in found) else " Ecos is not installed: pip install ecospy tbb."
    return [
        Table(
            "masters: a macro step of three units",
            f"Three {UNIT} in a chain, one number from each to the next; {COUNT} macro steps of 1/{1 / STEP:g} s a "
            "run, in processor time; our masters record one number. Over the units: beyond the loop in C of the same "
            f"FMI version.{others}",
            ("who steps them", "us a step", "over the units", "ratio"),
            rows,
        )
    ]


def _order(item: tuple[str, float]) -> tuple[str, float]:
    """By FMI version, then by cost."""
    return item[0][-1], item[1]
