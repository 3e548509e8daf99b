"""What theory says of coupled steps: two masses on a line, and between them a spring and a damper in a unit of its own.

The oscillator of M. Busch, *Zur effizienten Kopplung von Simulationsprogrammen* (Kassel, 2012): masses m1, m2 (kg), a
spring k (N/m) and a damper c (N s/m), steps of H (s). A mass moves exactly under a force linear in time over the step,
as RigidBody does; the joint has no states, its force f = k r + c dr/dt is that of the motion it is shown. Both masses
feel the same force at any time, so their centre moves uniformly whatever the master does, and all else is the distance
r, that of one reduced mass m = m1 m2 / (m1 + m2):

    r1  = r + H v - H^2/m (f0/3 + f1/6)         f0, f1: the force that the masses feel at both ends of the step
    v1  = v - H/m (f0 + f1)/2

`MATRICES` are this step with what a master holds. One mass may be infinite: the other then hangs on a wall. All raise
ValueError for what is no oscillator: masses, k and H must be above 0, c not below.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from .search import largest

Array = NDArray[np.float64]
Complexes = NDArray[np.complex128]

MARGIN = 1e-12
"""Of a growth factor, for round-off: errors that grow do so by 1e-9 a step and more in the range that is looked at."""


def reduced_mass(m1: float, m2: float) -> float:
    """The mass (kg) that the distance of two masses moves with; either may be infinite."""
    if not (m1 > 0.0 and m2 > 0.0 and min(m1, m2) < math.inf):
        raise ValueError(f"m1 = {m1}, m2 = {m2} kg: allowed are masses above 0, at most one infinite")
    return 1.0 / (1.0 / m1 + 1.0 / m2)


def jacobi_order_0(m1: float, m2: float, k: float, c: float, H: float) -> Array:
    """Step [3, 3] of (r, v, f): masses feel the joint's last output, the joint is shown the motion before the step.

    The force felt is that of the motion one step ago, held: in the mean it is 3/2 H late.
    """
    drift, start, end, spring = _parts(m1, m2, k, c, H)
    return np.block([[drift, start + end], [spring, 0.0]])


def jacobi_order_1(m1: float, m2: float, k: float, c: float, H: float) -> Array:
    """Step [5, 5] of (r, v, f, f before, g): all inputs go on along the line through their last two values.

    f is the joint's output, for the motion extrapolated to the end of the step, g = k r + c v that of the true motion
    a step before: f1 = 2 (k r + c v) - g.
    """
    drift, start, end, spring = _parts(m1, m2, k, c, H)
    motion = np.hstack([drift, start + 2 * end, -end, np.zeros((2, 1))])
    return np.vstack([motion, [*2 * spring[0], 0, 0, -1], [0, 0, 1, 0, 0], [*spring[0], 0, 0, 0]])


def gauss_seidel_order_0(m1: float, m2: float, k: float, c: float, H: float) -> Array:
    """Step [2, 2] of (r, v): masses first, under the joint's last force; then the joint is shown their motion."""
    drift, start, end, spring = _parts(m1, m2, k, c, H)
    return drift + (start + end) @ spring


def gauss_seidel_order_1(m1: float, m2: float, k: float, c: float, H: float) -> Array:
    """Step [3, 3] of (r, v, f before): masses first, under a force along the line through its last two values."""
    drift, start, end, spring = _parts(m1, m2, k, c, H)
    return np.block([[drift + (start + 2 * end) @ spring, -end], [spring, 0.0]])


def converged(m1: float, m2: float, k: float, c: float, H: float) -> Array:
    """Step [2, 2] of (r, v): the force is linear in time and fits the motion at both ends.

    What `iterated` and `newton` arrive at. It is Newmark's method of linear acceleration (J. Eng. Mech. Div. 85 (1959)
    67): without damper it keeps areas, and is stable up to H = sqrt(12 m / k).
    """
    drift, start, end, spring = _parts(m1, m2, k, c, H)
    return np.linalg.solve(np.eye(2) - end @ spring, drift + start @ spring)


