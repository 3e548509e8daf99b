"""Arithmetics for graphs: a finite field, degrees of rational functions, and digits with a bound on rounding.

In the field of p = 2^61 - 1 an expression in + - * / is exact. Since p = 3 mod 4, the squares of the field take
the place of the positive numbers: a product of squares is one, -1 is none, and each has exactly one root that is
a square again. So sqrt(a b) = sqrt(a) sqrt(b), and sqrt(b b) = b for a square b, as they do for positive reals.
The sine and cosine of a sum of angles are rational in the tangents of parts of them; as an angle and its tangent
are algebraically independent, each is drawn on its own.
"""

import math
from collections.abc import Sequence
from fractions import Fraction
from math import lcm
from typing import NamedTuple

from mpmath import mp, mpf

from .graph import Graph, UnsupportedError, run, simplest_fraction

PRIME = 2**61 - 1
TRIGONOMETRIC = {"sin", "cos", "tan"}
RATIONAL = {"assign", "add", "sub", "mul", "div", "neg", "sq", "twice", "inv"}


class UndefinedError(ArithmeticError):
    """The expression has no value at this point; another must be drawn."""


class Linear:
    """Arithmetic that finds which places of a graph are sums of symbols with rational factors, without a constant."""

    def constant(self, value: float) -> Fraction:
        """A number."""
        return simplest_fraction(value)

    def apply(self, operation: str, a: object, b: object) -> object:
        """A dict of symbol to factor for a linear place, a Fraction for a number, None for all else."""
        if operation == "assign":
            return a
        if operation == "neg":
            return _times(a, Fraction(-1))
        if operation == "twice":
            return _times(a, Fraction(2))
        if operation in ("add", "sub") and isinstance(a, dict) and isinstance(b, dict):
            sign = 1 if operation == "add" else -1
            return {key: a.get(key, 0) + sign * b.get(key, 0) for key in {*a, *b}}
        if operation == "mul":
            return _times(a, b) if isinstance(b, Fraction) else _times(b, a) if isinstance(a, Fraction) else None
        if operation == "div" and isinstance(b, Fraction) and b:
            return _times(a, 1 / b)
        return None


def _times(a: object, factor: Fraction) -> object:
    if isinstance(a, dict):
        return {key: factor * value for key, value in a.items()}
    return factor * a if isinstance(a, Fraction) else None


class Angles(NamedTuple):
    """The arguments of a graph's sines and cosines, each index of symbol -> how many parts of that angle."""

    parts: int
    """How many parts an angle has, so that all arguments are sums of whole numbers of them."""
    arguments: list[dict[int, int]]


def angles_of(graph: Graph) -> Angles:
    """The arguments of sin, cos and tan; raises UnsupportedError if one is not a sum of symbols, rational factors."""
    places: list[object] = []
    run(graph, Linear(), [{i: Fraction(1)} for i in range(len(graph.symbols))], places.extend)
    forms = [places[first] for operation, _, first, _ in graph.steps if operation in TRIGONOMETRIC]
    if not all(isinstance(form, dict) for form in forms):
        raise UnsupportedError("the sine of something else than a sum of angles")
    parts = lcm(*(factor.denominator for form in forms for factor in form.values()))
    return Angles(parts, [{i: int(f * parts) for i, f in form.items() if f} for form in forms])


def field(value: Fraction) -> int:
    """A fraction as an element of the field."""
    return value.numerator * pow(value.denominator, -1, PRIME) % PRIME


