"""Power series in one variable, cut off at some order, as an arithmetic: coefficients are mpmath's numbers.

The recurrences of sums, products, quotients, roots, sines and exponentials: Jorba and Zou, Experimental Mathematics 14
(2005) 99, proposition 2.1.
"""

from collections.abc import Mapping, Sequence

import casadi
from casadi import SX
from mpmath import mp, mpf

from .graph import Graph, UnsupportedError, graph_of, run, simplest_fraction

Coefficients = list[mpf]
"""From order 0 on; what is not there is zero."""
TINY = mpf(10) ** -200
"""What C adds to a square so as not to divide by zero is zero here."""
SPARE = 3
"""Orders that roots and quotients of series without a constant may lose at the end."""


class Series:
    """Series up to an order, at mpmath's present precision."""

    def __init__(self, order: int, spare: int = 0):
        """`order`: of the last coefficient that is asked for; `spare`: how many more are carried."""
        self._order = order + spare

    def constant(self, value: float) -> Coefficients:
        """A number; 1.0 / 6.0 is taken for 1/6."""
        fraction = simplest_fraction(value)
        return [mpf(fraction.numerator) / fraction.denominator]

    def apply(self, operation: str, a: Coefficients, b: Coefficients | None) -> Coefficients:
        """The result; raises UnsupportedError."""
        match operation:
            case "add":
                return [x + y for x, y in _padded(a, b)]
            case "sub":
                return [x - y for x, y in _padded(a, b)]
            case "neg":
                return [-x for x in a]
            case "twice":
                return [2 * x for x in a]
            case "assign":
                return a
            case "mul":
                return self._product(a, b)
            case "sq":
                return self._product(a, a)
            case "div":
                return self._quotient(a, b)
            case "inv":
                return self._quotient([mpf(1)], a)
            case "sqrt":
                return self._root(a)
            case "sin" | "cos":
                return self._wave(a)[operation == "cos"]
            case "exp":
                return self._exponential(a)
        raise UnsupportedError(operation)

    def _length(self, *parts: Coefficients) -> int:
        """Coefficients of a result that is no polynomial, or one number if the parts are."""
        return 1 if all(len(part) == 1 for part in parts) else self._order + 1

    def _product(self, a: Coefficients, b: Coefficients) -> Coefficients:
        length = min(len(a) + len(b) - 1, self._order + 1)
        return [_convolved(a, b, n) for n in range(length)]

    def _quotient(self, a: Coefficients, b: Coefficients) -> Coefficients:
        if len(a) > 1 and len(b) > 1 and a[0] == b[0] == 0:
            return self._quotient(a[1:], b[1:])
        result: Coefficients = []
        for n in range(self._length(a, b)):
            result.append(((a[n] if n < len(a) else 0) - _convolved(result, b, n)) / b[0])
        return result

    def _root(self, a: Coefficients) -> Coefficients:
        if len(a) > 2 and abs(a[0]) < TINY and a[1] == 0:
            return [mpf(0), *self._root(a[2:])]
        result = [mp.sqrt(a[0])]
        for n in range(1, self._length(a)):
            inner = mp.fdot(result[1:], reversed(result[1:]))
            result.append(((a[n] if n < len(a) else 0) - inner) / (2 * result[0]))
        return result

    def _wave(self, a: Coefficients) -> tuple[Coefficients, Coefficients]:
        """Sine and cosine."""
        slope = [n * x for n, x in enumerate(a)]
        sine, cosine = [mp.sin(a[0])], [mp.cos(a[0])]
        for n in range(1, self._length(a)):
            up, down = _convolved(slope, cosine, n) / n, -_convolved(slope, sine, n) / n
            sine.append(up)
            cosine.append(down)
        return sine, cosine

    def _exponential(self, a: Coefficients) -> Coefficients:
        slope = [n * x for n, x in enumerate(a)]
        result = [mp.exp(a[0])]
        for n in range(1, self._length(a)):
            result.append(_convolved(slope, result, n) / n)
        return result


def _padded(a: Coefficients, b: Coefficients) -> zip:
    length = max(len(a), len(b))
    zero = mpf(0)
    return zip(*(part + [zero] * (length - len(part)) for part in (a, b)), strict=True)


def _convolved(a: Coefficients, b: Coefficients, n: int) -> mpf:
    """Sum of a[i] b[n - i] over what is there."""
    first, last = max(0, n - len(b) + 1), min(n, len(a) - 1)
    return mp.fdot((a[i], b[n - i]) for i in range(first, last + 1))


def flow(motion: Sequence[tuple[SX, SX]], start: Mapping[str, mpf], order: int) -> dict[str, Coefficients]:
    """Coefficients up to `order` in time of the symbols that move, by name: `motion` pairs columns with their rates.

    `start` has the values of all symbols. Each coefficient of a rate gives the next one of its symbol.
    """
    symbols, rates = zip(*motion, strict=True)
    names = [symbol.name() for symbol in SX(casadi.vertcat(*symbols)).elements()]
    graph: Graph = graph_of(casadi.vertcat(*rates))
    series = {name: [value] for name, value in start.items()}
    for n in range(order):
        found = run(graph, Series(n), [series[name] for name in graph.symbols])
        for name, rate in zip(names, found, strict=True):
            series[name] = [*series[name], (rate[n] if n < len(rate) else mpf(0)) / (n + 1)]
    return {name: series[name] for name in names}
