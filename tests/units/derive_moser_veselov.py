"""Derives the coefficients of preprocessed discrete Moser-Veselov, and writes them as C.

One step of discrete Moser-Veselov turns the body by the quaternion (1, e) / sqrt(1 + e.e), where m is the angular
momentum in body axes and J the diagonal inertia that the step is given:

    h m (1 + e.e) / 2 = J e + e x J e,        m_next = 2 / (h (1 + e.e)) (J e - e x J e)

so m + m_next = 4 / (h (1 + e.e)) J e. With e of the exact free motion of a body of inertia I over h, this says what J
must be for the step to be exact:

    1 / J_j = 4 e_j / (h (1 + e.e) (m + m_next)_j) = (1 + s_2 h^2 + s_4 h^4 + ...) / I_j + d_2 h^2 + d_4 h^4 + ...

The s and d are the same for all three j and on all of an orbit (Hairer and Vilmart, J. Phys. A 39 (2006) 13225), so
they are polynomials in half the square of the momentum, the energy, and the symmetric functions of 1 / I. Here their
values at rational points come from the Taylor series of the motion about the middle of the step, the polynomials from
linear equations, and more points than unknowns show that there are such polynomials: all in rational arithmetic.

    python derive_moser_veselov.py            prints the C header
"""

import random
import textwrap
from collections import Counter
from fractions import Fraction
from functools import cache

ORDER = 10
TERMS = ORDER + 1
SYMBOLS = ("p", "e", "a", "b", "c")

Series = list[Fraction]
Monomial = tuple[int, ...]
Polynomial = dict[Monomial, Fraction]


def multiply(a: Series, b: Series) -> Series:
    """Product of two power series of equal length, cut there."""
    return [sum((a[k] * b[n - k] for k in range(n + 1)), Fraction(0)) for n in range(len(a))]


def divide(a: Series, b: Series) -> Series:
    """Quotient of two power series of equal length, b[0] not zero."""
    quotient: Series = []
    for n, value in enumerate(a):
        quotient.append((value - sum(quotient[k] * b[n - k] for k in range(n))) / b[0])
    return quotient


def combine(*products: tuple[int, Series, Series]) -> Series:
    """Sum of signed products of power series."""
    return [sum(terms) for terms in zip(*[[s * x for x in multiply(a, b)] for s, a, b in products], strict=True)]


def compose(a: list[Series], b: list[Series]) -> list[Series]:
    """Hamilton product of two quaternions of power series."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return [
        combine((1, aw, bw), (-1, ax, bx), (-1, ay, by), (-1, az, bz)),
        combine((1, aw, bx), (1, ax, bw), (1, ay, bz), (-1, az, by)),
        combine((1, aw, by), (-1, ax, bz), (1, ay, bw), (1, az, bx)),
        combine((1, aw, bz), (1, ax, by), (-1, ay, bx), (1, az, bw)),
    ]


def free_motion(inverse: list[int], momentum: list[int]) -> tuple[list[Series], list[Series]]:
    """Power series in t of body momentum and attitude: dm/dt = m x m/I and dq/dt = q (0, m/I) / 2 with q(0) = 1."""
    m = [[Fraction(value)] for value in momentum]
    q = [[Fraction(k == 0)] for k in range(4)]
    for n in range(TERMS - 1):
        rate = [[i * x for x in values] for i, values in zip(inverse, m, strict=True)]
        turn = compose(q, [[Fraction(0)] * (n + 1), *rate])
        torque = [combine((1, m[k - 2], rate[k - 1]), (-1, m[k - 1], rate[k - 2])) for k in range(3)]
        for component, slope in zip(m, torque, strict=True):
            component.append(slope[n] / (n + 1))
        for component, slope in zip(q, turn, strict=True):
            component.append(slope[n] / (2 * (n + 1)))
    return m, q


def coefficients_at(inverse: list[int], momentum: list[int]) -> list[tuple[Fraction, Fraction]]:
    """(s_n, d_n) for n = 0 .. ORDER - 1; the momentum is that in the middle of the step."""
    m, q = free_motion(inverse, momentum)
    before, after = ([[x * half**n for n, x in enumerate(c)] for c in q] for half in (Fraction(-1, 2), Fraction(1, 2)))
    step = compose([before[0], *[[-x for x in c] for c in before[1:]]], after)
    needed = []
    for j in range(3):
        # e_j / (1 + e.e) is vector part times scalar part of the unit quaternion; one power of h cancels
        numerator = [4 * x for x in multiply(step[1 + j], step[0])[1:]]
        both = [2 * x / 2**n if n % 2 == 0 else Fraction(0) for n, x in enumerate(m[j])]
        needed.append(divide(numerator, both[:-1]))
    pairs = []
    for values in zip(*needed, strict=True):
        s = (values[0] - values[1]) / (inverse[0] - inverse[1])
        d = values[0] - s * inverse[0]
        if values[2] != s * inverse[2] + d:
            raise ArithmeticError("no s and d fit all three axes")
        pairs.append((s, d))
    return pairs


def monomials(half_order: int, extra: int) -> list[Monomial]:
    """Powers of SYMBOLS that have the dimension of s (extra 0) or d (extra 1) at h^(2 half_order)."""
    found = []
    for b in range(half_order + 1):
        degree = 2 * half_order - b + extra
        found += [
            (half_order - b, b, degree - 2 * q - 3 * r, q, r)
            for r in range(degree // 3 + 1)
            for q in range((degree - 3 * r) // 2 + 1)
        ]
    return found


def invariants(inverse: list[int], momentum: list[int]) -> list[Fraction]:
    """The values of SYMBOLS: m.m / 2, energy, and the symmetric functions of 1 / I."""
    a, b, c = inverse
    energy = sum(i * m * m for i, m in zip(inverse, momentum, strict=True))
    return [Fraction(sum(m * m for m in momentum), 2), Fraction(energy, 2), a + b + c, a * b + b * c + c * a, a * b * c]


def solve(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """The one solution of more equations than unknowns; ArithmeticError if they contradict or leave one free."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    count = len(matrix[0])
    for column in range(count):
        pivot = next((r for r in range(column, len(rows)) if rows[r][column]), None)
        if pivot is None:
            raise ArithmeticError("too few independent points")
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [x / rows[column][column] for x in rows[column]]
        for r, row in enumerate(rows):
            if r != column and row[column]:
                rows[r] = [x - row[column] * y for x, y in zip(row, rows[column], strict=True)]
    if any(row[count] for row in rows[count:]):
        raise ArithmeticError("no such polynomial")
    return [row[count] for row in rows[:count]]


