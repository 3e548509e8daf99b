"""UltrasonicSensor: when the sum of echoes at rest passes the threshold, against its closed form at a million times."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import j1, jn
from ultrasonic_sensor_read import FREQUENCY, RING_TIME, ping

CARRIER = 2 * np.pi * FREQUENCY * RING_TIME  # radians a ring time
LENGTH = 8 / FREQUENCY / RING_TIME  # of the burst
PITCH = 1 / 2000  # ring times, .14 us
ALONE = {"baseline": 0.0, "threshold": -150.0}


def burst(times: np.ndarray, dispersion: float) -> np.ndarray:
    """Of two resonators in a row [n, complex] at `times` [n], ring times after the arrival; beams to first order."""
    value, slope = np.zeros_like(times), np.zeros_like(times)
    for begin, sign in ((0.0, 1.0), (LENGTH, -1.0)):
        since = np.maximum(times - begin, 0.0)
        value += sign * (1 - (1 + since) * np.exp(-since))
        slope += sign * since * np.exp(-since)
    return value - 1j * dispersion * slope


PEAK = np.abs(burst(np.arange(1.0, 2.0, 1e-5), 0.0)).max()


def sum_of(echoes: list[tuple[float, float, float]], times: np.ndarray) -> np.ndarray:
    """Envelope [n] at `times` [n, ring times]; each echo has its amplitude, arrival [ring times] and dispersion."""
    parts = [a * np.exp(-1j * CARRIER * arrival) * burst(times - arrival, d) for a, arrival, d in echoes]
    return np.abs(np.sum(parts, axis=0)) / PEAK


def beam_argument(sine: float, speed: float) -> float:
    """x = k a sine of a piston."""
    return 2 * np.pi * FREQUENCY / speed * 6.57e-3 * sine


def dispersion(sine: float, speed: float) -> float:
    """Of two beams, `sine` off their axes: -x J2(x) / J1(x) each, over the carrier's angle in a ring time."""
    x = beam_argument(sine, speed)
    return -2 * x * jn(2, x) / j1(x) / CARRIER if x else 0.0


@pytest.mark.parametrize("spread", [0.01, 0.06, 0.2])
def test_the_sum_passes_where_its_closed_form_first_does(spread):
    """A wall ahead and a ball out of its light, nearer or farther by up to `spread` [m]; to 5 ns, 1 um of the way."""
    rng, heard = np.random.default_rng(5), 0
    for _ in range(40):
        distance, off, radius = rng.uniform(0.5, 2.0), np.radians(rng.uniform(30, 38)), rng.uniform(0.02, 0.08)
        reach = distance + rng.uniform(-spread, spread)
        wall = {"plane_point": [distance, 0, 0], "plane_normal": [-1, 0, 0]}
        ball = {"sphere_center": (reach + radius) * np.array([np.cos(off), 0, np.sin(off)]), "sphere_radius": radius}
        if ball["sphere_center"][0] > distance:
            continue  # its mirror point may lie behind the wall
        wall["plane_reflection"] = 10 ** rng.uniform(-1.5, 0)
        alone = [ping(**ALONE, **body) for body in (wall, ball)]
        echoes = [
            (10 ** (seen["level"] / 20), seen["time_of_flight"] / RING_TIME, dispersion(sine, seen["speed_of_sound"]))
            for seen, sine in zip(alone, (0.0, np.sin(off)), strict=True)
        ]
        first = min(arrival for _, arrival, _ in echoes)
        times = first + np.arange(0.0, abs(echoes[0][1] - echoes[1][1]) + 3.0, PITCH)
        envelope = sum_of(echoes, times)
        # down to a hundred thousandth below the highest, which is passed for some microseconds
        threshold = envelope.max() * (1 - 10 ** rng.uniform(-5.0, -0.05) if rng.uniform() < 0.9 else 1.00001)
        seen = ping(baseline=0.0, threshold=20 * np.log10(threshold), **wall, **ball)
        above = np.flatnonzero(envelope >= threshold)
        assert seen["valid"] == bool(above.size)
        if above.size:
            k = above[0]
            passes = brentq(lambda t: sum_of(echoes, np.array([t]))[0] - threshold, times[k - 1], times[k])  # noqa: B023
            assert abs(seen["echo_width"] - RING_TIME * passes) < 5e-9
            heard += 1
    assert heard >= 10


