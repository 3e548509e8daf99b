"""UltrasonicSensor: where round bodies mirror the sound, however near: the quickest way that an optimiser finds."""

import numpy as np
import pytest
from scipy.optimize import NonlinearConstraint, minimize
from ultrasonic_sensor_read import ping

OPEN = {"minimum_range": 0.0, "threshold": -150.0, "sphere_reflection": 1.0, "capsule_reflection": 1.0}
FOUND = 1e-9  # m: the way is flat where it is shortest, and the optimiser's point is 1e-6 off at most


def arrival_time(offset: np.ndarray, velocity: np.ndarray, speed: float) -> float:
    """When sound reaches a point at `offset` that moves with `velocity`."""
    approach, margin = offset @ velocity, speed**2 - velocity @ velocity
    return (approach + np.sqrt(approach**2 + margin * (offset @ offset))) / margin


def quickest(start, end, radius, baseline, velocity, speed) -> tuple[float, np.ndarray, np.ndarray]:
    """Over a capsule, a convex body, the flight time is convex: its least one, where and the normal there.

    The point is written as that of the axis, a share from start to end, and what it is off.
    """
    ear = np.array([0.0, baseline / 2, 0.0])

    def way(unknown):
        point = start + unknown[0] * (end - start) + unknown[1:]
        leg = np.linalg.norm(point - ear)
        return leg + speed * arrival_time(velocity * leg / speed - ear - point, velocity, speed)

    within = NonlinearConstraint(lambda unknown: unknown[1:] @ unknown[1:] / radius**2, -np.inf, 1.0)
    bounds = [(0.0, 1.0)] + 3 * [(-radius, radius)]
    guesses = [np.r_[share, -0.9 * radius * center / np.linalg.norm(center)]
               for share in (0.0, 0.5, 1.0) for center in [start + share * (end - start)]]  # fmt: skip
    options = {"ftol": 1e-15, "maxiter": 500}
    best = min(
        (minimize(way, guess, method="SLSQP", bounds=bounds, constraints=within, options=options) for guess in guesses),
        key=lambda result: result.fun,
    )
    share, normal = best.x[0], best.x[1:] / np.linalg.norm(best.x[1:])
    # on the skin, which the optimiser keeps to 1e-7: along it the way is flat there
    off = radius * normal
    return way(np.r_[share, off]) / speed, start + share * (end - start) + off, normal


def near_capsule(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, float]:
    """Some millimetres to 30 cm before the sensor, of any length and attitude."""
    towards = rng.normal(size=3) * [0.1, 0.6, 0.6] + [1.0, 0.0, 0.0]
    radius, length = 10 ** rng.uniform(-2.0, 0.0), 10 ** rng.uniform(-2.0, 0.5)
    middle = (10 ** rng.uniform(-2.0, -0.5) + radius) * towards / np.linalg.norm(towards)
    axis = rng.normal(size=3)
    axis *= length / np.linalg.norm(axis)
    return middle - rng.uniform() * axis, middle + rng.uniform() * axis, radius


@pytest.mark.parametrize("motion", [0.0, 20.0])
@pytest.mark.parametrize("baseline", [0.026, 0.3])
def test_a_near_capsule_is_heard_by_the_quickest_way(baseline, motion):
    rng, speed, heard = np.random.default_rng(3), ping()["speed_of_sound"], 0
    for _ in range(60):
        start, end, radius = near_capsule(rng)
        velocity = motion * rng.normal(size=3)
        capsule = {"capsule_1_start": start, "capsule_1_end": end, "capsule_1_radius": radius}
        seen = ping(**OPEN, **capsule, baseline=baseline, velocity=velocity)
        time, point, normal = quickest(start, end, radius, baseline, velocity, speed)
        ears = [np.array([0.0, baseline / 2, 0.0]), np.array([0.0, -baseline / 2, 0.0]) + time * velocity]
        above = [normal @ (ear - point) for ear in ears]
        if min(*np.abs(above), abs(point[0])) < 1e-4:
            continue  # between heard and not, by less than the optimiser tells
        before = all((point - ear)[0] > 0 for ear in ears)
        assert seen["valid"] == (min(above) > 0 and before)
        if seen["valid"]:
            heard += 1
            assert seen["time_of_flight"] == pytest.approx(time, abs=FOUND / speed)
    assert heard > 20


def test_a_ball_around_the_transmitter_does_not_echo_by_way_of_the_ground():
    """What it sends stays within, though the image of the receiver sees the outside: the ground changes nothing."""
    ball = {"sphere_center": [-0.033, -0.005, 0.151], "sphere_radius": 0.185}
    ground = {"plane_point": [0.032, 0.035, -0.063], "plane_normal": [-0.40, -0.45, 0.80], "plane_reflection": 0.5}
    alone, mirrored = (ping(**OPEN, **ball, **ground, baseline=0.1, multipath=on) for on in (False, True))
    assert mirrored == alone
