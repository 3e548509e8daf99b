"""UltrasonicSensor: its echoes against wave theory, and what becomes of them when they add up."""

from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from scipy.optimize import minimize
from test_ultrasonic_sensor import EAR, ROUND_OFF, sound_speed_of_mixture
from ultrasonic_sensor_read import FREQUENCY, RING_TIME, default_device, ping, pings, width
from ultrasonic_sensor_truth import (
    Agreement,
    Device,
    box_surface,
    capsule_surface,
    image_source,
    kirchhoff,
    rigid_sphere,
)

from ulna import UnitError

WALL = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]}


@pytest.fixture(scope="module")
def device() -> Device:
    """The truth's picture of the default sensor."""
    return default_device()


def direction(rng: np.random.Generator, widest: float) -> np.ndarray:
    """Up to `widest` degrees off the axis, to any side."""
    off, about = np.radians(rng.uniform(0, widest)), rng.uniform(0, 2 * np.pi)
    return np.array([np.cos(off), np.sin(off) * np.cos(about), np.sin(off) * np.sin(about)])


def compared(device: Device, poses: int, draw: Callable, truth: Callable) -> Agreement:
    """`draw` gives the unit's inputs and the arguments of `truth`, a spectrum."""
    rng, agreement = np.random.default_rng(11), Agreement()
    for _ in range(poses):
        values, arguments = draw(rng)
        agreement.see(width(**values), device.heard(truth(device, *arguments)), device.speed)
    assert len(agreement.errors) > poses / 4  # most are heard, else nothing is shown
    return agreement


# Against wave theory


@pytest.mark.parametrize("distance", [0.3, 1.0, 2.0, 3.9])
def test_a_facing_wall_is_heard_when_the_spectrum_of_its_echo_passes(device, distance):
    values = {"plane_point": [distance, 0, 0], "plane_normal": [-1, 0, 0]}
    true = device.heard(image_source(device, np.array([distance, 0, 0]), np.array([-1.0, 0, 0])))
    # 10 um: the truth's spectrum ends 25 kHz off the carrier, its ripple is 1e-4 of the envelope
    assert abs(width(**values) - true) * device.speed / 2 < 10e-6


def test_walls_agree_with_image_sources(device):
    def draw(rng):
        normal = -direction(rng, 40.0)
        point = -rng.uniform(0.1, 3.9) * normal
        return {"plane_point": point, "plane_normal": normal}, (point, normal)

    seen = compared(device, 150, draw, image_source)
    # the beam's bend over the burst, left out, is of order (x / 69)^2; 95 % of a row of tilts stay below what counts
    assert seen.percentile(50) < 0.05e-3
    assert seen.percentile(95) < 0.3e-3
    assert seen.detection == 1.0


def test_spheres_agree_with_the_series_of_partial_waves(device):
    def draw(rng):
        radius = rng.uniform(0.03, 0.2)
        center = (rng.uniform(0.15, 2.5) + radius) * direction(rng, 40.0)
        return {"sphere_center": center, "sphere_radius": radius}, (center, radius)

    seen = compared(device, 150, draw, rigid_sphere)
    assert seen.percentile(95) < 0.3e-3
    assert seen.detection >= 0.995


def forearm(rng: np.random.Generator) -> tuple[dict, tuple]:
    """A capsule of 25 cm and radius 4 cm anywhere before the sensor, in any attitude, clear of it by 5 cm."""
    while True:
        center, axis = rng.uniform(0.1, 2.0) * direction(rng, 30.0), rng.normal(size=3)
        half = 0.125 * axis / np.linalg.norm(axis)
        nearest = min(np.linalg.norm(center + share * half) for share in np.linspace(-1, 1, 21))
        if nearest > 0.09:
            start, end = center - half, center + half
            return {"capsule_1_start": start, "capsule_1_end": end, "capsule_1_radius": 0.04}, (start, end)