@pytest.mark.parametrize("below", [0.3, 1e-2, 1e-3, 1e-4, 1e-5])
def test_off_the_axis_an_echo_just_above_the_threshold_passes_where_its_closed_form_does(below):
    """`below` its loudest, by share: the envelope is flat there, and the beam's dispersion counts; to 5 ns."""
    for off in np.radians([10.0, 25.0, 40.0]):
        ball = {"sphere_center": [np.cos(off), 0, np.sin(off)], "sphere_radius": 0.1}
        alone = ping(**ALONE, **ball)
        amplitude, arrival = 10 ** (alone["level"] / 20), alone["time_of_flight"] / RING_TIME
        echo = (amplitude, 0.0, dispersion(np.sin(off), alone["speed_of_sound"]))
        seen = ping(baseline=0.0, threshold=alone["level"] + 20 * np.log10(1 - below), **ball)
        times = np.arange(0.0, 1.6, PITCH)
        loud = np.argmax(sum_of([echo], times))
        height = amplitude * (1 - below)
        passes = brentq(lambda t: sum_of([echo], np.array([t]))[0] - height, 0.0, times[loud], xtol=1e-14)  # noqa: B023
        assert RING_TIME * abs(seen["echo_width"] / RING_TIME - arrival - passes) < 5e-9


@pytest.mark.parametrize("off", [45.0, 60.0])
def test_beyond_the_null_of_its_beam_a_burst_comes_with_its_phase_turned_over(off):
    """A ball's echo and a burst of another sensor that looks `off` degrees past this one, eight phases apart."""
    place, ball = np.array([0.5, 0.0, 0.3]), {"sphere_center": [1.0, 0.0, -0.1], "sphere_radius": 0.05}
    straight = np.arctan2(-place[2], -place[0]) - np.radians(off)  # away from the ball, which it does not light
    other = {"foreign_1_position": place, "foreign_1_axis": [np.cos(straight), 0.0, np.sin(straight)]}
    alone = ping(**ALONE, **ball)
    speed, way = alone["speed_of_sound"], np.linalg.norm(place)
    start = alone["time_of_flight"] - way / speed
    sines = place[2] / way, np.sin(np.radians(off))
    sign = np.sign(np.prod([j1(beam_argument(sine, speed)) for sine in sines]))
    assert sign == (1.0 if off < 53.0 else -1.0)
    spread = sum(dispersion(sine, speed) for sine in sines) / 2
    own = (10 ** (alone["level"] / 20), alone["time_of_flight"] / RING_TIME, dispersion(0.1 / np.hypot(1, 0.1), speed))
    apart = []
    for phase in np.arange(8) / 8:
        told = other | {"foreign_1_start": start + phase / FREQUENCY, "foreign_1_period": 0.06}
        burst = ping(**ALONE, **told)
        strength = 10 ** (burst["level"] / 20)
        assert burst["time_of_flight"] == pytest.approx(start + phase / FREQUENCY + way / speed, rel=1e-12)
        seen = ping(baseline=0.0, threshold=alone["level"] - 12.0, **ball, **told)
        times = own[1] + np.arange(-0.1, 2.5, PITCH)
        passes = {}
        for turn in (sign, -sign):
            echoes = [own, (turn * strength, burst["time_of_flight"] / RING_TIME, spread)]
            above = np.flatnonzero(sum_of(echoes, times) >= 10 ** ((alone["level"] - 12.0) / 20))
            passes[turn] = RING_TIME * times[above[0]] if above.size else np.inf
        # the dispersion of the unit's beam is a continued fraction, 1e-5 off, and the closed form is sampled
        assert seen["echo_width"] == pytest.approx(passes[sign], abs=RING_TIME * 2 * PITCH)
        apart.append(abs(passes[sign] - passes[-sign]))
    assert max(apart) > 1e-5  # where the phase turned over would be seen
