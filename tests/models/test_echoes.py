"""The wave theories of `models/ultrasonic_sensor` agree with each other where more than one of them holds."""

import numpy as np
import pytest

from ulna.checks.textbook import load_model

hearing, echoes, surfaces = (load_model(f"ultrasonic_sensor.{part}") for part in ("hearing", "echoes", "surfaces"))
EARS = hearing.Device(343.0, 1.0, maximum_time=0.024)
AHEAD = np.array([1.0, 0.0, 0.0])


def test_a_facing_plane_at_a_metre_is_the_scale() -> None:
    still = hearing.Device(343.0, baseline=0.0)
    spectrum = echoes.image_source(still, AHEAD, -AHEAD)
    np.testing.assert_allclose(np.abs(spectrum), 1.0, rtol=1e-12)
    # the spectrum ends 25 kHz off the carrier, where 5e-4 of the amplitude is left
    assert still.level(spectrum) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("center", [[0.6, 0.0, 0.0], [0.5, 0.2, -0.1]])
def test_the_sphere_by_kirchhoff_is_that_of_partial_waves(center) -> None:
    """A capsule of no length. With k a = 60 the creeping waves, which Kirchhoff leaves out, are below 1e-3."""
    center, radius = np.array(center), 0.08
    series = echoes.rigid_sphere(EARS, center, radius)
    integral = echoes.kirchhoff(EARS, *surfaces.capsule_surface(center, center + 1e-9 * AHEAD, radius, 0.0006))
    # the first correction to Kirchhoff is 1 / (2 k a) of the amplitude: .07 dB
    assert EARS.level(integral) == pytest.approx(EARS.level(series), abs=0.07)
    # the series takes the beam at the mirror point, the integral all over the first Fresnel zone, 4 cm wide
    assert abs(EARS.heard(integral) - EARS.heard(series)) * EARS.speed / 2 < 0.3e-3


def test_a_large_sphere_is_nearly_a_plane() -> None:
    """Spreading: r1 + r2 grows by r1 r2 trace: with radius a at distance d the amplitude is a / (a + d)."""
    wall = EARS.level(echoes.image_source(EARS, 0.3 * AHEAD, -AHEAD))
    for radius in (0.1, 0.2):
        ball = EARS.level(echoes.rigid_sphere(EARS, (0.3 + radius) * AHEAD, radius))
        # geometrical acoustics is off by 1 / (2 k a) of the amplitude, at most .06 dB
        assert ball - wall == pytest.approx(20 * np.log10(radius / (radius + 0.3)), abs=0.06)


def test_a_large_plate_by_kirchhoff_is_a_wall_with_an_edge() -> None:
    """The edge's echo comes late, and from beside the beam."""
    sides = np.array([0.0, 1.6, 0.0]), np.array([0.0, 0.0, 1.6])
    plate = surfaces.rectangle_surface(0.5 * AHEAD, -AHEAD, sides, 0.003)
    integral = echoes.kirchhoff(EARS, *plate)
    wall = echoes.image_source(EARS, 0.5 * AHEAD, -AHEAD)
    # its edges are heard 2.6 ms later, and aside of the beam
    assert EARS.level(integral) == pytest.approx(EARS.level(wall), abs=0.1)
    assert EARS.heard(integral) == pytest.approx(EARS.heard(wall), abs=0.05e-3 * 2 / EARS.speed)
