"""Claims about whole steps of every solver: orders as series in h, and what they keep, by a model's table.

A step is traced along its path (see `paths`) and carried out in 50 digits, so that neither the roundings of doubles
nor those of differences hide anything: what is left is the solver's own.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import ModuleType

import casadi
import numpy as np
from casadi import SX
from mpmath import mp, mpf

from .arithmetic import Precise, exactly
from .claims import Row
from .graph import Graph, UnsupportedError, graph_of, run
from .lift import SNIPPETS
from .paths import Paths, trace_steps
from .series import SPARE, Series, flow

DIGITS = 50
COUNT = 13
"""Coefficients of a series that are looked at, after the first."""
ROUNDING = 1e-15
"""A few roundings of numbers near 1: constants of the closed form, and Newton's method, end there."""
LEAST_CHOSEN = 8
"""The order that a solver which chooses it takes at least, at the tolerances of the models' cases."""
SHORTER = 16
"""A step's share at which the power of a loss is read off: there the next power adds a percent or two to the ratio."""
NEAR_WHOLE = 0.1
LOST = 1e-42
"""What is less may be the rounding of 50 digits."""
SETTINGS = ("solver_step", "tolerance")

_flows: dict[tuple, list[list[mpf]]] = {}

Values = Mapping[str, mpf]
"""By the name of a symbol; element k of a column `x` is `x_k`."""


def numbers_of(columns: Mapping[str, object]) -> dict[str, mpf]:
    """Values by the names of symbols, from lists by the names of columns."""
    return {
        (name if len(column) == 1 else f"{name}_{k}"): mpf(value)
        for name, column in columns.items()
        for k, value in enumerate(column)
    }


def at(expression: SX | Graph, values: Values) -> list[mpf]:
    """An expression in 50 digits; symbols without a value are zero."""
    graph = expression if isinstance(expression, Graph) else graph_of(expression)
    inputs = [exactly(values.get(name, mpf(0))) for name in graph.symbols]
    return [result.value for result in run(graph, Precise(), inputs)]


@dataclass(frozen=True)
class Case:
    """A point of a model, as it gives it, and the steps traced there."""

    model: ModuleType
    given: Mapping[str, list[float]]
    paths: Paths

    @property
    def h(self) -> mpf:
        """The step, s."""
        return mpf(self.given["h"][0])

    @cached_property
    def values(self) -> Values:
        """Of the model's free symbols, and of the variables that follow from them."""
        free = numbers_of(self.given)
        columns = {name: at(column, free) for name, column in self.model.point().items()}
        return numbers_of(columns) | free

    @cached_property
    def given_to_unit(self) -> dict[str, np.ndarray]:
        """Parameters and inputs with which the unit itself comes to this point, to the roundings of its start."""
        columns = {**self.model.point(), **self.model.start(self.model.point())}
        settings = {name: np.array(value) for name, value in self.given.items() if name in SETTINGS}
        known = {name: np.array([float(x) for x in at(column, self.values)]) for name, column in columns.items()}
        return settings | {n: v for n, v in known.items() if n != "elapsed" and n not in self.model.STATES}

    @property
    def exact(self) -> list[list[mpf]]:
        """Taylor coefficients of the states along the textbook's motion; the same whatever the C."""
        key = (self.model.__name__, *((name, *column) for name, column in self.given.items()))
        if key not in _flows:
            found = flow(self.model.motion(self.symbols), self.values, COUNT)
            _flows[key] = [found[s.name()] for state in self.model.STATES for s in self.symbols[state].elements()]
        return _flows[key]

    @cached_property
    def symbols(self) -> dict[str, SX]:
        """A free symbol for each variable."""
        return {name: SX.sym(name, column.numel()) for name, column in self.model.point().items()}

    def taken(self, solver: str) -> list[list[mpf]]:
        """Taylor coefficients in h of the states after a step."""
        after = self.paths.step(solver, self.symbols, SX.sym("h"))
        graph = graph_of(casadi.vertcat(*[after[state] for state in self.model.STATES]))
        inputs = [[mpf(0), mpf(1)] if name == "h" else [self.values[name]] for name in graph.symbols]
        return run(graph, Series(COUNT, SPARE), inputs)

    def differences(self, solver: str) -> list[mpf]:
        """The largest difference of the terms of each order, at this case's h."""
        pairs = list(zip(self.taken(solver), self.exact, strict=True))
        return [max(abs((a[n] if n < len(a) else 0) - b[n]) for a, b in pairs) * self.h**n for n in range(COUNT + 1)]

    def sizes(self, expression: SX, *shares: int) -> list[mpf]:
        """The largest element of an expression in the step, at shares of this case's h."""
        graph = graph_of(expression)
        return [max(map(abs, at(graph, {**self.values, "h": self.h / share}))) for share in shares]


