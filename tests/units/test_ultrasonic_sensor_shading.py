"""UltrasonicSensor: what bodies leave of the echoes behind and beside them."""

import numpy as np
import pytest
from scipy.special import h1vp, hankel1, jvp
from ultrasonic_sensor_read import FREQUENCY, default_device, ping

SILENT = {"capsule_reflection": 0.0, "box_reflection": 0.0, "sphere_reflection": 0.0}  # they shade, but do not echo
QUIET = {"threshold": -150.0, "baseline": 0.0, "resolution": 0.0}
WALL = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]}


@pytest.fixture(scope="module")
def wave_number() -> float:
    """Of 40 kHz, 1/m."""
    return 2 * np.pi * FREQUENCY / default_device().speed


def left(body: dict, behind: dict = WALL) -> float:
    """Decibels that a silent body leaves of an echo."""
    return ping(**behind, **body, **SILENT | QUIET)["level"] - ping(**behind, **QUIET)["level"]


def pole(x: float, z: float, radius: float, number: int = 1) -> dict:
    """A long pole across the way, at [x, any, z]."""
    names = (f"capsule_{number}_start", f"capsule_{number}_end", f"capsule_{number}_radius")
    return dict(zip(names, ([x, -3.0, z], [x, 3.0, z], radius), strict=True))


def behind_rigid_cylinder(k: float, radius: float, source: np.ndarray, receiver: np.ndarray) -> complex:
    """Field of a line source near a rigid cylinder about the origin, in shares of that without it; [2] in m.

    Partial waves: H0(k |r - s|) + sum over n of -J_n'(ka)/H_n'(ka) H_n(ks) H_n(kr) exp(i n phi); Bowman, Senior and
    Uslenghi, 2.2.
    """
    order = np.arange(int(k * radius + 6 * (k * radius) ** (1 / 3) + 12))
    near, far = np.linalg.norm(source), np.linalg.norm(receiver)
    angle = np.arctan2(source[1], source[0]) - np.arctan2(receiver[1], receiver[0])
    share = jvp(order, k * radius) / h1vp(order, k * radius)
    waves = share * hankel1(order, k * near) * hankel1(order, k * far) * np.cos(order * angle)
    free = hankel1(0, k * np.linalg.norm(source - receiver))
    return 1 - (waves[0] + 2 * waves[1:].sum()) / free


@pytest.mark.parametrize("radius", [0.02, 0.04, 0.08])
@pytest.mark.parametrize("place", [0.3, 0.5, 0.8])
def test_a_pole_shades_a_wall_as_a_rigid_cylinder_would(wave_number, place, radius):
    k = wave_number
    # what creeps round a skin and a screen does not know, for each edge: Pekeris' function, .307 at grazing for a rigid
    # one (Pathak, Radio Science 14 (1979) 419); two edges, there and back
    creeping = 4 * 0.307 * np.cbrt(k * radius / 2) * np.sqrt(2 / k * (1 / place + 1 / (2 - place)))
    for z in np.linspace(0.0, 0.15, 16):
        # both ways in line with the wall's image: past the pole, and past its image
        there = behind_rigid_cylinder(k, radius, np.array([-place, -z]), np.array([2 - place, -z]))
        assert 10 ** (left(pole(place, z, radius)) / 20) == pytest.approx(abs(there) ** 2, abs=creeping)


def fresnel_screen(k: float, screen: np.ndarray, distances: tuple[float, float]) -> complex:
    """Share of a point source's field beyond an opaque rectangle, by summing over the plane outside of it.

    `screen` [2, 2] m: lower and upper edge in both directions, from the line of sight.
    """
    bend = k * (1 / distances[0] + 1 / distances[1]) / 2
    parts = []
    for lower, upper in screen:
        s = np.linspace(lower, upper, 40001)
        wave = np.exp(1j * bend * s**2)
        step = s[1] - s[0]
        parts.append(step * (wave.sum() - (wave[0] + wave[-1]) / 2))
    return 1 - parts[0] * parts[1] * bend / (1j * np.pi)


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.05, 0.0), (0.0, -0.1), (0.06, 0.08), (0.09, 0.0)])
def test_a_thin_box_shades_a_wall_as_a_screen_does(wave_number, offset):
    place, size = 0.5, np.array([0.15, 0.2])
    screen = np.stack([np.array(offset) - size / 2, np.array(offset) + size / 2], axis=1)
    there = fresnel_screen(wave_number, screen, (place, 2 - place))
    box = {"box_center": [place, *offset], "box_size": [1e-4, *size]}
    # the sum's steps of 5 um, 3e-4 of a wave there, and the rational functions' 3e-7
    assert left(box) == pytest.approx(40 * np.log10(abs(there)), abs=0.01)


