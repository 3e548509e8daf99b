"""Motions to 40 digits and more: Taylor series of quadratic equations in whole numbers.

Nothing is shared with the units: no floating point, other variables, and a step and an order of its own.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from operator import mul

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BITS = 220
"""Of the fixed point: 66 digits after it."""
ORDER = 44
DIGITS = 45
"""A step is so short that its last term is below this."""


@dataclass(frozen=True)
class Quadratic:
    """y[k]' = sum of c y[i] y[j] over the terms (k, c, i, j), from `first`, whose last element is the constant 1."""

    first: tuple[float, ...]
    terms: tuple[tuple[int, Fraction, int, int], ...]

    def slope(self, _: float, y: Array) -> Array:
        """The same in doubles, [n], for integrators that take a function."""
        to, factors, left, right = self._columns
        return np.bincount(to, factors * y[left] * y[right], y.size)

    @cached_property
    def _columns(self) -> tuple[NDArray, ...]:
        to, factors, left, right = zip(*self.terms, strict=True)
        return np.array(to), np.array(factors, float), np.array(left), np.array(right)


def fixed(value: Fraction | float) -> int:
    """A number in fixed point; a double is taken for exactly what it is."""
    return int(Fraction(value) * (1 << BITS))


def series(system: Quadratic, y: list[int], order: int) -> list[list[int]]:
    """Taylor coefficients [n][order + 1] at y, all in fixed point."""
    factors = [(k, fixed(c), i, j) for k, c, i, j in system.terms]
    coefficients = [[value] for value in y]
    for n in range(order):
        sums = [0] * len(y)
        products: dict[tuple[int, int], int] = {}
        for k, c, i, j in factors:
            if (i, j) not in products:
                products[i, j] = sum(map(mul, coefficients[i], reversed(coefficients[j]))) >> BITS
            sums[k] += c * products[i, j] >> BITS
        for coefficient, total in zip(coefficients, sums, strict=True):
            coefficient.append(total // (n + 1))
    return coefficients


def integrate(system: Quadratic, end: float, order: int = ORDER, digits: int = DIGITS) -> list[Fraction]:
    """State [n] at `end` s: each step as long as its two last terms are below 10^-digits (Jorba & Zou 2005)."""
    y = [fixed(value) for value in system.first]
    left = fixed(end)
    while left > 0:
        coefficients = series(system, y, order)
        last = max(abs(c[-1]) + abs(c[-2]) for c in coefficients) + 1
        # the radius as a power of two: log2(last / 2^BITS) / order is the growth of a coefficient by order
        log_reach = -(digits * 3.3219280948873623 + last.bit_length() - BITS) / order
        reach = int(2.0 ** (log_reach + 60)) << (BITS - 60)
        h = min(left, reach)
        y = [_sum(c, h) for c in coefficients]
        left -= h
    return [Fraction(value, 1 << BITS) for value in y]


def _sum(coefficients: list[int], h: int) -> int:
    total = 0
    for coefficient in reversed(coefficients):
        total = (total * h >> BITS) + coefficient
    return total