def test_forearms_agree_with_the_kirchhoff_integral(device):
    seen = compared(device, 200, forearm, lambda d, start, end: kirchhoff(d, *capsule_surface(start, end, 0.04)))
    assert seen.percentile(95) < 1e-3
    assert seen.detection >= 0.99


def end_on(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Start and end of a capsule of 50 cm and radius 4 cm, off the axis, whose wall goes over into its cap within a few
    degrees of the mirror point: there the beam rises along the wall on the one side and falls on the other.
    """
    towards = direction(rng, 35.0)
    aside = np.cross(towards, rng.normal(size=3))
    tilt = np.radians(rng.uniform(-6.0, 6.0))
    start = (rng.uniform(0.4, 1.2) + 0.04) * towards
    return start, start + 0.5 * (np.cos(tilt) * aside / np.linalg.norm(aside) + np.sin(tilt) * towards)


def test_an_end_off_the_axis_is_as_loud_as_the_kirchhoff_integral(device):
    rng, wave_number = np.random.default_rng(13), 2 * np.pi * FREQUENCY / device.speed
    # the next order of the stationary phase on the cap
    left_out = 1 / (2 * wave_number * 0.04)
    for _ in range(40):
        start, end = end_on(rng)
        seen = ping(capsule_1_start=start, capsule_1_end=end, capsule_1_radius=0.04, threshold=-150.0)
        true = device.level(kirchhoff(device, *capsule_surface(start, end, 0.04)))
        assert abs(10 ** ((seen["level"] - true) / 20) - 1) < left_out


def test_boxes_that_turn_a_face_agree_with_the_kirchhoff_integral(device):
    rng, heard, least = np.random.default_rng(11), 0, 10 ** (device.threshold / 20)
    for _ in range(120):
        axis, angle = rng.normal(size=3), np.radians(rng.uniform(0, 20.0))
        turn = np.append(np.cos(angle / 2), np.sin(angle / 2) * axis / np.linalg.norm(axis))
        size, center = rng.uniform(0.05, 0.3, 3), rng.uniform(0.35, 1.5) * direction(rng, 10.0)
        w, u = turn[0], turn[1:]
        axes = np.array([e + 2 * np.cross(u, np.cross(u, e) + w * e) for e in np.eye(3)])
        times, envelope = device.envelope(kirchhoff(device, *box_surface(center, axes, size, device.ears)))
        read = width(box_center=center, box_orientation=turn, box_size=size)
        nearest = np.linalg.norm(center) - 0.15
        # an edge's echo leaves out how the beam changes along the face: 1 / (k d) of the wall's, whose height is 1 / d
        left_out = 1 / (2 * np.pi * FREQUENCY / device.speed * nearest**2)
        before = (times >= device.minimum_time) & (times < min(read, device.maximum_time))
        assert envelope[before].max() < least + left_out
        if np.isfinite(read):
            heard += 1
            assert abs(np.interp(read, times, envelope) - least) < left_out
    assert heard > 60


# The sum


def test_an_echo_is_heard_when_lambert_says(device):
    """Before the burst ends, 1 - (1+t) exp(-t) = q: t = -1 - W_-1(-(1-q)/e); later by the other branch."""
    length = 8 / FREQUENCY / RING_TIME
    peak_time = length / -np.expm1(-length)
    peak = np.expm1(length) * np.exp(-peak_time)
    level = ping(**WALL, baseline=0.0)["level"]
    for margin in (0.0, 1e-6, 0.5, 2.0, 2.5, 3.0, 10.0, 40.0, 100.0):  # dB
        seen = ping(**WALL, baseline=0.0, threshold=level - margin)
        share = mpmath.mpf(10) ** (-margin / 20)
        late = peak_time - 1 - mpmath.lambertw(-share / mpmath.e, 0).real
        early = -1 - mpmath.lambertw(-(1 - peak * share) / mpmath.e, -1).real
        rise = float(early if late < length else late)
        # the margin is a difference of levels of 1e-14 dB: near the peak its root counts
        assert (seen["echo_width"] - seen["time_of_flight"]) / RING_TIME == pytest.approx(rise, abs=3e-7)


PEAK = np.expm1(8 / FREQUENCY / RING_TIME) * np.exp(-8 / FREQUENCY / RING_TIME / -np.expm1(-8 / FREQUENCY / RING_TIME))
SIDES = {1: 0.08, 2: -0.08}  # rad; so far apart that neither pole shades the other


def towers(gap: float, aside: float = 0.0) -> dict:
    """Two equal poles across, to both sides of `aside` rad off the axis, the second `gap` m farther."""
    poles = {}
    for number, place in ((1, 1.0), (2, 1.0 + gap)):
        x, z = place * np.cos(aside + SIDES[number]), place * np.sin(aside + SIDES[number])
        poles |= {f"capsule_{number}_start": [x, -1.0, z], f"capsule_{number}_end": [x, 1.0, z]}
        poles[f"capsule_{number}_radius"] = 0.02
    return poles


def test_two_equal_echoes_a_quarter_wavelength_apart_are_not_heard():
    alone = ping(**towers(0.0) | {"capsule_2_radius": 0.0})
    wavelength = alone["speed_of_sound"] / FREQUENCY
    just_heard = {"threshold": alone["level"] - 6.0}
    alone = ping(**just_heard, **towers(0.0) | {"capsule_2_radius": 0.0})
    assert alone["valid"]
    assert not ping(**just_heard, **towers(wavelength / 4))["valid"]
    assert ping(**just_heard, **towers(wavelength / 2))["echo_width"] < alone["echo_width"]


@pytest.mark.parametrize("aside", [0.0, np.radians(25.0)])
def test_a_sum_of_echoes_passes_when_the_sum_of_their_spectra_does(device, aside):
    rng = np.random.default_rng(3)
    carrier = device.offsets.size // 2
    beams = [device.beam(np.array([np.cos(aside + s), 0.0, np.sin(aside + s)])) ** 2 for s in SIDES.values()]
    beams = [beam / beam[carrier] for beam in beams]  # the carrier's is in the level
    turns = 2 * np.pi * device.offsets * RING_TIME
    near = np.abs(device.offsets) < 4000.0  # Hz, most of the burst
    second = [abs(np.polyfit(turns[near], beam[near].real, 4)[-3]) for beam in beams]
    heard = 0
    for gap in rng.uniform(0.0, 0.08, 40):
        both = towers(gap, aside)
        parts = [ping(threshold=-150.0, **both | {f"capsule_{n}_radius": 0.0}) for n in (2, 1)]
        threshold = max(part["level"] for part in parts) - rng.uniform(0.5, 15.0)
        spectrum = sum(
            10 ** (part["level"] / 20) * beam * np.exp(-2j * np.pi * device.frequencies * part["time_of_flight"])
            for part, beam in zip(parts, beams, strict=True)
        )
        truth = Device(device.speed, threshold=threshold, maximum_time=device.maximum_time)
        read = width(threshold=threshold, **both)
        times, envelope = truth.envelope(spectrum)
        least = 10 ** (threshold / 20)
        # what the beams' second order adds to the envelope, whose bend is at most that of an endless burst, 1 / PEAK
        # of its own; and what the truth leaves out beyond 25 kHz off the carrier
        levels = (part["level"] for part in parts)
        left_out = sum(10 ** (level / 20) * (order / PEAK + 5e-4) for level, order in zip(levels, second, strict=True))
        before = (times < read) & (times < truth.maximum_time)
        assert envelope[before].max() < least + left_out
        if np.isfinite(read):
            heard += 1
            assert abs(np.interp(read, times, envelope) - least) < left_out
    assert heard > 10


def test_the_late_echo_of_the_ping_before_is_taken_for_a_near_one():
    far = {"plane_point": [5.0, 0, 0], "plane_normal": [-1, 0, 0], "threshold": -50.0}
    arrival = ping(**far, maximum_range=6.0)["time_of_flight"]
    assert not pings(0.059, **far)["valid"]
    ghost = pings(0.059, **far, period=0.0235)
    assert ghost["valid"]
    assert ghost["time_of_flight"] == pytest.approx(arrival - 0.0235, rel=1e-12)  # a difference of times of 0.03 s


PITCHED = {"orientation": [np.cos(0.275), 0.0, np.sin(0.275), 0.0], "threshold": -100.0}  # 31.5 degrees down
BLIND = {"minimum_range": 2.3}  # m: behind the echo of a ball 1.44 m off, 117 dB below its peak by then


def test_a_ground_mirrors_the_echo_of_a_ball():
    floor = {"plane_point": [0, 0, -1.5], "plane_normal": [0, 0, 1.0], "plane_reflection": 0.5}
    center, radius = np.array([1.5, 0.02, 0.1]), 0.06
    ball = {"sphere_center": center, "sphere_radius": radius} | PITCHED
    direct = ping(**ball)
    assert ping(**ball, **floor, multipath=True)["time_of_flight"] == direct["time_of_flight"]
    assert not ping(**ball, **floor, **BLIND)["valid"]
    seen = ping(**ball, **floor, **BLIND, multipath=True)
    image = -EAR - np.array([0, 0, 3.0])

    def way(aim):
        normal = np.array([-1.0, aim[0], aim[1]])
        point = center + radius * normal / np.linalg.norm(normal)
        return np.linalg.norm(point - EAR) + np.linalg.norm(point - image)

    best = minimize(way, [0.0, 0.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-16})
    assert seen["time_of_flight"] == pytest.approx(best.fun / seen["speed_of_sound"], rel=ROUND_OFF)
    louder = ping(**ball, **floor | {"plane_reflection": 1.0}, **BLIND, multipath=True)
    assert louder["level"] - seen["level"] == pytest.approx(20 * np.log10(2.0), abs=1e-12)


def test_both_ways_by_the_ground_add_up():
    """With both ears in one place they are one way and its reverse, alike in time and level: 6 dB more than each."""
    floor = {"plane_point": [0, 0, -1.5], "plane_normal": [0, 0, 1.0], "multipath": True}
    ball = {"sphere_center": [1.5, 0.0, 0.1], "sphere_radius": 0.06, "baseline": 0.0} | PITCHED | BLIND
    level = ping(**ball, **floor)["level"]
    both = {"threshold": level + 20 * np.log10(2.0)}
    # the sum is sampled 64 times a ring time, its peak may fall between: 3e-4 dB; what the direct echo, 8 dB louder
    # than both, adds is 117 dB below its peak: 3e-5 dB
    assert ping(**ball | both | {"threshold": both["threshold"] - 1e-3}, **floor)["valid"]
    assert not ping(**ball | both | {"threshold": both["threshold"] + 1e-4}, **floor)["valid"]


# Device and parameters


@pytest.mark.parametrize(("celsius", "percent"), [(0.0, 4.0), (20.0, 0.25), (40.0, -3.4)])
def test_the_firmware_errs_with_the_temperature(celsius, percent):
    wall = WALL | {"plane_point": [2.0, 0.0, 0.0], "threshold": -150.0}
    seen = ping(**wall, temperature=celsius + 273.15)
    assert seen["distance"] == pytest.approx(2.0, rel=ROUND_OFF)
    assert seen["device_distance"] == pytest.approx(seen["echo_width"] * 0.01 / 58e-6, rel=ROUND_OFF)
    assert 100 * (seen["device_distance"] / 2.0 - 1) == pytest.approx(percent, abs=0.06)  # printed to a tenth


def test_a_weaker_echo_crosses_later_and_the_line_rises_late():
    near, far = (ping(**WALL | {"plane_point": [d, 0, 0]}) for d in (0.2, 3.9))
    assert far["echo_width"] - far["time_of_flight"] > near["echo_width"] - near["time_of_flight"] > 0
    late = ping(**WALL, echo_start=1e-4)
    assert ping(**WALL)["echo_width"] - late["echo_width"] == pytest.approx(1e-4, rel=1e-10)


def test_without_an_echo_the_line_falls_at_the_time_out():
    seen = ping(time_out=0.038)
    assert not seen["valid"]
    assert seen["echo_width"] == 0.038
    assert seen["device_distance"] == pytest.approx(6.552, abs=1e-3)  # 38 ms / 58 us a centimetre
    with pytest.raises(UnitError, match=r"time_out = 0\.01 s; allowed range"):
        ping(time_out=0.01)


@pytest.mark.parametrize(("target", "name"), [(WALL, "plane"), (towers(0.3), "capsule")])
def test_a_reflection_is_a_share_of_the_amplitude(target, name):
    full, half = (ping(**target, **{f"{name}_reflection": share}) for share in (1.0, 0.5))
    assert half["level"] - full["level"] == pytest.approx(20 * np.log10(0.5), abs=1e-12)
    assert not ping(**target, **{f"{name}_reflection": 0.0})["valid"]


@pytest.mark.parametrize("pressure", [70000.0, 85000.0, 105000.0])
@pytest.mark.parametrize("temperature", [273.15, 293.15, 303.15])
def test_speed_of_sound_under_pressure_is_that_of_gas_theory(pressure, temperature):
    seen = ping(pressure=pressure, temperature=temperature, humidity=0.6)
    # 0.6 at this pressure is as much water as 0.6 * 101325 / pressure at one atmosphere
    expected = sound_speed_of_mixture(temperature, 0.6 * 101325.0 / pressure)
    assert seen["speed_of_sound"] == pytest.approx(expected, rel=5e-4)  # the accuracy asked for


# Cone and box


def test_a_cone_reads_the_nearest_point_within():
    aside = np.radians(5.0)
    ball = {"sphere_center": [np.cos(aside), np.sin(aside), 0.0], "sphere_radius": 0.05}
    assert ping(fidelity="cone", **ball)["distance"] == pytest.approx(0.95, rel=ROUND_OFF)
    assert not ping(fidelity="ray", **ball)["valid"]
    outside = ball | {"sphere_center": [np.cos(4 * aside), np.sin(4 * aside), 0.0]}
    assert not ping(fidelity="cone", **outside)["valid"]
    tilt = np.radians(20.0)
    plate = {"plane_point": [1.0, 0, 0], "plane_normal": [-np.cos(tilt), 0, np.sin(tilt)]}
    expected = np.cos(tilt) / np.cos(tilt - np.radians(7.5))  # along the rim
    assert ping(fidelity="cone", **plate)["distance"] == pytest.approx(expected, rel=ROUND_OFF)


@pytest.mark.parametrize("fidelity", ["ray", "cone"])
def test_a_ray_meets_the_face_of_a_box(fidelity):
    box = {"box_center": [1.0, 0.0, 0.0], "box_size": [0.4, 0.2, 0.2]}
    assert ping(fidelity=fidelity, **box)["distance"] == pytest.approx(0.8, rel=ROUND_OFF)
    assert not ping(fidelity=fidelity, **box | {"box_center": [1.0, 1.0, 0.0]})["valid"]
    assert not ping(fidelity=fidelity, **box | {"box_center": [0.1, 0.0, 0.0]})["valid"]  # from within
    diagonal = [np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)]
    edge_on = {"box_center": [1.0, 0, 0], "box_size": [0.2, 0.2, 0.2], "box_orientation": diagonal}
    assert ping(fidelity=fidelity, **edge_on)["distance"] == pytest.approx(1 - 0.1 * np.sqrt(2), rel=1e-13)


def test_a_large_box_is_a_wall():
    box = {"box_center": [2.0, 0.0, 0.0], "box_size": [2.0, 50.0, 50.0]}
    wall, seen = ping(**WALL), ping(**box)
    assert seen["time_of_flight"] == pytest.approx(wall["time_of_flight"], rel=ROUND_OFF)
    assert seen["level"] == pytest.approx(wall["level"], abs=0.03)  # its edges, 25 m off: 2e-3 of the amplitude
