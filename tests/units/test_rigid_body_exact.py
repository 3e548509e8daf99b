"""RigidBody's solver `exact` without torque, against the same motion to 40 digits."""

import math
from functools import cache

import numpy as np
import pytest
from rigid_body_free_truth import DIGITS_40, angle_between, free_attitudes
from test_rigid_body import rotation, start

from ulna import Slave

EPSILON = np.finfo(float).eps
ALIGNED = [1.0, 0.0, 0.0, 0.0]
TURNED = [0.8, 0.1, 0.6, -0.3]
TIMES = [0.001, 1.0, 33.3, 100.0]

# Moments of inertia (kg m2) and body rates (rad/s) at the start.
MOTIONS = {
    "asymmetric": ([1, 2, 3], [0.6, 1, 0.4]),
    "axes in another order": ([3, 1, 2], [-0.4, 0.6, -1]),
    "axes mirrored": ([2, 1, 3], [-1, -0.6, 0.4]),
    "Dzhanibekov": ([1, 2, 3], [0.01, 1, 0.01]),
    "about the lowest axis": ([1, 2, 3], [1, 0.1, -0.1]),
    "about the highest axis": ([1, 2, 3], [0.1, 0.1, -1]),
    "off the middle axis by 1e-8": ([1, 2, 3], [1e-8, 1, 1e-8]),
    "off the middle axis by 1e-16": ([1, 2, 3], [1e-16, -1, 1e-16]),
    "on the lowest axis": ([1, 2, 3], [-1, 0, 0]),
    "on the middle axis": ([1, 2, 3], [0, 1, 0]),
    "on the highest axis": ([1, 2, 3], [0, 0, 1]),
    "spherical": ([2, 2, 2], [0.6, 1, 0.4]),
    "oblate": ([1, 1, 1.5], [0.6, 1, 0.4]),
    "prolate": ([1, 3, 3], [0.6, 1, -0.4]),
    "almost oblate": ([1, 1 + 1e-15, 1.5], [0.6, 1, 0.4]),
    "almost prolate": ([1, 3, 3 - 1e-8], [0.6, 1, -0.4]),
    "almost spherical": ([1, 1 + 1e-8, 1 + 2e-8], [0.6, 1, 0.4]),
    "about an axis across that of symmetry": ([0.5, 0.5, 0.9], [0.36, 1.4, 0]),
    "about an axis across that of almost symmetry": ([1, 1 + 1e-9, 1.5], [0.6, 0.8, 1e-9]),
    "separatrix": ([3, 4, 6], [0.25, 0.5, 0.125]),
    "separatrix, downwards": ([3, 4, 6], [-0.25, 0.5, 0.125]),
    "above the separatrix by 1e-13": ([3, 4, 6], [0.25, 0.5, 0.125 * (1 + 1e-13)]),
    "below the separatrix by 1e-6": ([3, 4, 6], [0.25, 0.5, 0.125 * (1 - 1e-6)]),
    "largest nome of the direct form": ([1, 2, 3], [0.1, 1, 0.118]),
    "the same, almost oblate": ([1, 1.05, 2], [0.1, 1, 0.033]),
    "largest nome of the complementary form": ([1, 2, 3], [0.1, 1, 0.115]),
    "needle, 1 to 1e6": ([1, 1e6, 0.9999999e6], [0.3, 1e-3, 2e-3]),
    "rod without width, 1e-6 to 1": ([1e-6, 1, 1 - 5e-7], [0.3, 0.1, 0.2]),
    "slow": ([1, 2, 3], [6e-9, 1e-8, 4e-9]),
    "at rest": ([1, 2, 3], [0, 0, 0]),
}


def free_body(inertia: list, rate: list, orientation: list = ALIGNED) -> Slave:
    """A body with the solver `exact` and these body rates (rad/s) at the start."""
    world_rate = rate if orientation is ALIGNED else rotation(np.array(orientation)) @ rate
    parameters = {"inertia": inertia, "initial_angular_velocity": world_rate, "initial_orientation": orientation}
    return start(parameters | {"gravity": [0, 0, 0], "solver": "exact"})


def errors(body: Slave, inertia: list, times: list[float], momentum: np.ndarray | None = None) -> list[float]:
    """Angles (rad) between the body after one step to each of the times, and the exact motion from its own start."""
    orientation, own = body.get("orientation"), body.get("angular_momentum")
    truth = free_attitudes(inertia, orientation, own if momentum is None else momentum, times)
    at_start, found = body.save(), []
    for time, attitude in zip(times, truth, strict=True):
        body.restore(at_start)
        body.step(0.0, time)
        found.append(angle_between(attitude, body.get("orientation")))
    body.restore(at_start)
    return found


