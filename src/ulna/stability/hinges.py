"""Two HingedBody units in a plane, a forearm on the tip of an upper arm, through acceleration and reaction.

Each depends on the other directly: an algebraic loop, at the start and in every step. What the masters make of it.
"""

import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..charts.arms import FOREARM, GRAVITY, UPPER_ARM
from ..coupling import CouplingError
from ..results import Results
from ..scene import Scene
from ..settling import PASSES

Array = NDArray[np.float64]

LENGTH = UPPER_ARM["tip"][0] - UPPER_ARM["base"][0]
CENTER = -UPPER_ARM["base"][0]
UPPER_MOMENT = UPPER_ARM["inertia"][1] + UPPER_ARM["mass"] * CENTER**2
FELT = UPPER_MOMENT / LENGTH**2
"""kg: the mass that the forearm feels at the tip of the upper arm, across it. Mass ratios are over this."""
LEVER = -FOREARM["base"][0]
SLENDERNESS = math.sqrt(FOREARM["inertia"][1] / FOREARM["mass"]) / LEVER
TORQUE = 0.2  # N m, at the elbow, where there is nothing else
SHOULDER, RATES = -0.8, (1.5, 1.5)  # rad, rad/s, where there is weight and motion
INSTANT, JUMP = 1e-9, 20
"""Steps so short that nothing moves but what passes through the loop, and how many."""
ROUND_OFF = 1e-9
"""Of the first change: a pass that changes less says nothing of the gain."""


def pendulum(ratio: float) -> tuple[Array, Array]:
    """Of the arm with a forearm of this mass ratio: moments [2] (kg m2) about shoulder and elbow with what they
    carry, and the first moments [2] (kg m) that weight acts on; all about the joint before."""
    mass = ratio * FELT
    forearm = mass * LEVER**2 * (1 + SLENDERNESS**2)
    return (
        np.array([UPPER_MOMENT + mass * LENGTH**2, forearm]),
        np.array([UPPER_ARM["mass"] * CENTER + mass * LENGTH, mass * LEVER]),
    )


def accelerations(ratio: float, angles: Array, rates: Array, torque: float = 0.0, gravity: float = 0.0) -> Array:
    """Angular accelerations [..., 2] (rad/s2) of the rigid double pendulum, angles and rates to the world.

    `torque` (N m) is that of the elbow. Landau and Lifshitz, *Mechanics*, 5, problem 1, with moments of inertia.
    """
    (first, second), (own, carried) = pendulum(ratio)
    elbow = angles[..., 1] - angles[..., 0]
    joined, pull = carried * LENGTH * np.cos(elbow), carried * LENGTH * np.sin(elbow)
    one = pull * rates[..., 1] ** 2 - own * gravity * np.cos(angles[..., 0]) - torque
    other = -pull * rates[..., 0] ** 2 - carried * gravity * np.cos(angles[..., 1]) + torque
    size = first * second - joined**2
    return np.stack([second * one - joined * other, first * other - joined * one], axis=-1) / size[..., None]


def run(
    master: str, ratio: float, elbow: float, *, steps: int = 0, H: float = 1e-3, moving: bool = True
) -> tuple[Results, bool]:
    """A run of `steps` of H (s), and whether the initial values settled; raises CouplingError if a step does not.

    If not `moving` the arm starts level, at rest and without weight, with TORQUE at the elbow, which changes its sign
    after the first step.
    """
    shoulder, rates = (SHOULDER, RATES) if moving else (0.0, (0.0, 0.0))
    with Scene("hinges") as scene:
        upper = scene.add("HingedBody", "upper", **_hinged(UPPER_ARM, 1.0, shoulder, rates[0], moving))
        scale = ratio * FELT / FOREARM["mass"]
        forearm = scene.add("HingedBody", "forearm", **_hinged(FOREARM, scale, elbow, rates[1], moving))
        scene.connect(upper.tip, forearm.anchor)
        scene.record(upper.angle, upper.rate, upper.tip_angular_acceleration)
        scene.record(forearm.angle, forearm.rate, forearm.tip_angular_acceleration)
        if not moving:
            scene.signal(forearm.torque, lambda time: TORQUE if time < 0.5 * H else -TORQUE)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            results = scene.run(steps * H, H, master=master)
    return results, not any("do not settle" in str(w.message) for w in caught)


def _hinged(body: dict[str, Any], scale: float, angle: float, rate: float, weighs: bool) -> dict[str, Any]:
    return {
        "mass": scale * body["mass"],
        "inertia": scale * np.array(body["inertia"]),
        "center_of_mass": np.negative(body["base"]),
        "tip": np.subtract(body["tip"], body["base"]),
        "gravity": GRAVITY if weighs else (0.0, 0.0, 0.0),
        "initial_angle": angle,
        "initial_rate": rate,
        "stiffness": 0.0,
        "damping": 0.0,
        "solver": "rk4",
    }


def measured_gain(ratio: float, elbow: float) -> tuple[float, bool]:
    """By how much a pass of gauss_seidel multiplies the error, sign apart, and whether the initial values settled.

    Where they settled, from the steps after the elbow's torque has changed its sign; and else from the error that is
    left of the first one after all passes.
    """
    results, settled = run("gauss_seidel", ratio, elbow, H=INSTANT, moving=False)
    if settled:
        results, _ = run("gauss_seidel", ratio, elbow, steps=JUMP, H=INSTANT, moving=False)
        changes = np.abs(np.diff(results["upper.tip_angular_acceleration"][1:, 1]))
        changes = changes[changes > ROUND_OFF * changes[0]]
        return float((changes[-1] / changes[0]) ** (1 / (len(changes) - 1))), settled
    true = accelerations(ratio, np.array([0.0, elbow]), np.zeros(2), TORQUE)[0]
    # the first pass finds no torque yet, and no acceleration: that is off by all of the true one
    found = -results["upper.tip_angular_acceleration"][0, 1]
    return float(abs(found / true - 1) ** (1 / (PASSES - 1))), settled


def solution_error(master: str, ratio: float, elbow: float, steps: int = 5, H: float = 1e-3) -> float:
    """Largest error of the angular accelerations, over the largest one, with the angles and rates of each row.

    The first row is that of the initial values. Infinite where the loop does not settle.
    """
    try:
        results, settled = run(master, ratio, elbow, steps=steps, H=H)
    except CouplingError:
        return math.inf
    if not settled:
        return math.inf
    angles, rates = (
        np.cumsum([results[f"{unit}.{what}"] for unit in ("upper", "forearm")], axis=0).T for what in ("angle", "rate")
    )
    expected = accelerations(ratio, angles, rates, gravity=-GRAVITY[2])
    found = -np.stack([results[f"{unit}.tip_angular_acceleration"][:, 1] for unit in ("upper", "forearm")], axis=1)
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def border(elbow: float, ratio: float = 1.01) -> float:
    """Mass ratio, within `ratio`, up to which passes of gauss_seidel settle: there the measured gain is 1."""
    low, high = 0.01, 1000.0
    while high > ratio * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if measured_gain(middle, elbow)[0] < 1.0 else (low, middle)
    return math.sqrt(low * high)