MATRICES: dict[str, Callable[[float, float, float, float, float], Array]] = {
    "jacobi_order_0": jacobi_order_0,
    "jacobi_order_1": jacobi_order_1,
    "gauss_seidel_order_0": gauss_seidel_order_0,
    "gauss_seidel_order_1": gauss_seidel_order_1,
    "converged": converged,
}
"""The step of each master. `iterated` is `converged` as long as `iteration_gain` is below 1."""

FORCE_ERRORS: dict[str, tuple[int, float]] = {
    "jacobi_order_0": (1, -3 / 2),
    "jacobi_order_1": (2, -17 / 12),
    "gauss_seidel_order_0": (1, -1 / 2),
    "gauss_seidel_order_1": (2, -5 / 12),
    "converged": (2, 1 / 12),
}
"""Order p and factor e: in the mean over a step the masses feel f + e H^p times the p-th derivative of f.

A held value is H/2 late, one that is a step older 3/2 H; a line through the last two values misses 5/12 H^2 of the
curvature, the joint shown extrapolated motion H^2 more; a line between both ends has 1/12 too much.
"""

UNDAMPED_GROWTH: dict[str, tuple[int, float]] = {
    "jacobi_order_0": (1, 3 / 4),
    "jacobi_order_1": (3, 2 / 3),
    "gauss_seidel_order_0": (1, 1 / 4),
    "gauss_seidel_order_1": (3, 1 / 6),
    "converged": (1, 0.0),
}
"""Power p and factor g: without damper errors grow at g w (w H)^p (1/s) to the leading order, w = sqrt(k / m)."""


def growth(master: str, m1: float, m2: float, k: float, c: float, H: float) -> float:
    """Rate (1/s) at which the largest error grows, or dies out if negative: log of the spectral radius over H."""
    return math.log(spectral_radius(MATRICES[master](m1, m2, k, c, H))) / H


