"""An expression as a list of elementary operations, to be carried out in any arithmetic."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import casadi
from casadi import SX

OPERATIONS = {
    number: name.removeprefix("OP_").lower()
    for name, number in vars(casadi).items()
    if name.startswith("OP_") and isinstance(number, int)
}
MOST_COMPLEX = 10**8
"""Numerator times denominator of a fraction that a constant is read as, factors of two left out."""
NO_LONGER_SIMPLE = 2**52
TWO_ROUNDINGS = Fraction(1, 2**52)


class UnsupportedError(ValueError):
    """An operation that an arithmetic does not have."""


class Arithmetic(Protocol):
    """Where a graph is evaluated: constants, and operations by their CasADi names in lower case."""

    def constant(self, value: float) -> Any:
        """The element that stands for a constant of the graph."""

    def apply(self, operation: str, a: Any, b: Any) -> Any:
        """Result of an operation; `b` is None if it takes one operand. Raises UnsupportedError."""


@dataclass(frozen=True)
class Graph:
    """A column of expressions as a program: each step is (operation, target, first, second or None)."""

    symbols: tuple[str, ...]
    """Names of the symbols; element k of a column `x` is `x_k`."""
    constants: tuple[tuple[int, float], ...]
    steps: tuple[tuple[str, int, int, int | None], ...]
    results: tuple[int, ...]
    size: int

    @property
    def operations(self) -> set[str]:
        """All operations that occur."""
        return {step[0] for step in self.steps}


def graph_of(expression: SX) -> Graph:
    """The program of an expression, all its elements in CasADi's order (columns one after the other)."""
    column = casadi.densify(casadi.vec(expression))
    symbols = casadi.symvar(column)
    function = casadi.Function("graph", [casadi.vertcat(*symbols)], [column])
    # CasADi uses its work places again: here each different value gets one of its own
    place: dict[int, int] = {}
    known: dict[tuple, int] = {}
    constants: list[tuple[int, float]] = []
    steps: list[tuple[str, int, int, int | None]] = []
    results = [0] * column.numel()
    size = len(symbols)
    for k in range(function.n_instructions()):
        operation = OPERATIONS[function.instruction_id(k)]
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if operation == "output":
            results[writes[1]] = place[reads[0]]
            continue
        if operation == "input":
            place[writes[0]] = reads[1]
            continue
        constant = function.instruction_constant(k) if operation == "const" else None
        operands = [place[i] for i in reads]
        key = (operation, constant, *operands)
        if key not in known:
            known[key] = size
            if constant is None:
                steps.append((operation, size, operands[0], operands[1] if len(operands) > 1 else None))
            else:
                constants.append((size, constant))
            size += 1
        place[writes[0]] = known[key]
    return Graph(tuple(symbol.name() for symbol in symbols), tuple(constants), tuple(steps), tuple(results), size)


def run(graph: Graph, arithmetic: Arithmetic, inputs: Sequence[Any], seen: Callable | None = None) -> list[Any]:
    """Carries a graph out, with one element of the arithmetic for each symbol; returns those of the results."""
    values: list[Any] = [None] * graph.size
    values[: len(inputs)] = inputs
    for target, number in graph.constants:
        values[target] = arithmetic.constant(number)
    apply = arithmetic.apply
    for operation, target, first, second in graph.steps:
        values[target] = apply(operation, values[first], None if second is None else values[second])
    if seen:
        seen(values)
    return [values[i] for i in graph.results]


def simplest_fraction(value: float) -> Fraction:
    """The fraction that a constant stands for: 1.0 / 6.0 is 1/6, also where CasADi has multiplied such constants.

    The first convergent of the continued fraction that is within two roundings, if that is so simple, powers of two
    aside, that it is no accident; else the binary number as it is.
    """
    exact = rest = Fraction(value)
    before, convergent = (0, 1), (1, 0)
    while True:
        whole = rest.numerator // rest.denominator
        before, convergent = convergent, (whole * convergent[0] + before[0], whole * convergent[1] + before[1])
        if abs(convergent[0]) * convergent[1] > NO_LONGER_SIMPLE:
            return exact
        near = Fraction(*convergent)
        if abs(near - exact) <= abs(exact) * TWO_ROUNDINGS:
            return near if _odd(abs(near.numerator)) * _odd(near.denominator) <= MOST_COMPLEX else exact
        rest = 1 / (rest - whole)


def _odd(number: int) -> int:
    """A number without its factors of two."""
    return number // (number & -number) if number else 0