Cases = Mapping[str, list[Case]]


def agreement(differences: list[mpf]) -> int:
    """The order up to which two series agree."""
    return next((n - 1 for n, difference in enumerate(differences) if difference > ROUNDING), COUNT)


def of_solvers(unit: str, model: ModuleType, cases: Cases) -> Iterator[Row]:
    """Every claim of a model's table `SOLVERS`; none where there are no cases."""
    with mp.workdps(DIGITS):
        for solver, declared in model.SOLVERS.items() if cases else ():
            for kind, order in declared.orders.items():
                claim = f"{solver}, {model.KINDS[kind]}: {_claimed(order)}"
                how = f"series to h^{COUNT}, {_how(cases[kind])}"
                yield _row(unit, claim, how, partial(_order, solver, order, cases[kind]))
            for quantity, (kind, error) in model.QUANTITIES.items():
                changes = [error(case.paths.step, solver) for case in cases[kind]]
                if quantity in declared.keeps:
                    claim, judge = f"{solver} keeps {quantity}", partial(_kept, changes, cases[kind])
                else:
                    claim = f"{solver} loses {quantity}, no earlier than its order allows"
                    judge = partial(_lost, changes, cases[kind], declared.orders[kind])
                yield _row(unit, claim, _how(cases[kind]), judge)


def _row(unit: str, claim: str, how: str, judge: Callable[[], tuple[str, bool]]) -> Row:
    try:
        return Row(unit, claim, how, *judge())
    except (ArithmeticError, UnsupportedError) as error:
        return Row(unit, claim, how, f"no value: {error}", False)


def _how(cases: list[Case]) -> str:
    return f"{DIGITS} digits, {len(cases)} point" + ("s" if len(cases) > 1 else "")


def cases_of(sources: Path, model: ModuleType, header_folder: Path = SNIPPETS) -> Cases:
    """The model's cases with the steps of all its solvers traced, by kind; none where a model has no solvers."""
    if not hasattr(model, "SOLVERS"):
        return {}
    given = {f"{kind}_{k}": case for kind, cases in model.CASES.items() for k, case in enumerate(cases)}
    values = {}
    for name, case in given.items():
        free = numbers_of(case)
        values[name] = {n: list(map(float, at(column, free))) for n, column in model.point().items()} | case
    paths = trace_steps(sources, list(model.SOLVERS), list(model.STATES), values, header_folder)
    return {
        kind: [Case(model, case, paths[f"{kind}_{k}"]) for k, case in enumerate(cases)]
        for kind, cases in model.CASES.items()
    }


def _claimed(order: float | None) -> str:
    """An order in words: a number, every one, or None for one that the tolerance chooses."""
    if order is None:
        return "a series that ends within the tolerance"
    return "all coefficients of the flow" if order == math.inf else f"order {order}"


def _order(solver: str, order: float | None, cases: list[Case]) -> tuple[str, bool]:
    found = [case.differences(solver) for case in cases]
    agreed = list(map(agreement, found))
    if order == math.inf:
        return f"off by {float(max(map(max, found))):.1g}", min(agreed) == COUNT
    bound = f"agrees up to h^{min(agreed)}"
    if order is None:
        shares = [
            float(sum(differences[k + 1 :]) / (case.h * mpf(case.given["tolerance"][0])))
            for differences, k, case in zip(found, agreed, cases, strict=True)
        ]
        share = max(shares)
        return f"{bound}, the rest {share:.1g} of the tolerance", min(agreed) >= LEAST_CHOSEN and share <= 1
    left = min(float(differences[int(order) + 1]) for differences in found)
    return f"{bound}, leaves by {left:.1g}", all(k == order for k in agreed)


def _kept(changes: list[SX], cases: list[Case]) -> tuple[str, bool]:
    size = float(max(case.sizes(change, 1)[0] for change, case in zip(changes, cases, strict=True)))
    return f"{size:.1g}", size <= ROUNDING


def _lost(changes: list[SX], cases: list[Case], order: float | None) -> tuple[str, bool]:
    """A known failure of the size that the order allows: the flow keeps it, so the loss begins at a later power."""
    least = (LEAST_CHOSEN if order is None else order) + 1
    pairs = [case.sizes(change, SHORTER, 2 * SHORTER) for change, case in zip(changes, cases, strict=True)]
    powers = [float(mp.log(one / half, 2)) if one > LOST else 0.0 for one, half in pairs]
    power = min(powers)
    holds = power > least - NEAR_WHOLE and all(abs(p - round(p)) < NEAR_WHOLE for p in powers)
    return (f"from h^{round(power)} on" if power else "it is kept"), holds