@cache
def derive() -> list[tuple[Polynomial, Polynomial]]:
    """The polynomials (s_n, d_n) for n = 2, 4 .. ORDER - 2."""
    spare = 4
    count = max(len(monomials(ORDER // 2 - 1, extra)) for extra in (0, 1)) + spare
    draw = random.Random(2006)
    points = [(draw.sample(range(1, 20), 3), [draw.randint(1, 12) for _ in range(3)]) for _ in range(count)]
    known = [(invariants(*point), coefficients_at(*point)) for point in points]

    def fit(half_order: int, extra: int) -> Polynomial:
        basis = monomials(half_order, extra)
        used = known[: len(basis) + spare]
        matrix = [[product(values, powers) for powers in basis] for values, _ in used]
        solution = solve(matrix, [pairs[2 * half_order][extra] for _, pairs in used])
        return {powers: value for powers, value in zip(basis, solution, strict=True) if value}

    return [(fit(k, 0), fit(k, 1)) for k in range(1, ORDER // 2)]


def product(values: list[Fraction], powers: Monomial) -> Fraction:
    """One monomial's value."""
    result = Fraction(1)
    for value, power in zip(values, powers, strict=True):
        result *= value**power
    return result


def term(powers: Monomial, value: Fraction) -> str:
    """One monomial in C."""
    symbols = [symbol for symbol, power in zip(SYMBOLS, powers, strict=True) for _ in range(power)]
    return " * ".join([f"{value.numerator}.0 / {value.denominator}.0", *symbols])


def horner(polynomial: Polynomial) -> str:
    """The polynomial in C, the commonest symbol factored out first."""
    uses = Counter(k for powers in polynomial for k, power in enumerate(powers) if power)
    if len(polynomial) == 1 or uses.most_common(1)[0][1] == 1:
        return " + ".join(term(*item) for item in polynomial.items())
    common = uses.most_common(1)[0][0]
    inside = {
        tuple(power - (k == common) for k, power in enumerate(powers)): value
        for powers, value in polynomial.items()
        if powers[common]
    }
    outside = {powers: value for powers, value in polynomial.items() if not powers[common]}
    return " + ".join([f"{SYMBOLS[common]} * ({horner(inside)})", *([horner(outside)] if outside else [])])


def by_motion(polynomial: Polynomial) -> list[str]:
    """The polynomial as summands in C, one for each product of powers of momentum and energy."""
    groups: dict[tuple[int, int], Polynomial] = {}
    for (a, b, *rest), value in polynomial.items():
        groups.setdefault((a, b), {})[0, 0, *rest] = value
    return [
        " * ".join([SYMBOLS[0]] * a + [SYMBOLS[1]] * b) + f" * ({horner(group)})".replace("+ -", "- ")
        for (a, b), group in groups.items()
    ]


def wrapped(summand: str) -> list[str]:
    """The summand on lines of its own, broken before the signs within."""
    bound = (
        summand.replace(" * ", "\xa0*\xa0").replace(" / ", "\xa0/\xa0").replace("+ ", "+\xa0").replace("- ", "-\xa0")
    )
    lines = textwrap.wrap(bound, 118, initial_indent=" " * 8, subsequent_indent=" " * 12)
    return [line.replace("\xa0", " ") for line in lines]


def header() -> str:
    """The C header with the series of both coefficients."""
    lines = [
        "/* The inertia with which discrete Moser-Veselov is of order 10; by tests/units/derive_moser_veselov.py.",
        " *",
        " *   1 / J = factor / I + offset",
        " */",
        "#ifndef MOSER_VESELOV_SERIES_H",
        "#define MOSER_VESELOV_SERIES_H",
        "",
        '#include "vector.h"',
        "",
        "typedef struct InverseInertia {",
        "    real factor, offset;",
        "} InverseInertia;",
        "",
        "/* p: h^2 L.L / 2; e: h^2 times the energy; a, b, c: sum, sum of the pairs' products, product of 1 / I. */",
        "static inline InverseInertia moser_veselov_series(real p, real e, real a, real b, real c)",
        "{",
    ]
    for k, polynomials in enumerate(derive(), 1):
        for name, polynomial in zip(("factor", "offset"), polynomials, strict=True):
            lines.append(f"    real {name}_{2 * k} =")
            first, *others = by_motion(polynomial)
            summands = [first, *[f"+ {summand}" for summand in others]]
            lines += [line for summand in summands for line in wrapped(summand)]
            lines[-1] += ";"
    orders = range(2, ORDER, 2)
    lines.append("    InverseInertia inverse;")
    lines.append(f"    inverse.factor = 1.0 + {' + '.join(f'factor_{n}' for n in orders)};")
    lines.append(f"    inverse.offset = {' + '.join(f'offset_{n}' for n in orders)};")
    return "\n".join([*lines, "    return inverse;", "}", "", "#endif", ""])


if __name__ == "__main__":
    print(header(), end="")