def round_off(rate: list, time: float) -> float:
    """Angle (rad) that rounding may cost: two phases grow with time, each from a rate that is a product of some eight
    rounded factors; the quaternion itself takes as many operations again."""
    return 8.0 * EPSILON * (1.0 + math.hypot(*rate) * time)


@pytest.mark.parametrize("motion", MOTIONS)
def test_every_kind_of_free_motion_is_exact_to_round_off_over_100_s(motion):
    inertia, rate = MOTIONS[motion]
    with free_body(inertia, rate) as body:
        for time, error in zip(TIMES, errors(body, inertia, TIMES), strict=True):
            assert error < round_off(rate, time), f"after {time} s"


@cache
def attitude_to_40_digits(inertia: tuple, orientation: tuple, momentum: tuple, time: float) -> list:
    """Attitude w, x, y, z at `time` (s)."""
    return free_attitudes(inertia, orientation, momentum, [time], DIGITS_40)[0]


@pytest.mark.parametrize("step", [0.001, 0.1, 10.0])
@pytest.mark.parametrize(("motion", "bound"), [("Dzhanibekov", 1e-12), ("asymmetric", 4e-14)])
def test_the_communication_step_costs_no_digits(motion, bound, step):
    inertia, rate = MOTIONS[motion]
    with free_body(inertia, rate) as body:
        states = (tuple(body.get(name)) for name in ("orientation", "angular_momentum"))
        truth = attitude_to_40_digits(tuple(inertia), *states, 100.0)
        for i in range(round(100.0 / step)):
            body.step(i * step, step)
        assert angle_between(truth, body.get("orientation")) < bound


def test_a_turned_start_loses_what_the_last_digit_of_the_momentum_is_worth():
    """L in the world has to be turned into body axes, which rounds it: near the separatrix a nudge grows as
    exp(lambda t). Two solutions from momenta one rounding apart say how much that is worth."""
    inertia, rate, times = [3, 4, 6], [0.25, 0.5, 0.125 * (1 + 1e-6)], [10.0, 100.0]
    axes = np.eye(3)
    with free_body(inertia, rate, TURNED) as body:
        momentum = body.get("angular_momentum")
        exact = errors(body, inertia, times)
        size = EPSILON * np.linalg.norm(momentum)
        nudged = [errors(body, inertia, times, momentum + sign * size * axis) for axis in axes for sign in (1, -1)]
    assert exact[1] > 100.0 * round_off(rate, 100.0)
    assert all(error < 2.0 * max(other) for error, *other in zip(exact, *nudged, strict=True))


def test_fast_spin_loses_digits_only_to_the_size_of_the_angle():
    inertia, rate, times = [1, 2, 3], [6e3, 1e4, 4e3], [1e-3, 1e-2, 2e-2]
    with free_body(inertia, rate) as body:
        for time, error in zip(times, errors(body, inertia, times), strict=True):
            assert error < round_off(rate, time)


@pytest.mark.parametrize("motion", ["asymmetric", "Dzhanibekov", "oblate", "separatrix"])
def test_energy_and_momentum_stay_for_a_million_seconds(motion):
    """The attitude's error then is a phase alone, along the motion: what the motion keeps does not see it."""
    inertia, rate = MOTIONS[motion]
    with free_body(inertia, rate, TURNED) as body:
        energy, momentum = body.get("kinetic_energy"), body.get("angular_momentum")
        for i in range(1, 101):
            body.step(1e4 * (i - 1), 1e4)
            # some ten roundings, once as large as the spread of the moments of inertia
            assert body.get("kinetic_energy") == pytest.approx(energy, rel=30.0 * EPSILON, abs=0.0)
            assert np.array_equal(body.get("angular_momentum"), momentum)


def test_a_quaternion_of_another_norm_starts_the_same_motion():
    inertia, rate = MOTIONS["asymmetric"]
    found = []
    for norm in (1.0, 1.5):
        with free_body(inertia, rate, [norm * part for part in TURNED]) as body:
            body.step(0.0, 10.0)
            found.append(body.get("orientation"))
    assert found[0] == pytest.approx(found[1], abs=round_off(rate, 10.0))
