"""What the theory of each method says; nothing here runs a unit.

Steps are without dimension: z = h sqrt(k/m) for a spring, the angle h |w| for a spin. A growth factor is the spectral
radius of one step: above 1 an error grows without end.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SPRING_LIMITS = {
    "explicit_euler": 0.0,
    "semi_implicit_euler": 2.0,
    "notes": 2.0,
    "midpoint": 2.0,
    "splitting": 2.0,
    "moser_veselov": 2.0,
    "rk4": math.sqrt(8),
    "taylor": math.inf,
    "exact": math.inf,
    "automatic": math.inf,
}
"""Largest z at which a spring inside the step stays bounded: Hairer and Wanner, Solving ODEs II, IV.2. Those that kick
by the torque before and after a free rotation are Stoermer-Verlet here; those that choose their steps have no limit."""


def growth_rate(inertia: Sequence[float], axis: int, spin: float) -> complex:
    """Rate (1/s) of a small error about a principal axis: real, it grows; imaginary, it circles.

    Euler's equations linearised, for principal moments kg m2 and a spin rad/s about `axis`, 0 to 2: about the middle
    one sqrt((I2 - I1) (I3 - I2) / (I1 I3)) |w|. Landau and Lifshitz, Mechanics, 37.
    """
    own, first, second = _own_and_others(inertia, axis)
    return np.sqrt(complex((own - first) * (second - own) / (first * second))) * abs(spin)


def euler_factors(inertia: Sequence[float], axis: int, angle: float) -> NDArray[np.complex128]:
    """Eigenvalues [2] of one step of the notes' rotation, and of explicit Euler's, about a principal axis.

    q + h/2 (0, w) q, made a unit again, turns about the old w by 2 atan(h|w|/2), so the momentum in the body turns
    about it the other way. About the axis I w = (I_a w, m_b, m_c) has the part (a_b m_b, a_c m_c) across w, with
    a_i = 1 - I_a / I_i, which turns; the rest stays. Exact at any step; their product, the determinant, is
    1 + (1 - cos) (2 a_b a_c - a_b - a_c): above 1 about the greatest moment, where the true spin is stable.
    """
    own, first, second = _own_and_others(inertia, axis)
    a, b = 1 - own / first, 1 - own / second
    turn = 2 * math.atan(angle / 2)
    c, s = math.cos(turn), math.sin(turn)
    return np.linalg.eigvals([[1 + (c - 1) * a, s * b], [-s * a, 1 + (c - 1) * b]])


def midpoint_factors(inertia: Sequence[float], axis: int, angle: float) -> NDArray[np.complex128]:
    """Eigenvalues [2] of one midpoint step about a principal axis: the Cayley transform of the true rate.

    (1 + h r/2) / (1 - h r/2) for the rates r and -r of `growth_rate`: on the unit circle at any step where the spin is
    stable, without end where h r = 2 about the middle axis.
    """
    half = growth_rate(inertia, axis, angle) / 2
    return np.array([(1 + half) / (1 - half), (1 - half) / (1 + half)])


def splitting_factors(inertia: Sequence[float], axis: int, angle: float) -> NDArray[np.complex128]:
    """Eigenvalues [2] of one step of the five rotations, h/2 x, h/2 y, h z, h/2 y, h/2 x, about a principal axis.

    Linearised, the spin's own part turns the momentum (m_b, m_c) across it by the angle, and each other part shears it.
    The determinant is 1: stable up to the step where the trace passes 2.
    """
    own, first, second = _own_and_others(inertia, axis)

    def part(which: int, share: float) -> Array:
        turn = share * angle
        if which == axis:
            return np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
        if which == (axis + 1) % 3:
            return np.array([[1.0, 0.0], [turn * own / first, 1.0]])
        return np.array([[1.0, -turn * own / second], [0.0, 1.0]])

    x, y, z = part(0, 0.5), part(1, 0.5), part(2, 1.0)
    return np.linalg.eigvals(x @ y @ z @ y @ x)


SPIN_FACTORS = {
    "explicit_euler": euler_factors,
    "notes": euler_factors,
    "midpoint": midpoint_factors,
    "splitting": splitting_factors,
}
"""Solvers whose map of a small error about a principal axis is known at any step."""


def euler_energy_limit(inertia: Sequence[float], rates: Array, steps: int, error: float) -> float:
    """Largest h|w| at which the notes' rotation gains at most `error` of the energy over `steps` steps.

    `rates` [n, 3], rad/s, are body rates w of the true motion, over which is averaged; |w| is that of the first. A turn
    of the momentum m = I w by h|w| about w leaves w . m and gains h^2/2 (m x w) . I^-1 (m x w) of energy.
    """
    moments = np.asarray(inertia)
    torque = np.cross(rates * moments, rates)
    gain = np.mean(np.sum(torque**2 / moments, axis=1)) / 2
    energy = rates[0] ** 2 @ moments / 2
    return math.sqrt(error * energy / (steps * gain)) * float(np.linalg.norm(rates[0]))


def held_force_factor(solver: str, z: float, sloped: bool = False) -> float:
    """Growth factor of a spring whose force -k x is held over the communication step, one internal step long.

    With `sloped` its slope -k v is given too. Solvers whose translation is exact under such a force:
    x1 = x + h v - z^2/2 x (- z^2/6 h v), h v1 = h v - z^2 x (- z^2/2 h v), whose determinants are 1 + z^2/2 and
    1 + z^4/12: held forces pump energy in at any step. The notes' solver takes v1 for x1, and is symplectic up to 2;
    both Euler solvers see no slope, since they look at the start of the step only.
    """
    drift = {"explicit_euler": [[1, 1], [-(z**2), 1]], "notes": [[1 - z**2, 1], [-(z**2), 1]]}
    exact = [[1 - z**2 / 2, 1], [-(z**2), 1]]
    if sloped:
        exact = [[1 - z**2 / 2, 1 - z**2 / 6], [-(z**2), 1 - z**2 / 2]]
    return float(np.abs(np.linalg.eigvals(drift.get(solver, exact))).max())


def held_sub_steps_factor(z: float, count: int) -> float:
    """Growth factor of a held spring under the notes' solver with `count` internal steps in each communication step.

    x1 = x + h v - z^2 (count + 1) / (2 count) x: only one internal step is symplectic.
    """
    share = (count + 1) / (2 * count)
    return float(np.abs(np.linalg.eigvals([[1 - share * z**2, 1], [-(z**2), 1]])).max())


def euler_norm_factor(angle: float) -> float:
    """Growth of |q| in one step q + h/2 (0, w) q that is not made a unit: the second part is at right angles to q."""
    return math.sqrt(1 + (angle / 2) ** 2)


def rk4_norm_factor(angle: float) -> float:
    """Growth of |q| in one step of the classical Runge-Kutta: |1 + i a + (i a)^2/2 + ...| with a = h|w|/2."""
    z = 0.5j * angle
    return abs(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)


def is_inertia(moments: Sequence[float]) -> bool:
    """Whether a mass distribution has these principal moments: none exceeds the other two together."""
    return bool(2 * max(moments) <= sum(moments) * (1 + 1e-12))


def _own_and_others(inertia: Sequence[float], axis: int) -> tuple[float, float, float]:
    return inertia[axis], inertia[(axis + 1) % 3], inertia[(axis + 2) % 3]