def field_root(a: int) -> int:
    """The root of a square that is a square itself; raises UndefinedError for what is no square."""
    root = pow(a, (PRIME + 1) // 4, PRIME)
    if root * root % PRIME != a:
        raise UndefinedError
    return root


def field_inverse(a: int) -> int:
    """1/a; raises UndefinedError for zero."""
    if a == 0:
        raise UndefinedError
    return pow(a, -1, PRIME)


def whole_power(exponent: int, one: object, base: object, times: object) -> object:
    """base^exponent, exponent >= 0, by squaring, with the product `times` and its neutral element."""
    result = one
    while exponent:
        if exponent & 1:
            result = times(result, base)
        base = times(base, base)
        exponent >>= 1
    return result


class Rational(NamedTuple):
    """An element of the field, and the degree of the rational function that it is a value of.

    The denominator is a product of factors, by their values: value -> (power, degree).
    """

    value: int
    degree: int
    factors: dict[int, tuple[int, int]]


def _degree(factors: dict[int, tuple[int, int]]) -> int:
    return sum(power * degree for power, degree in factors.values())


def _common(a: dict, b: dict) -> dict:
    if a is b or not b:
        return a
    return {key: max(a.get(key, (0, 0)), b.get(key, (0, 0))) for key in {*a, *b}}


def _product(a: dict, b: dict) -> dict:
    if not b:
        return a
    merged = dict(a)
    for key, (power, degree) in b.items():
        merged[key] = (merged.get(key, (0, 0))[0] + power, degree)
    return merged


ALGEBRAIC = RATIONAL | TRIGONOMETRIC | {"sqrt", "fabs", "constpow", "pow"}


class Field:
    """The field of p elements, with degrees, at one point: a value for each symbol."""

    def __init__(self, angles: Angles, point: Sequence[int], tangents: Sequence[int]):
        """`tangents`: of half a part of each symbol as an angle."""
        self._turns = {}
        for argument in angles.arguments:
            # an argument is recognised by its value
            value = sum(count * point[i] for i, count in argument.items()) * field_inverse(angles.parts) % PRIME
            self._turns[value] = _turned(argument, tangents)
        self.roots: set[int] = set()
        """Arguments of the square roots."""

    def constant(self, value: float) -> Rational:
        """A constant, as the simplest fraction that rounds to it."""
        return Rational(field(simplest_fraction(value)), 0, {})

    def apply(self, operation: str, a: Rational, b: Rational | None) -> Rational:
        """The result; raises UndefinedError where a divisor is zero or a root has no square."""
        match operation:
            case "add" | "sub":
                value = a.value + b.value if operation == "add" else a.value - b.value
                factors = _common(a.factors, b.factors)
                whole = _degree(factors)
                degree = max(a.degree - _degree(a.factors), b.degree - _degree(b.factors)) + whole
                return Rational(value % PRIME, degree, factors)
            case "mul":
                return self._times(a, b)
            case "div":
                return self._times(a, self._inverse(b))
            case "inv":
                return self._inverse(a)
            case "neg":
                return a._replace(value=-a.value % PRIME)
            case "twice":
                return a._replace(value=2 * a.value % PRIME)
            case "sq":
                return self._times(a, a)
            case "sqrt":
                return self._root(a)
            case "fabs":
                return self._root(self._times(a, a))
            case "constpow" | "pow":
                return self._power(a, b)
            case "cos":
                return self._turns[a.value][0]
            case "sin":
                return self._turns[a.value][1]
            case "tan":
                cosine, sine = self._turns[a.value]
                return self._times(sine, self._inverse(cosine))
            case "assign":
                return a
        raise UnsupportedError(operation)

    def _times(self, a: Rational, b: Rational) -> Rational:
        return Rational(a.value * b.value % PRIME, a.degree + b.degree, _product(a.factors, b.factors))

    def _inverse(self, a: Rational) -> Rational:
        value = field_inverse(a.value)
        # a = n / d: 1/a = d / n, where n = a d
        numerator = a.value
        for factor, (power, _) in a.factors.items():
            numerator = numerator * pow(factor, power, PRIME) % PRIME
        return Rational(value, _degree(a.factors), {numerator: (1, a.degree)} if a.degree else {})

    def _root(self, a: Rational) -> Rational:
        root = field_root(a.value)
        if a.degree or a.factors:
            self.roots.add(a.value)
        # sqrt(n / d) = sqrt(n d) / d
        return Rational(root, (a.degree + _degree(a.factors) + 1) // 2, a.factors)

    def _power(self, a: Rational, b: Rational) -> Rational:
        doubled = next((n for n in range(-64, 65) if field(Fraction(n, 2)) == b.value), None)
        if doubled is None or b.degree:
            raise UnsupportedError("a power that is no half of a small whole number")
        base = a if doubled % 2 == 0 else self._root(a)
        count = doubled // 2 if doubled % 2 == 0 else doubled
        result = whole_power(abs(count), Rational(1, 0, {}), base, self._times)
        return result if count >= 0 else self._inverse(result)


def _turned(argument: dict[int, int], tangents: Sequence[int]) -> tuple[Rational, Rational]:
    """Cosine and sine of a sum of parts of angles."""
    turn, degree, factors = (1, 0), 0, {}
    for i, count in argument.items():
        t = tangents[i]
        divisor = (1 + t * t) % PRIME
        inverse = field_inverse(divisor)
        part = ((1 - t * t) * inverse % PRIME, (1 if count > 0 else -1) * 2 * t * inverse % PRIME)
        turn = _turn_product(turn, whole_power(abs(count), (1, 0), part, _turn_product))
        degree += 2 * abs(count)
        factors = _product(factors, {divisor: (abs(count), 2)})
    return Rational(turn[0], degree, factors), Rational(turn[1], degree, factors)


def _turn_product(a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    return (a[0] * b[0] - a[1] * b[1]) % PRIME, (a[0] * b[1] + a[1] * b[0]) % PRIME


class Digits(NamedTuple):
    """A number, and the sum of the roundings on its way, each in units of the number rounded.

    A floating-point evaluation of the same graph, each operation with a relative error of u, is off by at most
    `rounding` times u, to first order (running error analysis: Higham 2002, Accuracy and Stability, 3.3).
    """

    value: mpf
    near: float
    """The same to double precision."""
    rounding: float


def exactly(value: mpf | float) -> Digits:
    """A number without a rounding."""
    return Digits(mpf(value), float(value), 0.0)


# the function, and its slope from the argument and the result
FUNCTIONS = {
    "sin": (mp.sin, lambda a, _: math.cos(a)),
    "cos": (mp.cos, lambda a, _: math.sin(a)),
    "tan": (mp.tan, lambda _, value: 1 + value * value),
    "exp": (mp.exp, lambda _, value: value),
    "log": (mp.log, lambda a, _: 1 / a),
    "sqrt": (mp.sqrt, lambda _, value: 0.5 / value),
    "asin": (mp.asin, lambda a, _: 1 / math.sqrt(1 - a * a)),
    "acos": (mp.acos, lambda a, _: 1 / math.sqrt(1 - a * a)),
    "atan": (mp.atan, lambda a, _: 1 / (1 + a * a)),
    "sinh": (mp.sinh, lambda a, _: math.cosh(a)),
    "cosh": (mp.cosh, lambda a, _: math.sinh(a)),
    "tanh": (mp.tanh, lambda _, value: 1 - value * value),
    "log1p": (mp.log1p, lambda a, _: 1 / (1 + a)),
    "expm1": (mp.expm1, lambda _, value: 1 + value),
}
FIRST_UNDEFINED = {"sqrt": 0.0, "log": 0.0, "log1p": -1.0}
"""Where a function, or its slope, ends: at and below this argument."""


class Precise:
    """mpmath's numbers at its present precision, with a running bound on the roundings."""

    def __init__(self, *, read_constants: bool = True):
        """`read_constants`: 1.0 / 6.0 is taken for 1/6; else as the double that it is."""
        self._read = read_constants

    def constant(self, value: float) -> Digits:
        """A constant, without a rounding."""
        fraction = simplest_fraction(value) if self._read else Fraction(value)
        return exactly(mpf(fraction.numerator) / fraction.denominator)

    def apply(self, operation: str, a: Digits, b: Digits | None) -> Digits:
        """The result; raises UndefinedError where there is none among the real numbers."""
        match operation:
            case "add" | "sub":
                value = a.value + b.value if operation == "add" else a.value - b.value
                near = float(value)
                return Digits(value, near, a.rounding + b.rounding + abs(near))
            case "mul":
                return self._times(a, b)
            case "div":
                return self._quotient(a, b)
            case "inv":
                return self._quotient(exactly(1), a)
            case "sq":
                return self._times(a, a)
            case "neg":
                return Digits(-a.value, -a.near, a.rounding)
            case "fabs":
                return Digits(abs(a.value), abs(a.near), a.rounding)
            case "twice":
                return Digits(2 * a.value, 2 * a.near, 2 * a.rounding)
            case "assign":
                return a
            case "constpow" | "pow":
                return self._power(a, b)
        if operation not in FUNCTIONS:
            raise UnsupportedError(operation)
        if a.value <= FIRST_UNDEFINED.get(operation, -math.inf):
            raise UndefinedError
        function, slope = FUNCTIONS[operation]
        value = function(a.value)
        near = float(value)
        return Digits(value, near, abs(slope(a.near, near)) * a.rounding + abs(near))

    def _times(self, a: Digits, b: Digits) -> Digits:
        value = a.value * b.value
        near = float(value)
        return Digits(value, near, abs(a.near) * b.rounding + abs(b.near) * a.rounding + abs(near))

    def _quotient(self, a: Digits, b: Digits) -> Digits:
        if not b.near:
            raise UndefinedError
        value = a.value / b.value
        near = float(value)
        return Digits(value, near, (a.rounding + abs(near) * b.rounding) / abs(b.near) + abs(near))

    def _power(self, a: Digits, b: Digits) -> Digits:
        if a.value <= 0 and not (mp.isint(b.value) and (a.value or b.value > 0)):
            raise UndefinedError
        value = a.value**b.value
        near = float(value)
        from_base = abs(b.near * near / a.near) * a.rounding if a.near else 0.0
        from_exponent = abs(math.log(a.near) * near) * b.rounding if b.rounding else 0.0
        return Digits(value, near, from_base + from_exponent + abs(near))