def spectral_radius(matrix: Array) -> float:
    """Largest absolute value of an eigenvalue."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def stable_step(
    master: str, m1: float, m2: float, k: float, c: float, allowed: float = 0.0, ratio: float = 1.001
) -> float:
    """Largest step (s), within `ratio`, at which errors grow by no more than `allowed` (1/s); 0 where there is none.

    Without damper every master but `converged` lets errors grow at any step: log(100) / 2 s, say, asks for a motion
    bounded over two seconds.
    """

    def holds(H: float) -> bool:
        return growth(master, m1, m2, k, c, H) <= allowed + MARGIN / H

    swing = math.sqrt(reduced_mass(m1, m2) / k)
    # below this, growth without a damper, some (H / swing)^4 a step, is lost in round-off
    least = min(_times(m1, m2, k, c)) * (1e-6 if allowed else 1e-2)
    # no master stands more than sqrt(12) times the swing
    return largest(holds, least, 10 * swing, ratio)


def true_rates(m1: float, m2: float, k: float, c: float) -> Complexes:
    """Eigenvalues [2] (1/s) of the motion itself: roots of m s^2 + c s + k."""
    m = reduced_mass(m1, m2)
    return np.roots([m, c, k]).astype(complex)


def rates(master: str, m1: float, m2: float, k: float, c: float, H: float) -> Complexes:
    """For each of `true_rates` [2] (1/s) the one that the coupled step has in its place.

    log(mu) / H, where mu is the eigenvalue nearest to the true factor exp(rate H): below half a turn a
    step, where a frequency can be told.
    """
    factors = np.linalg.eigvals(MATRICES[master](m1, m2, k, c, H)).astype(complex)
    true = true_rates(m1, m2, k, c)
    # a factor of zero has died out at once: the least number stands for it
    found = np.array([factors[np.argmin(np.abs(factors - factor))] or math.ulp(0.0) for factor in np.exp(true * H)])
    return np.log(found) / H


def rate_error(master: str, m1: float, m2: float, k: float, c: float, H: float) -> float:
    """How wrong frequency and damping of the coupled motion are: the larger |rate - true rate| / |true rate|."""
    true = true_rates(m1, m2, k, c)
    return float(np.max(np.abs(rates(master, m1, m2, k, c, H) - true) / np.abs(true)))


def accurate_step(
    master: str, m1: float, m2: float, k: float, c: float, bound: float = 0.01, ratio: float = 1.001
) -> float:
    """Largest step (s), within `ratio`, up to which the motion is stable and `rate_error` at most `bound`."""
    true = true_rates(m1, m2, k, c)
    fastest = float(np.abs(true).max())

    def holds(H: float) -> bool:
        stable = growth(master, m1, m2, k, c, H) <= bound * fastest
        return stable and rate_error(master, m1, m2, k, c, H) <= bound

    return largest(holds, 1e-6 * min(_times(m1, m2, k, c)), math.pi / fastest, ratio)


def effective_joint(master: str, m1: float, m2: float, k: float, c: float, H: float) -> tuple[float, float]:
    """Spring (N/m) and damper (N s/m) that the masses seem to have between them, to the leading order in H.

    The force errs by e H^p f^(p) (`FORCE_ERRORS`), and f^(p) follows from r and v along the true motion. For a delay of
    d = 3/2 H or 1/2 H, order 0, the damper is c - d (k - c^2/m) and the spring k (1 + d c/m). A damper below zero
    drives the motion, so jacobi of order 0 needs c > 3/2 H k; somewhat above, it is stable with the damping wrong.
    """
    order, factor = FORCE_ERRORS[master]
    m = reduced_mass(m1, m2)
    motion = np.array([[0.0, 1.0], [-k / m, -c / m]])
    force = np.array([k, c])
    spring, damper = force + factor * H**order * force @ np.linalg.matrix_power(motion, order)
    return float(spring), float(damper)


def iteration_gain(m1: float, m2: float, k: float, c: float, H: float) -> float:
    """By how much one pass of fixed-point iteration multiplies the error of the force at the step's end, sign apart.

    The force at the end moves r by -H^2 / (6 m) and v by -H / (2 m) of it, so the gain is k H^2/(6 m) + c H/(2 m), with
    the sign -. Where all units are passed through at once, each with what the others gave before, it takes two passes.
    """
    m = reduced_mass(m1, m2)
    return k * H**2 / (6 * m) + c * H / (2 * m)


def iteration_step(m1: float, m2: float, k: float, c: float) -> float:
    """Step (s) up to which fixed-point iteration converges: gain 1. Without damper sqrt(6 m / k)."""
    m = reduced_mass(m1, m2)
    # the positive root of k H^2 + 3 c H = 6 m, without cancellation
    return 12 * m / (3 * c + math.sqrt(9 * c**2 + 24 * k * m))


def relaxed_gain(gains: Sequence[float], factor: float) -> float:
    """By how much one pass multiplies the error if only `factor` of each change is taken; for `gains` as those of
    `iteration_gain`, one for each direction: the largest |1 - factor (1 + gain)|."""
    return float(np.abs(1 - factor * (1 + np.asarray(gains))).max())


def best_relaxation(gains: Sequence[float]) -> tuple[float, float]:
    """The factor that makes `relaxed_gain` least, 2 / (2 + least + greatest gain), and what it is then.

    Richardson's iteration: Saad, *Iterative Methods for Sparse Linear Systems*, example 4.1. With one gain it is 0: one
    pass with 1 / (1 + gain) is Newton's step.
    """
    least, most = min(gains), max(gains)
    return 2 / (2 + least + most), (most - least) / (2 + least + most)


def _parts(m1: float, m2: float, k: float, c: float, H: float) -> tuple[Array, Array, Array, Array]:
    """Free flight [2, 2], what the force at the start and at the end of a step do [2, 1], and the joint [1, 2]."""
    m = reduced_mass(m1, m2)
    if not (0.0 < k < math.inf and 0.0 <= c < math.inf and 0.0 < H < math.inf):
        raise ValueError(f"k = {k} N/m, c = {c} N s/m, H = {H} s: allowed are k and H above 0, c not below 0")
    return (
        np.array([[1.0, H], [0.0, 1.0]]),
        np.array([[-(H**2) / (3 * m)], [-H / (2 * m)]]),
        np.array([[-(H**2) / (6 * m)], [-H / (2 * m)]]),
        np.array([[k, c]]),
    )


def _times(m1: float, m2: float, k: float, c: float) -> list[float]:
    """The times (s) that matter: of the swing, and with a damper m / c and c / k."""
    m = reduced_mass(m1, m2)
    return [math.sqrt(m / k), *([m / c, c / k] if c else [])]
