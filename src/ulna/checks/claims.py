"""Claims about a unit's C, each with a verdict: equality with the textbook, identities, properties of steps."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import ModuleType

import casadi
from casadi import SX

from .graph import UnsupportedError
from .identity import Samples, vanishes
from .lift import Lifted


@dataclass(frozen=True)
class Row:
    """A claim about a unit, how it was shown, with what doubt, and whether it holds."""

    unit: str
    claim: str
    how: str
    bound: str
    holds: bool


def textbook_symbols(model: ModuleType, sizes: Mapping[str, int]) -> dict[str, SX]:
    """The general point of a model: its own `symbols()`, else a free symbol for each of `sizes`, name to elements."""
    free = {name: SX.sym(name, size) for name, size in sizes.items()}
    return free | model.symbols() if hasattr(model, "symbols") else free


def _vanishing(unit: str, claim: str, expression: SX, samples: Samples) -> Row:
    """The claim that an expression is zero everywhere."""
    try:
        shown = vanishes(expression, samples)
    except UnsupportedError as error:
        return Row(unit, claim, "not shown", str(error), False)
    return Row(unit, claim, shown.how, shown.bound, shown.vanishes)


def _differing(unit: str, claim: str, expression: SX, samples: Samples) -> Row:
    """The claim that an expression is not zero everywhere."""
    row = _vanishing(unit, claim, expression, samples)
    return replace(row, holds=row.how != "not shown" and not row.holds)


def equality(unit: str, lifted: Lifted, model: ModuleType) -> Iterator[Row]:
    """One claim for each function of the C: all that it computes is what the textbook says."""
    values = textbook_symbols(model, {name: symbol.numel() for name, symbol in lifted.symbols().items()})
    expected = model.equations(values)
    computed = lifted.equations(values)
    lacking = [name for name in expected if name not in computed]
    if lacking:
        yield Row(unit, "all that the textbook computes is in the C", "names", ", ".join(lacking), False)
    for function, names in lifted.results_of.items():
        judged = [name for name in names if name in expected]
        missing = [name for name in names if name not in expected]
        if not judged and not missing:
            continue
        claim = f"{function}: all as in the textbook"
        if missing and function in lifted.groups and function != "initialize":
            yield Row(unit, claim, "names", f"not in the textbook: {', '.join(missing)}", False)
            continue
        differences = {name: expected[name] - computed[name] for name in judged}
        row = _vanishing(unit, claim, casadi.vertcat(*differences.values()), model.SAMPLES)
        if not row.holds:
            rows = [_vanishing(unit, name, difference, model.SAMPLES) for name, difference in differences.items()]
            wrong = [f"{row.claim}: {row.bound}" for row in rows if not row.holds]
            row = replace(row, bound="; ".join(wrong))
        yield row


def of_equations(unit: str, lifted: Lifted, model: ModuleType) -> Iterator[Row]:
    """Claims about the traced equations: equal to the textbook's, and with its identities."""
    yield from equality(unit, lifted, model)
    yield from _each(unit, _vanishing, getattr(model, "identities", None), lifted.equations, model.SAMPLES)


def of_steps(unit: str, lifted: Lifted, model: ModuleType) -> Iterator[Row]:
    """Claims about the traced steps of the solvers: what they keep, and what they are known to lose."""
    yield from _each(unit, _vanishing, getattr(model, "step_identities", None), lifted.step, model.SAMPLES)
    yield from _each(unit, _differing, getattr(model, "step_failures", None), lifted.step, model.SAMPLES)


def own_identities(unit: str, model: ModuleType) -> Iterator[Row]:
    """A model's identities on its own equations: they say whether the model itself is right."""
    yield from _each(unit, _vanishing, getattr(model, "identities", None), model.equations, model.SAMPLES)


def _each(unit: str, show: Callable, claims: Callable | None, argument: Callable, samples: Samples) -> Iterator[Row]:
    if claims is None:
        return
    for claim, expression in claims(argument).items():
        parts = expression if isinstance(expression, (list, tuple)) else [expression]
        yield show(unit, claim, casadi.vertcat(*[casadi.vec(SX(part)) for part in parts]), samples)
