"""The free rigid body to 20 or 40 digits: Taylor series in integers, no formula shared with the solver under test."""

import math
from collections.abc import Iterable
from fractions import Fraction

BITS = 192
DIGITS_20, DIGITS_40 = 20, 46  # orders of the series
ONE = 1 << BITS


def to_fixed(value: float | Fraction) -> int:
    """Integer multiple of 2^-BITS nearest below a number."""
    exact = Fraction(value)
    return (exact.numerator << BITS) // exact.denominator


def product(*factors: int) -> int:
    """Product of numbers in fixed point."""
    result = factors[0]
    for factor in factors[1:]:
        result = (result * factor) >> BITS
    return result


def body_rates(inertia: list[int], quaternion: list[int], momentum: list[int]) -> list[int]:
    """I^-1 R^T L in body axes, for a unit quaternion w, x, y, z."""
    w, *u = quaternion
    along = sum(product(a, b) for a, b in zip(u, momentum, strict=True))
    across = [product(u[i - 2], momentum[i - 1]) - product(u[i - 1], momentum[i - 2]) for i in range(3)]
    square = product(w, w) - sum(product(a, a) for a in u)
    in_body = [product(square, momentum[i]) + 2 * product(u[i], along) - 2 * product(w, across[i]) for i in range(3)]
    return [(m << BITS) // moment for m, moment in zip(in_body, inertia, strict=True)]


def advanced(ratios: list[int], quaternion: list[int], rates: list[int], h: int, order: int) -> tuple[list, list]:
    """Quaternion and rates after h by their Taylor series, from w' = ratio w w (Euler) and q' = q (0, w) / 2."""
    w = [[product(rate, h)] for rate in rates]
    q = [[part] for part in quaternion]
    # (element of q, element of w, sign) of the parts of q (0, w)
    parts = [
        [(1, 0, -1), (2, 1, -1), (3, 2, -1)],
        [(0, 0, 1), (2, 2, 1), (3, 1, -1)],
        [(0, 1, 1), (3, 0, 1), (1, 2, -1)],
        [(0, 2, 1), (1, 1, 1), (2, 0, -1)],
    ]

    def convolution(a: list[int], b: list[int], n: int) -> int:
        return sum(a[j] * b[n - j] for j in range(n + 1))

    for n in range(order):
        rate_terms = [convolution(w[i - 2], w[i - 1], n) >> BITS for i in range(3)]
        turn_terms = [sum(sign * convolution(q[a], w[b], n) for a, b, sign in part) >> BITS for part in parts]
        for i in range(3):
            w[i].append(product(ratios[i], rate_terms[i]) // (n + 1))
        for i in range(4):
            q[i].append(turn_terms[i] // (2 * (n + 1)))
    return [sum(terms) for terms in q], [(sum(terms) << BITS) // h for terms in w]


def free_attitudes(
    inertia: Iterable[float],
    quaternion: Iterable[float],
    momentum: Iterable[float],
    times: Iterable[float],
    order: int = DIGITS_20,
) -> list[list[Fraction]]:
    """Attitudes w, x, y, z (body to world, sign continuous) of a free body at increasing times (s).

    `inertia` (kg m2), `quaternion` and the world's `momentum` (kg m2/s) are taken as exact. The rates are Jacobi's
    functions of lambda t; their poles lie K' / lambda off the real axis, where K' is at least pi / 2 and, by the
    triangle inequality of the moments, lambda is at most the rate w. A step of 0.2 / w leaves out
    at most about 0.127^order, and less where the poles are farther away.
    """
    moments = [to_fixed(value) for value in inertia]
    world = [to_fixed(value) for value in momentum]
    q = [to_fixed(value) for value in quaternion]
    size = math.isqrt(sum(part * part for part in q))
    q = [(part << BITS) // size for part in q]
    ratios = [((moments[i - 2] - moments[i - 1]) << BITS) // moments[i] for i in range(3)]
    rates = body_rates(moments, q, world)
    now, attitudes = Fraction(0), []
    for time in times:
        while now < time:
            fastest = max(math.hypot(*(rate / ONE for rate in rates)), math.hypot(*world) / max(moments))
            left = Fraction(time) - now
            h = min(left, Fraction(0.2 / fastest)) if fastest else left
            q, rates = advanced(ratios, q, rates, to_fixed(h), order)
            now += h
        attitudes.append([Fraction(part, ONE) for part in q])
    return attitudes


def angle_between(truth: list[Fraction], quaternion: Iterable[float]) -> float:
    """Angle (rad) from the exact attitude to one in doubles, without cancellation; 2 pi where the sign is the other."""
    a, b, c, d = truth
    w, x, y, z = (Fraction(float(part)) for part in quaternion)
    sine = math.hypot(
        float(a * x - b * w - c * z + d * y), float(a * y + b * z - c * w - d * x), float(a * z - b * y + c * x - d * w)
    )
    return 2.0 * math.atan2(sine, float(a * w + b * x + c * y + d * z))