def test_a_shadow_begins_at_the_edge_with_six_decibels_a_way():
    """By Fresnel's integral half of the amplitude passes the edge of a half plane: 12 dB there and back."""
    box = {"box_center": [0.5, 0.0, 5.0], "box_size": [1e-4, 10.0, 10.0]}
    # its other three edges, 5 and 10 m off, pass .225 / u each, u = 125 and more
    assert left(box) == pytest.approx(40 * np.log10(0.5), abs=0.1)
    assert left(box | {"box_center": [0.5, 0.0, 4.8]}) < -40
    assert left(box | {"box_center": [0.5, 0.0, 5.2]}) == 0.0


def test_what_is_behind_or_far_beside_shades_nothing():
    ball = {"sphere_center": [1.0, 0.0, 0.0], "sphere_radius": 0.1}
    alone = ping(**ball, **QUIET)
    for body in (pole(1.4, 0.0, 0.05), pole(-0.2, 0.0, 0.05), pole(0.5, 0.4, 0.05), pole(0.5, -0.4, 0.05)):
        assert ping(**ball, **body, **QUIET | {"capsule_reflection": 0.0}) == alone


def test_a_ball_behind_a_box_is_not_heard():
    ball = {"sphere_center": [1.0, 0.0, 0.0], "sphere_radius": 0.05}
    box = {"box_center": [0.5, 0.0, 0.0], "box_size": [0.1, 0.6, 0.6], "box_reflection": 0.0}
    assert ping(**ball)["valid"]
    assert not ping(**ball, **box)["valid"]
    assert ping(**ball, **box | {"box_center": [0.5, 0.6, 0.0]})["valid"]


def test_a_moving_ball_shades_where_it_is_when_the_sound_passes():
    fast = {"sphere_center": [0.5, 0.0, 0.0], "sphere_radius": 0.1}
    there, back = 0.5 / default_device().speed, 1.5 / default_device().speed
    velocity = np.array([0.0, 0.0, 100.0])
    away = left(fast | {"sphere_center": -velocity * there + [0.5, 0, 0], "sphere_velocity": velocity})
    still = left(fast)
    beside = left(fast | {"sphere_center": velocity * (back - there) + [0.5, 0, 0]})
    # in the way on the way there, 29 cm aside on the way back
    assert away == pytest.approx(still / 2 + beside / 2, abs=0.01)
    assert beside == 0.0


def test_an_elbow_is_heard_once():
    """Two capsules that share a ball: where that answers, they are one body."""
    bend = {"capsule_1_start": [1.6, 0.6, 0.0], "capsule_1_end": [1.0, 0.0, 0.0], "capsule_1_radius": 0.05}
    other = {"capsule_2_start": [1.0, 0.0, 0.0], "capsule_2_end": [1.6, -0.6, 0.0], "capsule_2_radius": 0.05}
    one, both = ping(**bend, **QUIET), ping(**bend, **other, **QUIET)
    assert both["time_of_flight"] == pytest.approx(one["time_of_flight"], rel=1e-14)
    assert both["level"] == pytest.approx(one["level"], abs=1e-9)
    just_above = {"threshold": one["level"] + 0.1}
    assert not ping(**bend, **other, **QUIET | just_above)["valid"]


def test_the_ground_mirrors_shadows_too():
    """A pole in the way of the sound that comes by the ground, which is straight from the sensor's image."""
    floor = {"plane_point": [0, 0, -1.5], "plane_normal": [0, 0, 1.0], "multipath": True, "minimum_range": 2.3}
    pitched = {"orientation": [np.cos(0.275), 0.0, np.sin(0.275), 0.0], "threshold": -100.0, "baseline": 0.0}
    scene = floor | pitched | {"sphere_center": [1.5, 0.0, 0.1], "sphere_radius": 0.06}
    open_way = ping(**scene)
    assert open_way["valid"]
    # by the ground at about half way: the sound passes [.37, 0, -.75] down and [1.1, 0, -.75] up
    for x, z in ((0.37, -0.75), (1.13, -0.72)):
        shaded = ping(**scene, **pole(x, z, 0.08), capsule_reflection=0.0)
        assert shaded["level"] < open_way["level"] - 6.0
    assert ping(**scene, **pole(0.37, -1.4, 0.02), capsule_reflection=0.0)["level"] == open_way["level"]
