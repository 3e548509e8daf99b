"""The FMU as built against the functions it was traced to: values, derivatives and dependencies through FMI.

A double-precision evaluation rounds each operation by at most u = 2^-53 of its result; the sum of these, carried
through to the results, is the size against which a difference is held. It is what the conditioning of the formula
at that point allows, and 1 means that every rounding went the same way. A function of the C library may be off by
2 u, and a derivative by the complex step takes about twice the operations of the one by AD, in another order.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType

import casadi
import numpy as np
from casadi import SX
from mpmath import mp, mpf

from .arithmetic import Digits, Precise, exactly
from .built import Built, Point
from .claims import Row, textbook_symbols
from .graph import Graph, graph_of, run
from .identity import Samples, depends
from .lift import Lifted
from .points import Draw, general_point, points, ranges_of

UNIT_ROUNDOFF = mpf(2) ** -53
DIGITS = 40
VALUE_LIMIT = 4
DERIVATIVE_LIMIT = 16
STRANGER_LIMIT = 1e6
"""For a model that takes another way to the same result: 1e-10 of its terms."""
TINY = mpf(2) ** -1022
"""What is below the smallest normal number has no relative precision."""


class Traced:
    """Expressions by name, to be evaluated with a bound on the roundings at points of numbers."""

    def __init__(self, expressions: Mapping[str, SX], symbols: Mapping[str, SX]):
        """Columns in the `symbols`, columns by the names of variables."""
        self._sizes = {name: expression.numel() for name, expression in expressions.items()}
        self._graph: Graph = graph_of(casadi.vertcat(*map(casadi.vec, expressions.values())))
        self._places = {s.name(): (n, k) for n, column in symbols.items() for k, s in enumerate(column.elements())}

    def at(self, point: Point) -> dict[str, list[Digits]]:
        """Values at a point; raises UndefinedError (of `arithmetic`) where there is none."""
        with mp.workdps(DIGITS):
            places = [self._places[symbol] for symbol in self._graph.symbols]
            inputs = [exactly(float(np.ravel(point[name])[k])) for name, k in places]
            results = iter(run(self._graph, Precise(read_constants=False), inputs))
            return {name: [next(results) for _ in range(size)] for name, size in self._sizes.items()}


def excess(read: Sequence[float], expected: Sequence[Digits]) -> float:
    """The largest difference, in units of the roundings that its terms allow."""
    with mp.workdps(DIGITS):
        if not np.all(np.isfinite([*read, *(result.rounding for result in expected)])):
            return float("inf")
        ratios = [
            abs(mpf(float(x)) - result.value) / (UNIT_ROUNDOFF * (result.rounding + abs(result.value)) + TINY)
            for x, result in zip(read, expected, strict=True)
        ]
    return float(max(ratios))


Dependencies = Mapping[int, set[tuple[str, int]]]
"""Element of a result -> (name, element) of what it depends on."""
Declared = Mapping[str, set[tuple[str, int]] | None]
Compute = Callable[[dict[str, SX]], Mapping[str, SX]]


class Comparison:
    """An FMU and the functions that it should compute, on common symbols."""

    def __init__(self, built: Built, compute: Compute, names: Sequence[str], *, whole: bool):
        """`compute` gives expressions by name from columns by name, those of `names` that the FMU shows are compared.

        `whole`: it leaves no dependency out; a model may hold at the start values of what it does not mention.
        """
        known = [*(v.name for v in built.numbers("parameter", "input")), *built.states]
        self.built = built
        self.symbols = {name: SX.sym(name, built.count(name)) for name in dict.fromkeys(known)}
        results = compute({"time": SX(0.0)} | self.symbols)  # at which all instances are initialized
        shown = built.description.variables
        self.initial = {name: results[f"initial({name})"] for name in shown if f"initial({name})" in names}
        self.results = {name: results[name] for name in shown if name in names}
        used = {str(s) for s in casadi.symvar(SX(casadi.vertcat(*self.results.values(), *self.initial.values())))}
        self.used = [name for name, column in self.symbols.items() if used & {str(s) for s in column.elements()}]
        """Names of what the results depend on; all else stays at its start value."""
        moving = [*built.states, *(v.name for v in built.numbers("input"))]
        self.knowns = moving if whole else [name for name in moving if name in self.used]
        """Names of the states and inputs that derivatives are taken by."""

    @property
    def all_results(self) -> SX:
        """One column of all results."""
        return SX(casadi.vertcat(*self.results.values()))

    @property
    def all_knowns(self) -> SX:
        """One column of states and inputs."""
        return SX(casadi.vertcat(*[self.symbols[name] for name in self.knowns]))


class Worst:
    """The largest excess so far, and where."""

    def __init__(self) -> None:
        """Nothing seen."""
        self.ratio, self.where, self.points = 0.0, "", 0

    def see(self, read: Mapping[str, Sequence[float]], expected: Mapping[str, Sequence[Digits]]) -> None:
        """Takes what was read and what was expected at one point."""
        self.points += 1
        for name, values in read.items():
            ratio = excess(values, expected[name])
            if ratio > self.ratio:
                self.ratio, self.where = ratio, name

    def row(self, unit: str, claim: str, limit: float) -> Row:
        """The verdict."""
        where = f" at {self.where}" if self.where else ""
        bound = f"{self.ratio:.2g} u of its terms{where} (allowed: {limit:g} u)"
        return Row(unit, claim, f"{self.points} points through FMI", bound, self.points > 0 and self.ratio <= limit)


def values_and_derivatives(
    unit: str,
    comparison: Comparison,
    draw: Draw,
    source: str = "the sources",
    limits: tuple[float, float] = (VALUE_LIMIT, DERIVATIVE_LIMIT),
) -> Iterator[Row]:
    """Claims about values at the start, values at any point, and directional and adjoint derivatives.

    `source` is what `comparison` holds it against; only our own FMUs are taken to adversarial points.
    """
    built, symbols = comparison.built, comparison.symbols
    x, y = comparison.all_knowns, comparison.all_results
    seeds = {"seed_x": SX.sym("seed_x", x.numel()), "seed_y": SX.sym("seed_y", y.numel())}
    start = Traced(comparison.initial, symbols) if comparison.initial else None
    values = Traced(comparison.results, symbols) if comparison.results else None
    slopes = built.provides("DirectionalDerivative") and values and x.numel()
    forward = slopes and Traced({"": casadi.jtimes(y, x, seeds["seed_x"])}, symbols | seeds)
    adjoint = (
        slopes
        and built.provides("AdjointDerivative")
        and Traced({"": casadi.jtimes(y, x, seeds["seed_y"], True)}, symbols | seeds)
    )
    worst = {"start": Worst(), "values": Worst(), "directional": Worst(), "adjoint": Worst()}
    random_seeds = np.random.default_rng(3)
    for point in points(built, draw, adversarial=source == "the sources"):
        here = {name: np.atleast_1d(point.get(name, built.start(name))) for name in symbols}
        if start:
            built.initialize(point)
            worst["start"].see({name: built.read(name) for name in comparison.initial}, start.at(here))
            built.move(point)
        if values:
            worst["values"].see({name: built.read(name) for name in comparison.results}, values.at(here))
        along = {name: random_seeds.uniform(-1, 1, seed.numel()) for name, seed in seeds.items()}
        names, knowns = list(comparison.results), comparison.knowns
        if forward:
            read = built.derivative(names, knowns, along["seed_x"])
            worst["directional"].see({"": read}, forward.at(here | along))
        if adjoint:
            read = built.adjoint_derivative(names, knowns, along["seed_y"])
            worst["adjoint"].see({"": read}, adjoint.at(here | along))
    version = f"FMI {built.version}"
    if start:
        yield worst["start"].row(unit, f"{version}: its start is that of {source}", limits[0])
    if values:
        yield worst["values"].row(unit, f"{version}: its values are those of {source}", limits[0])
    if forward:
        yield worst["directional"].row(unit, f"{version}: its directional derivatives are those of {source}", limits[1])
    if adjoint:
        yield worst["adjoint"].row(unit, f"{version}: its adjoint derivatives are those of {source}", limits[1])


def dependencies(unit: str, comparison: Comparison, samples: Samples, *, idle: bool) -> Iterator[Row]:
    """The claim that ModelStructure lists what results depend on: nothing missing, and if `idle`, no array idle."""
    built = comparison.built
    x, y = comparison.all_knowns, comparison.all_results
    if not (x.numel() and y.numel()):
        return
    jacobian = casadi.jacobian(y, x)
    rows, columns = jacobian.sparsity().get_triplet()
    found = depends(SX(casadi.vertcat(*jacobian.nonzeros())), samples)
    knowns = [(name, k) for name in comparison.knowns for k in range(built.count(name))]
    unknowns = [(name, k) for name in comparison.results for k in range(built.count(name))]
    actual: dict[tuple[str, int], set[tuple[str, int]]] = {unknown: set() for unknown in unknowns}
    for row, column, there in zip(rows, columns, found, strict=True):
        if there:
            actual[unknowns[row]].add(knowns[column])
    declared = built.dependencies()
    wrong = []
    for name in comparison.results:
        used = {k: actual[name, k] for k in range(built.count(name))}
        wrong += _missing(built, name, used, declared)
        wrong += _idle(built, name, used, declared) if idle else []
    claim = f"FMI {built.version}: ModelStructure lists all dependencies" + (" and no other" if idle else "")
    yield Row(unit, claim, "sparsity of the Jacobian", "; ".join(wrong) or "exact", not wrong)


def _lists(built: Built, name: str, actual: Dependencies, declared: Declared) -> list[tuple[str, set, set]]:
    """Of each scalar of FMI 2 or array of FMI 3: its name, what is listed and what it needs; none without a list."""
    if built.version == "3.0":
        whole = {(known, 0) for elements in actual.values() for known, _ in elements}
        found = [(name, declared.get(name), whole)]
    else:
        found = [(f"{name}[{k}]", declared.get(f"{name}[{k}]"), used) for k, used in actual.items()]
    return [] if any(listed is None for _, listed, _ in found) else found


def _missing(built: Built, name: str, actual: Dependencies, declared: Declared) -> Iterator[str]:
    for key, listed, used in _lists(built, name, actual, declared):
        for known, k in sorted(used - listed):
            element = f"[{k}]" if built.version == "2.0" else ""
            yield f"{key} depends on {known}{element}, which is not listed"


def _idle(built: Built, name: str, actual: Dependencies, declared: Declared) -> Iterator[str]:
    """Arrays of which no element is needed; elements that are zero inside an array do no harm."""
    needed = {known for elements in actual.values() for known, _ in elements}
    listed = {known for _, listed, _ in _lists(built, name, actual, declared) for known, _ in listed}
    for known in sorted(listed - needed):
        yield f"{name} does not depend on {known}, which is listed"


def _draw(comparison: Comparison, model: ModuleType) -> Draw:
    """Draws what the results depend on; all else stays at its start value."""
    names = comparison.used
    general = textbook_symbols(model, {name: comparison.symbols[name].numel() for name in names})
    samples = ranges_of(comparison.built, names, model.SAMPLES)
    return general_point({name: general[name] for name in names}, samples)


def unit_as_built(unit: str, path: str | Path, lifted: Lifted, model: ModuleType) -> Iterator[Row]:
    """All claims about one of our FMUs: it computes what its own sources, traced, compute."""
    with Built(path) as built:
        names = [name for group in lifted.groups for name in lifted.results_of.get(group, [])]
        comparison = Comparison(built, lifted.equations, names, whole=True)
        yield from values_and_derivatives(unit, comparison, _draw(comparison, model))
        yield from dependencies(unit, comparison, model.SAMPLES, idle=True)


def stranger_as_built(path: str | Path, model: ModuleType) -> Iterator[Row]:
    """All claims about any FMU: it computes what a model of it says, a module with `equations(values)`."""
    with Built(path) as built:
        unit = built.description.name
        sizes = {v.name: built.count(v.name) for v in built.numbers("parameter", "input", "output", "local")}
        names = list(model.equations({name: SX.sym(name, size) for name, size in sizes.items()}))
        lacking = [name for name in names if name not in sizes and not name.startswith("initial(")]
        if lacking:
            yield Row(unit, "the FMU has all that the model computes", "names", ", ".join(lacking), False)
        comparison = Comparison(built, model.equations, names, whole=False)
        limits = (STRANGER_LIMIT, STRANGER_LIMIT)
        yield from values_and_derivatives(unit, comparison, _draw(comparison, model), "the model", limits)
        yield from dependencies(unit, comparison, model.SAMPLES, idle=False)
