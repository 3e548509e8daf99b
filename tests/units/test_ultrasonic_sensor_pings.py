"""UltrasonicSensor: what it hears and what it does not, and when its pings start and end."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import kstest

from ulna import Slave, UnitError

OUTPUTS = ("distance", "device_distance", "time_of_flight", "echo_width", "valid", "sequence", "level")
EXACT = {"resolution": 0.0, "threshold": -150.0}  # no rounding, everything audible
WALL = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]}
BALL = {"sphere_center": [1.0, 0.0, 0.0], "sphere_radius": 0.1}
NANOSECOND = 1e-9


def started(version: str = "3.0", start: float = 0.0, **values: object) -> Slave:
    """A sensor with these parameters and inputs, initialized at `start` [s]."""
    sensor = Slave("UltrasonicSensor", version=version)
    for name, value in values.items():
        sensor.set(name, value)
    sensor.initialize(start=start)
    return sensor


def outputs(sensor: Slave) -> dict[str, float | int | bool]:
    """All outputs by name."""
    return {name: sensor.get(name) for name in OUTPUTS}


def ping(**values: object) -> dict[str, float | int | bool]:
    """Outputs after the first ping."""
    with started(**values) as sensor:
        sensor.step(0.0, 0.05)
        return outputs(sensor)


def about_z(angle: float) -> list[float]:
    """The quaternion that turns by `angle` [rad] about +z."""
    return [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]


# What is heard


def assert_no_echo(seen: dict) -> None:
    assert not seen["valid"]
    assert seen["sequence"] == 1
    assert seen["distance"] == 4.0  # maximum_range
    assert seen["level"] == -200.0


def test_without_targets_there_is_no_echo_and_the_ping_ends_at_the_time_out():
    with started(**EXACT) as sensor:
        time_out = 2 * np.hypot(4.0, 0.013) / sensor.get("speed_of_sound")
        sensor.step(0.0, time_out - NANOSECOND)
        assert sensor.get("sequence") == 0
        sensor.step(time_out - NANOSECOND, 2 * NANOSECOND)
        assert_no_echo(outputs(sensor))
        assert sensor.get("echo_width") == pytest.approx(time_out, rel=1e-14)  # round-off of four operations


UNHEARD = {
    "sphere behind": BALL | {"sphere_center": [-1.0, 0.0, 0.0]},
    "capsule behind": {"capsule_1_start": [-1, -1, 0], "capsule_1_end": [-1, 1, 0], "capsule_1_radius": 0.1},
    "plane behind": {"plane_point": [-1.0, 0.0, 0.0], "plane_normal": [1.0, 0.0, 0.0]},
    "plane behind and facing away": {"plane_point": [-1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]},
    "plane facing away": {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [1.0, 0.0, 0.0]},
    "sphere around the sensor": {"sphere_center": [0.1, 0.0, 0.0], "sphere_radius": 1.0},
    "sphere around the sensor, centre behind": {"sphere_center": [-0.1, 0.0, 0.0], "sphere_radius": 1.0},
    "plane between transmitter and receiver": {"plane_point": [0.0, -0.005, 0.0], "plane_normal": [-0.3, 1.0, 0.0]},
    "capsule around the sensor": {"capsule_2_start": [0, 0, 0], "capsule_2_end": [1, 0, 0], "capsule_2_radius": 0.1},
    "after the time-out": {"plane_point": [4.0001, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]},
    "no radius": BALL | {"sphere_radius": 0.0},
    "no normal": WALL | {"plane_normal": [0.0, 0.0, 0.0]},
}


@pytest.mark.parametrize("fidelity", ["ray", "specular"])
@pytest.mark.parametrize("case", UNHEARD)
def test_is_not_heard(case, fidelity):
    assert_no_echo(ping(fidelity=fidelity, **EXACT, **UNHEARD[case]))


def test_a_wall_in_the_blind_zone_is_nothing_to_a_ray_and_read_at_its_edge_by_a_comparator():
    wall = {"plane_point": [0.0199, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]}
    assert_no_echo(ping(fidelity="ray", **EXACT, **wall))
    seen = ping(**EXACT, **wall)
    assert seen["distance"] == pytest.approx(0.0199, rel=1e-14)
    with started() as sensor:
        way = 2 * np.hypot(0.02, 0.013)
        assert seen["echo_width"] == pytest.approx(way / sensor.get("speed_of_sound"), rel=1e-14)


def test_ball_behind_a_wall_is_hidden():
    tilted = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 1.2]}
    behind = BALL | {"sphere_center": [1.6, 0.0, 0.0]}
    assert ping(threshold=-36.0, **behind)["valid"]
    assert not ping(threshold=-36.0, **behind, **tilted)["valid"]


@pytest.mark.parametrize("fidelity", ["ray", "specular"])
def test_a_wall_seen_from_behind_hides_nothing(fidelity):
    averted = {"plane_point": [2.0, 0.0, 0.0], "plane_normal": [1.0, 0.0, 0.0]}
    assert ping(fidelity=fidelity, **BALL, **averted) == ping(fidelity=fidelity, **BALL)
    assert ping(fidelity=fidelity, **BALL)["valid"]


@pytest.mark.parametrize("fidelity", ["ray", "specular"])
def test_the_nearest_of_several_targets_is_reported(fidelity):
    near, far = (
        {"capsule_2_start": [x, -0.2, 0.0], "capsule_2_end": [x, 0.2, 0.0], "capsule_2_radius": 0.04}
        for x in (0.74, 0.98)
    )
    # 1.3e-4: from a ball the baseline looks shorter than from a wall, by less than b^2 / (8 d)
    assert ping(fidelity=fidelity, **EXACT, **WALL, **BALL, **near)["distance"] == pytest.approx(0.7, abs=1.3e-4)
    assert ping(fidelity=fidelity, **EXACT, **WALL, **BALL, **far)["distance"] == pytest.approx(0.9, abs=1.3e-4)
    assert ping(fidelity=fidelity, **EXACT, **WALL)["distance"] == pytest.approx(1.0, rel=1e-14)


def test_an_echo_below_the_threshold_gives_way_to_a_later_one_above():
    pole = {"capsule_1_start": [0.5, 0.3, -1.0], "capsule_1_end": [0.5, 0.3, 1.0], "capsule_1_radius": 0.005}
    weak, strong = ping(**EXACT, **pole), ping(**EXACT, **WALL)
    assert weak["time_of_flight"] < strong["time_of_flight"]
    between = 0.5 * (weak["level"] + strong["level"])
    both = ping(**EXACT | {"threshold": between}, **pole, **WALL)
    assert both["time_of_flight"] == strong["time_of_flight"]
    just_below, just_above = (ping(threshold=weak["level"] + step, **pole) for step in (-1e-9, 1e-9))
    assert just_below["valid"]
    assert not just_above["valid"]


def test_a_ray_misses_a_sphere_beside_the_axis_that_sound_finds():
    ball = BALL | {"sphere_center": [1.0, 0.12, 0.0]}
    assert not ping(fidelity="ray", **ball)["valid"]
    assert ping(fidelity="specular", **ball)["valid"]


def test_a_ray_sees_a_tilted_plate_whose_echo_goes_elsewhere():
    plate = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-np.cos(0.9), np.sin(0.9), 0.0]}  # 52 degrees
    assert ping(fidelity="ray", **plate)["valid"]
    assert not ping(fidelity="specular", **plate)["valid"]


def test_a_ray_reads_a_tilted_plate_too_far():
    angle = np.radians(20.0)
    plate = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-np.cos(angle), 0.0, np.sin(angle)]}
    ray, sound = (ping(fidelity=f, **EXACT, **plate)["distance"] for f in ("ray", "specular"))
    assert ray == pytest.approx(1.0, rel=1e-14)
    assert sound == pytest.approx(np.cos(angle), rel=1e-4)  # the perpendicular; the tilted baseline adds b^2/8


RAY_DISTANCES = {
    "sphere off centre": (BALL | {"sphere_center": [1.0, 0.06, 0.0]}, 1.0 - 0.08),
    "cylinder across": (
        {"capsule_1_start": [1.0, -1.0, 0.06], "capsule_1_end": [1.0, 1.0, 0.06], "capsule_1_radius": 0.1},
        1.0 - 0.08,
    ),
    "cylinder at 45 degrees": (
        {"capsule_1_start": [0.0, -1.0, 0.0], "capsule_1_end": [2.0, 1.0, 0.0], "capsule_1_radius": 0.1},
        1.0 - 0.1 * np.sqrt(2.0),
    ),
    "cap, along the capsule": (
        {"capsule_2_start": [2.0, 0.06, 0.0], "capsule_2_end": [1.0, 0.06, 0.0], "capsule_2_radius": 0.1},
        1.0 - 0.08,
    ),
    "cap, above the end": (
        {"capsule_2_start": [1.0, 0.06, 0.0], "capsule_2_end": [1.0, 2.0, 0.0], "capsule_2_radius": 0.1},
        1.0 - 0.08,
    ),
}


@pytest.mark.parametrize("case", RAY_DISTANCES)
def test_a_ray_measures_along_the_axis(case):
    targets, distance = RAY_DISTANCES[case]
    seen = ping(fidelity="ray", **EXACT, **targets)
    assert seen["distance"] == pytest.approx(distance, rel=1e-13)  # round-off; the root loses two digits


@pytest.mark.parametrize("fidelity", ["ray", "specular"])
def test_turning_and_moving_everything_changes_nothing(fidelity):
    turn, shift = 0.8, np.array([3.0, -2.0, 1.0])

    def moved(v):
        c, s = np.cos(turn), np.sin(turn)
        return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])

    center = np.array([1.0, 0.05, 0.02])
    velocity = np.array([-2.0, 1.0, 0.5])
    here = ping(fidelity=fidelity, **EXACT, sphere_center=center, sphere_velocity=velocity, sphere_radius=0.1)
    there = ping(
        fidelity=fidelity,
        **EXACT,
        position=shift,
        orientation=about_z(turn),
        sphere_center=moved(center) + shift,
        sphere_velocity=moved(velocity),
        sphere_radius=0.1,
    )
    for name in ("distance", "echo_width", "level"):
        assert there[name] == pytest.approx(here[name], rel=1e-13)  # coordinates of 4 m hold 4e-16 m


def test_distance_is_rounded_to_the_resolution():
    wall = WALL | {"plane_point": [1.0007, 0.0, 0.0]}
    assert ping(**wall)["distance"] == pytest.approx(1.002, rel=1e-14)  # 3 mm by default
    assert ping(**wall, resolution=0.01)["distance"] == pytest.approx(1.0, rel=1e-14)


# When pings start and end

DURATION = 1.0  # s


def steps_of(size: float | None) -> list[float]:
    """Communication points from 0 to DURATION; None for steps of all sizes."""
    if size is not None:
        return list(np.append(np.arange(0.0, DURATION - 1e-9, size), DURATION))
    inner = np.sort(np.random.default_rng(5).uniform(0.0, DURATION, 60))
    return [0.0, *inner, DURATION]


BALL_VELOCITY = np.array([-0.9, 0.4, 0.0])  # m/s
SENSOR_VELOCITY = np.array([0.1, -0.05, 0.2])  # m/s


def history(points: list[float], motion: bool, **values: object) -> dict[int, tuple]:
    """The outputs of each ping that was seen, by its number, with inputs set at the start of every step."""
    seen = {}
    moving = {"sphere_radius": 0.1, "sphere_velocity": BALL_VELOCITY, "velocity": SENSOR_VELOCITY}
    with started(period=0.0137, **EXACT, **(moving if motion else BALL), **values) as sensor:
        for time, after in pairwise(points):
            if motion:
                sensor.set("sphere_center", np.array([1.5, -0.2, 0.05]) + time * BALL_VELOCITY)
                sensor.set("position", time * SENSOR_VELOCITY)
            sensor.step(time, after - time)
            result = outputs(sensor)
            seen[result["sequence"]] = tuple(result.values())
    return seen


@pytest.mark.parametrize("size", [0.007, 0.1, None])
def test_pings_are_identical_at_any_communication_step(size):
    fine, coarse = (history(steps_of(s), motion=False, noise=0.002) for s in (0.001, size))
    assert len(fine) > 70
    assert len(coarse) > 8
    assert all(coarse[number] == fine[number] for number in coarse)


@pytest.mark.parametrize("size", [0.007, 0.1, None])
def test_pings_to_a_moving_ball_are_the_same_at_any_communication_step(size):
    fine, coarse = (history(steps_of(s), motion=True) for s in (0.001, size))
    assert max(fine) == max(coarse)
    for number in coarse:
        # 1e-13: position and extrapolation round differently, 2e-16 m in 1 m, and time by 1e-16 s
        assert coarse[number] == pytest.approx(fine[number], rel=1e-13)


@pytest.mark.parametrize("start", [0.0, 12.5])
def test_periodic_pings_end_a_flight_after_start_plus_k_periods(start):
    period, pings = 0.06, 50
    width = ping(**EXACT, **WALL)["echo_width"]
    with started(start=start, period=period, **EXACT, **WALL) as sensor:
        now = start
        for k in range(pings):
            end = start + k * period + width
            sensor.step(now, end - NANOSECOND - now)
            assert sensor.get("sequence") == k
            sensor.step(end - NANOSECOND, 2 * NANOSECOND)
            assert sensor.get("sequence") == k + 1
            now = end + NANOSECOND


def test_periodic_pings_that_fall_into_a_flight_are_lost():
    with started(period=0.01, **EXACT) as sensor:  # no target: each flight takes 23.3 ms, so one of three
        sensor.step(0.0, 0.295)
        assert sensor.get("sequence") == 10


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_saved_in_flight_and_restored_it_goes_on_the_same_to_the_bit(version):
    def rest(sensor):
        rows = []
        for k in range(20):
            sensor.step(0.062 + 0.01 * k, 0.01)
            rows.append(tuple(outputs(sensor).values()))
        return rows

    values = {"noise": 0.003, "sphere_velocity": [-0.5, 0.1, 0.0], **BALL}
    with started(version, **values) as sensor, started(version, **values) as other:
        sensor.step(0.0, 0.062)  # 2 ms after the emission of the second ping
        state, data = sensor.save(), sensor.serialize()
        first = rest(sensor)
        sensor.restore(state)
        assert rest(sensor) == first
        other.deserialize(data)
        assert rest(other) == first
        assert len(set(first)) > 3


# Noise


def noisy_distances(seed: int, pings: int = 2000) -> np.ndarray:
    """Distances [m] of a wall at 1 m, noise 5 mm, one per ping."""
    with started(period=0.01, resolution=0.0, noise=0.005, seed=seed, **WALL) as sensor:
        rows = []
        for k in range(pings):
            sensor.step(0.01 * k, 0.01)
            rows.append(sensor.get("distance"))
        return np.array(rows)


def test_noise_is_normal_with_the_given_deviation():
    errors = (noisy_distances(seed=3) - 1.0) / 0.005
    assert abs(errors.mean()) < 4 / np.sqrt(errors.size)
    assert abs(errors.std() - 1.0) < 4 / np.sqrt(2 * errors.size)
    assert kstest(errors, "norm").pvalue > 1e-4
    assert abs(np.corrcoef(errors[1:], errors[:-1])[0, 1]) < 4 / np.sqrt(errors.size)


def test_noise_follows_from_the_seed_alone():
    first, again, other = noisy_distances(7, 300), noisy_distances(7, 300), noisy_distances(8, 300)
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first, other)[0, 1]) < 4 / np.sqrt(300)


def test_noise_leaves_the_echo_width_exact():
    assert ping(noise=0.05, **WALL)["echo_width"] == ping(noise=0.0, **WALL)["echo_width"]


# What is refused


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("period", {"period": 0.0005}),
        ("minimum_range", {"minimum_range": 4.0}),
        ("speed of sound", {"sphere_velocity": [0.0, 400.0, 0.0]}),
        ("speed of sound", {"velocity": [-400.0, 0.0, 0.0]}),
    ],
)
def test_senseless_values_are_refused_by_name(name, values):
    with pytest.raises(UnitError, match=name):
        ping(**values)
