"""Showing that an expression vanishes identically, or that it does not."""

import random
import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, inf, log10

import casadi
from casadi import SX
from mpmath import mp, mpf

from .arithmetic import ALGEBRAIC, PRIME, Angles, Digits, Field, Precise, Rational, UndefinedError, angles_of, exactly
from .graph import Graph, UnsupportedError, graph_of, run

DIGITS = 50
SPARE_DIGITS = 15
DIGIT_POINTS = 3
DOUBTED_POINTS = 24
"""For what the field has found not to be zero."""
DEPENDENCY_POINTS = 2
CHANCE = -30.0
"""The power of ten below which the chance of error must be."""
MOST_POINTS = 12
ROOT_POINTS = 12
"""Where roots occur: sqrt(x x) is x for one half of all points, so each may show what two or three would not."""
DRAWS = 400
"""A point may fall on a pole or on a root of what is no square: so many are tried for one."""
RANGE = (-1.0, 1.0)

Samples = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Shown:
    """How it was shown whether an expression vanishes."""

    vanishes: bool
    how: str
    bound: str
    """What is left of doubt; where it does not vanish, the size of what is left."""


def vanishes(expression: SX, samples: Samples | None = None, seed: int = 1) -> Shown:
    """Whether all elements of an expression are zero for all values of their symbols.

    First by CasADi's own simplification, then in the field of 2^61 - 1 elements at random points, where sums,
    products, quotients, roots and sines of angles are exact and the degree, counted on the graph, bounds the
    chance that all points are zeros of something else (Schwartz 1980, Zippel 1979); and where other functions
    occur in 50 digits. `samples` gives the range in which a symbol is drawn, by name without its index.
    Raises UnsupportedError for what is no function of real numbers without branches.
    """
    expression = casadi.vec(casadi.densify(SX(expression)))
    if casadi.simplify(expression).is_zero():
        return Shown(True, "symbols", "none: it simplifies to zero")
    graph = graph_of(expression)
    samples, doubt = samples or {}, False
    if graph.operations <= ALGEBRAIC:
        shown, doubt = _in_field(graph, samples, random.Random(seed))
        if shown:
            return shown
    return _in_digits(graph, samples, random.Random(seed), DOUBTED_POINTS if doubt else DIGIT_POINTS)


def range_of(symbol: str, samples: Samples) -> tuple[float, float]:
    """The range of a symbol: its own, that of the column whose element it is (`x` for `x_2`), or (-1, 1)."""
    return samples.get(symbol) or samples.get(re.sub(r"_\d+$", "", symbol)) or RANGE


def depends(expression: SX, samples: Samples | None = None, seed: int = 1) -> list[bool]:
    """For each element of a column whether it is other than zero somewhere: at one of two random points."""
    graph = graph_of(expression)
    samples, source = samples or {}, random.Random(seed)
    found = [False] * len(graph.results)
    points = 0
    exact = graph.operations <= ALGEBRAIC
    with mp.workdps(DIGITS + SPARE_DIGITS):
        for _ in range(DRAWS):
            try:
                if exact:
                    values = [bool(value) for value, *_ in _field_values(graph, angles_of(graph), samples, source)[0]]
                else:
                    results = run(graph, Precise(), _digit_point(graph, samples, source))
                    values = [_size(value) > mpf(10) ** -DIGITS for value in results]
            except UndefinedError:
                continue
            except UnsupportedError:
                exact = False
                continue
            found = [a or b for a, b in zip(found, values, strict=True)]
            points += 1
            if points == DEPENDENCY_POINTS:
                return found
    raise UnsupportedError(f"no value at any of {DRAWS} points in the ranges of the symbols")


def _field_values(
    graph: Graph, angles: Angles, samples: Samples, source: random.Random
) -> tuple[list[Rational], Field]:
    """Results at a random point of the field, and the field that they lie in."""
    point = _field_point(graph, samples, source)
    field = Field(angles, point, [source.randrange(1, PRIME) for _ in point])
    return run(graph, field, [Rational(value, 1, {}) for value in point]), field


def _field_point(graph: Graph, samples: Samples, source: random.Random) -> list[int]:
    """A random element for each symbol; a square for those that are positive."""
    values = []
    for name in graph.symbols:
        value = source.randrange(1, PRIME)
        values.append(value * value % PRIME if range_of(name, samples)[0] >= 0 else value)
    return values


def _in_field(graph: Graph, samples: Samples, source: random.Random) -> tuple[Shown | None, bool]:
    """The verdict of the field that it is zero, if it has that; and whether it found a point where it is not.

    There digits decide: the field does not know that a sum of squares is positive.
    """
    try:
        angles = angles_of(graph)
    except UnsupportedError:
        return None, False
    chance, points = 0.0, 0  # the chance as a power of ten
    degree = roots = 0
    for _ in range(DRAWS):
        try:
            results, field = _field_values(graph, angles, samples, source)
        except UndefinedError:
            continue
        except UnsupportedError:
            return None, False
        if any(result.value for result in results):
            return None, True
        points += 1
        degree = max(1, *(result.degree for result in results))
        roots = len(field.roots)
        # a root has two signs: the product over all of them is rational; and only its squares were drawn
        chance += min(0.0, log10(degree) + roots * log10(4.0) - log10(PRIME))
        if points >= (ROOT_POINTS if roots else MOST_POINTS) or (chance < CHANCE and not roots):
            break
    if not points or chance > CHANCE:
        return None, False
    rooted = f", {roots} root{'s' if roots > 1 else ''}" if roots else ""
    return Shown(True, f"exact, {points} points", f"degree {degree}{rooted}: < 1e{ceil(chance)}"), False


def _digit_point(graph: Graph, samples: Samples, source: random.Random) -> list[Digits]:
    """A random number of 53 bits for each symbol, in its range."""
    values = []
    for name in graph.symbols:
        low, high = range_of(name, samples)
        values.append(exactly(mpf(low) + (mpf(high) - mpf(low)) * mpf(source.randrange(1, 2**53)) / 2**53))
    return values


def _size(result: Digits) -> mpf:
    """A result over the size of the terms that it is made of."""
    if not result.value:
        return mpf(0)
    return abs(result.value) / result.rounding if result.rounding else mpf(inf)


def _in_digits(graph: Graph, samples: Samples, source: random.Random, enough: int) -> Shown:
    """The verdict of 50 digits: the residual over the size of the terms that it is made of."""
    points, largest = 0, mpf(0)
    with mp.workdps(DIGITS + SPARE_DIGITS):
        for _ in range(DRAWS):
            try:
                results = run(graph, Precise(), _digit_point(graph, samples, source))
            except UndefinedError:
                continue
            points += 1
            largest = max(largest, *map(_size, results))
            if points == enough or largest > mpf(10) ** -DIGITS:
                break
    if not points:
        raise UnsupportedError(f"no value at any of {DRAWS} points in the ranges of the symbols")
    if largest > mpf(10) ** -DIGITS:
        return Shown(False, f"a counterexample, {DIGITS} digits", f"{float(largest):.1e} of its terms is left")
    return Shown(True, f"{DIGITS} digits, {points} points", f"< 1e-{DIGITS} of its terms")
