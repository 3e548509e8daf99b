"""What the textbook models share: rotations, derivatives along a motion, changes of frame and of units.

Rotations are rational in the quaternion, and unit vectors rational in their parameters, so that claims can be shown
in exact arithmetic.
"""

from collections.abc import Callable, Iterable, Mapping
from math import factorial

import casadi as ca
from casadi import SX

Values = dict[str, SX]
Equations = Callable[[Values], Mapping[str, SX]]

BASE_UNITS = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "m": (1, 0, 0),
    "kg": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "J": (2, 1, -2),
    "W": (2, 1, -3),
    "Hz": (0, 0, -1),
}
"""Exponents of metre, kilogram and second."""


def skew(v: SX) -> SX:
    """The matrix of the cross product, 3x3: skew(v) u = v x u."""
    return ca.skew(v)


def left(a: SX) -> SX:
    """The Hamilton product as a matrix, 4x4: left(a) b = a b."""
    v = a[1:]
    return ca.blockcat([[a[0], -v.T], [v, a[0] * SX.eye(3) + skew(v)]])


def right(b: SX) -> SX:
    """The same from the other side, 4x4: right(b) a = a b."""
    v = b[1:]
    return ca.blockcat([[b[0], -v.T], [v, b[0] * SX.eye(3) - skew(v)]])


def pure(v: SX) -> SX:
    """The quaternion (0, v)."""
    return ca.vertcat(0, v)


def conjugate(q: SX) -> SX:
    """The quaternion of the opposite rotation."""
    return ca.vertcat(q[0], -q[1:])


def rotation_matrix(q: SX) -> SX:
    """Body to world, 3x3, for a quaternion w, x, y, z of any length; Euler and Rodrigues."""
    w, v = q[0], q[1:]
    return ((w * w - ca.dot(v, v)) * SX.eye(3) + 2 * v @ v.T + 2 * w * skew(v)) / ca.dot(q, q)


def rodrigues(axis: SX, angle: SX) -> SX:
    """The rotation by `angle` (rad) about a unit axis, 3x3."""
    n = skew(axis)
    return SX.eye(3) + ca.sin(angle) * n + (1 - ca.cos(angle)) * n @ n


def unit_quaternion(name: str) -> SX:
    """Every unit quaternion but one, by three free symbols: stereographic projection."""
    s = SX.sym(name, 3)
    square = ca.dot(s, s)
    return ca.vertcat(1 - square, 2 * s) / (1 + square)


def unit_vector(name: str) -> SX:
    """Every unit vector but one, by two free symbols: stereographic projection."""
    s = SX.sym(name, 2)
    square = ca.dot(s, s)
    return ca.vertcat(1 - square, 2 * s) / (1 + square)


def inverse(matrix: SX) -> SX:
    """The inverse by minors: rational in the elements."""
    return ca.inv_minor(matrix)


def along(expression: SX, motion: Iterable[tuple[SX, SX]]) -> SX:
    """The rate of an expression while symbols move: `motion` pairs columns of symbols with their rates."""
    symbols, rates = zip(*motion, strict=True)
    return ca.jtimes(expression, ca.vertcat(*symbols), ca.vertcat(*rates))


def flow_series(start: SX, motion: list[tuple[SX, SX]], count: int) -> list[SX]:
    """Taylor coefficients 0 to `count` of the exact flow: repeated Lie derivatives over the factorial."""
    rates = [start]
    for _ in range(count):
        rates.append(along(rates[-1], motion))
    return [rate / factorial(k) for k, rate in enumerate(rates)]


def step_series(end: SX, h: SX, count: int) -> list[SX]:
    """Taylor coefficients 0 to `count` in the step `h` of the states at its end."""
    rates = [end]
    for _ in range(count):
        rates.append(ca.jtimes(rates[-1], h, SX(1)))
    return [ca.substitute(rate, h, SX(0)) / factorial(k) for k, rate in enumerate(rates)]


def substituted(expression: SX, values: Iterable[tuple[SX, SX]]) -> SX:
    """The expression with symbols replaced: pairs of columns, symbols and what takes their place."""
    symbols, replacements = zip(*values, strict=True)
    return ca.substitute(expression, ca.vertcat(*symbols), ca.vertcat(*replacements))


def factor_of(unit: str, metre: SX, kilogram: SX, second: SX) -> SX:
    """What a number in `unit`, such as "kg.m2/s", is multiplied with when the base units change."""
    factor = SX(1)
    numerator, _, denominator = unit.partition("/")
    for side, sign in ((numerator, 1), (denominator, -1)):
        for part in filter(None, side.split(".")):
            name = part.rstrip("0123456789") or part
            power = sign * int(part[len(name) :] or 1)
            for base, exponent in zip((metre, kilogram, second), BASE_UNITS[name], strict=True):
                factor *= base ** (power * exponent)
    return factor


def in_other_units(f: Equations, values: Values, units: Mapping[str, str], results: Iterable[str]) -> SX:
    """Results with all values in other units of length, mass and time, less the results in those units.

    Vanishes where `f` is right in its dimensions: no equation of physics knows the metre. `units` holds the unit of
    every value and result; the others are left as they are.
    """
    base = [SX.sym(name) for name in ("metre", "kilogram", "second")]
    factors = {name: factor_of(unit, *base) for name, unit in units.items()}
    here = f(values)
    there = f({name: factors.get(name, 1) * value for name, value in values.items()})
    return ca.vertcat(*[there[name] - factors[name] * here[name] for name in results])


def all_differ(expressions: Iterable[SX]) -> SX:
    """A number that is zero where one of the columns vanishes: the product of their squares."""
    product = SX(1)
    for expression in expressions:
        product *= ca.dot(expression, expression)
    return product
