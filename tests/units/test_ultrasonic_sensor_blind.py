"""UltrasonicSensor: what rings when its comparator opens."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from ultrasonic_sensor_read import BASELINE, FREQUENCY, RING_TIME, default_device, ping, width
from ultrasonic_sensor_truth import Agreement, Device, image_source, rigid_sphere

ROUND_OFF = 1e-14  # relative


@pytest.fixture(scope="module")
def device() -> Device:
    """The truth's picture of the default sensor."""
    return default_device()


def test_what_still_rings_when_the_comparator_opens_is_heard_then():
    """A lone facing wall, 1 - (1+t) exp(-t) less the same from the burst's end: found where it falls below by Brent."""
    wall = {"plane_point": [0.05, 0, 0], "plane_normal": [-1, 0, 0], "baseline": 0.0}
    alone = ping(**wall, minimum_range=0.0)
    opening_of = 2 / alone["speed_of_sound"]
    length, peak = 8 / FREQUENCY / RING_TIME, 10 ** ((-36.0 - alone["level"]) / 20)

    def envelope(t):
        return (1 + t - length) * np.exp(length - t) - (1 + t) * np.exp(-t)

    loudest = length / -np.expm1(-length)
    falls = brentq(lambda t: envelope(t) - peak * envelope(loudest), loudest, 30.0, xtol=1e-13)
    border = (alone["time_of_flight"] + falls * RING_TIME) / opening_of
    for reach in (0.06, 0.1, border * (1 - 1e-9)):
        seen = ping(**wall, minimum_range=reach)
        assert seen["valid"]
        assert seen["echo_width"] == pytest.approx(reach * opening_of, rel=ROUND_OFF)
        assert seen["time_of_flight"] == alone["time_of_flight"]  # it is that echo, not a nearer one
    assert not ping(**wall, minimum_range=border * (1 + 1e-9))["valid"]
    # opened before the echo passes, it hears it pass
    assert ping(**wall, minimum_range=0.049)["echo_width"] == alone["echo_width"]


def test_what_comes_before_the_opening_adds_up_with_what_comes_after(device):
    rng, agreement, at_opening = np.random.default_rng(8), Agreement(), 0
    for _ in range(120):
        reach, tilt = rng.uniform(0.03, 0.3), np.radians(rng.uniform(0, 30))
        normal = -np.array([np.cos(tilt), 0.0, np.sin(tilt)])
        point, center, radius = -rng.uniform(0.03, 1.1) * reach * normal, rng.uniform(0.1, 0.5), rng.uniform(0.02, 0.06)
        opening = 2 * np.hypot(reach, BASELINE / 2) / device.speed
        truth = replace(device, minimum_time=opening, threshold=rng.uniform(-30.0, 10.0))
        # a wall that is all around is soft, so that the ball before or behind it counts
        spectrum = 0.3 * image_source(truth, point, normal)
        plate = {"plane_point": point, "plane_normal": normal, "plane_reflection": 0.3}
        if np.dot([center + radius, 0, 0] - point, normal) > 2 * radius:
            spectrum = spectrum + rigid_sphere(truth, np.array([center + radius, 0, 0]), radius)
            plate |= {"sphere_center": [center + radius, 0, 0], "sphere_radius": radius}
        read, true = width(**plate, minimum_range=reach, threshold=truth.threshold), truth.heard(spectrum)
        agreement.see(read, true, device.speed)
        at_opening += true == opening
    assert 20 < at_opening < 100
    # as for walls and spheres alone
    assert agreement.percentile(95) < 0.3e-3
    assert agreement.detection >= 0.99


@pytest.mark.parametrize("reach", [0.1, 0.1524])
def test_a_receiver_that_hears_its_transmitter_rings_down_at_the_opening(device, reach):
    """A direct burst falls below the threshold in time if its spectrum does: the border by bisection of the truth."""
    opening = 2 * np.hypot(reach, BASELINE / 2) / device.speed
    truth = replace(device, minimum_time=opening)
    direct = np.exp(-1j * device.wave_numbers * BASELINE)
    low, high = -36.0, 100.0
    while high - low > 1e-3:
        middle = (low + high) / 2
        low, high = (low, middle) if np.isfinite(truth.heard(10 ** (middle / 20) * direct)) else (middle, high)
    # .1 dB: the truth's spectrum ends 25 kHz off the carrier, 1e-4 of the peak, where the ringing is 1e-2 of it
    assert not ping(minimum_range=reach, coupling=low - 0.1)["valid"]
    seen = ping(minimum_range=reach, coupling=high + 0.1)
    assert seen["valid"]
    assert seen["distance"] == pytest.approx(0.0, abs=1e-8 * BASELINE)  # the root of a rounding
    assert seen["time_of_flight"] == pytest.approx(BASELINE / device.speed, rel=ROUND_OFF)
    assert seen["echo_width"] == pytest.approx(opening, rel=ROUND_OFF)


def test_a_receiver_hears_its_transmitter_and_an_echo_together(device):
    direct = 0.05 * np.exp(-1j * device.wave_numbers * BASELINE)
    agreement = Agreement()
    for distance in np.linspace(0.04, 0.3, 60):
        point, normal = np.array([distance, 0, 0]), np.array([-1.0, 0, 0])
        truth = replace(device, minimum_time=0.9e-3, threshold=0.0)
        values = {"minimum_range": np.sqrt((0.9e-3 * device.speed) ** 2 - BASELINE**2) / 2, "threshold": 0.0}
        read = width(plane_point=point, plane_normal=normal, coupling=20 * np.log10(0.05), **values)
        agreement.see(read, truth.heard(direct + image_source(truth, point, normal)), device.speed)
    assert agreement.percentile(95) < 0.05e-3  # as for walls alone, half of them
    assert agreement.detection == 1.0
