"""UltrasonicSensor's `surface`: meshes against wave theory on the bodies that they stand for."""

from collections.abc import Callable

import numpy as np
import pytest
from test_ultrasonic_sensor_echo import direction, forearm
from ultrasonic_sensor_read import FREQUENCY, RING_TIME, default_device, ping
from ultrasonic_sensor_truth import (
    Agreement,
    Device,
    Mesh,
    capsule_mesh,
    capsule_surface,
    image_source,
    kirchhoff,
    plate_mesh,
    rectangle_surface,
    rigid_sphere,
)

WAVELENGTH = 343.987 / FREQUENCY  # m, in the default air
PEAK_TIME = 1.405 * RING_TIME  # s, of the burst: b / (1 - exp(-b)) for b = .7255
FOREARM = 0.04  # m, radius
FINE = 0.387  # wavelengths: no edge is longer than 1.03 of it, .4


@pytest.fixture(scope="module")
def device() -> Device:
    """The truth's picture of the default sensor."""
    return default_device()


def heard(mesh: Mesh, normals: bool = True, **values: object) -> tuple[float, float]:
    """Echo width [s] of the first ping, infinite without an echo, and level [dB]."""
    seen = ping(**mesh.inputs(normals), **{"fidelity": "surface"} | values)
    return (seen["echo_width"], seen["level"]) if seen["valid"] else (np.inf, np.nan)


def true_echo(device: Device, spectrum: np.ndarray) -> tuple[float, float]:
    """When it passes the threshold [s], and how loud it gets while a burst rises [dB]."""
    crossing = device.heard(spectrum)
    times, envelope = device.envelope(spectrum)
    rising = envelope[(times >= crossing) & (times <= crossing + PEAK_TIME)]
    return crossing, 20 * np.log10(rising.max()) if rising.size else np.nan


class Truth:
    """Poses of a body, with what wave theory says of each."""

    def __init__(self, device: Device, poses: int, draw: Callable, spectrum: Callable) -> None:
        """`draw` gives a pose from a generator, `spectrum` its echo."""
        rng = np.random.default_rng(11)
        self.device = device
        self.poses = [draw(rng) for _ in range(poses)]
        self.echoes = [true_echo(device, spectrum(device, *pose)) for pose in self.poses]

    def compared(self, mesh: Callable[..., Mesh], **values: object) -> tuple[Agreement, np.ndarray]:
        """Agreement of range and detection, and errors of the level [dB]."""
        agreement, levels = Agreement(), []
        for pose, (crossing, level) in zip(self.poses, self.echoes, strict=True):
            read, read_level = heard(mesh(*pose), **values)
            agreement.see(read, crossing, self.device.speed)
            levels.append(abs(read_level - level))
        assert len(agreement.errors) > len(self.poses) / 4  # most are heard, else nothing is shown
        return agreement, np.array(levels)[np.isfinite(levels)]


@pytest.fixture(scope="module")
def forearms(device) -> Truth:
    """A capsule of 25 cm anywhere before the sensor, in any attitude."""

    def draw(rng: np.random.Generator) -> tuple:
        return forearm(rng)[1]

    return Truth(device, 200, draw, lambda d, start, end: kirchhoff(d, *capsule_surface(start, end, FOREARM)))


@pytest.mark.parametrize("edge", [FINE, 0.8, 1.2])
def test_a_meshed_forearm_agrees_with_the_kirchhoff_integral(forearms, edge):
    """Longer edges than .4 wavelength are cut into parts on the surface that the normals say."""
    seen, levels = forearms.compared(lambda start, end: capsule_mesh(start, end, FOREARM, edge * WAVELENGTH))
    assert seen.percentile(50) < 0.05e-3
    # what is left: the beam to second order, where an echo is loud, near and far off the axis; the peaks of faint ones
    assert seen.percentile(95) < 0.35e-3
    assert np.percentile(levels, 95) < 0.25
    assert seen.detection >= 0.995


def test_flat_triangles_of_a_forearm_are_a_prism(forearms):
    """Without normals a mesh is what it is: its facets lie inside by e^2 / (12 R), .02 mm, and faint echoes tell."""
    fine, levels = forearms.compared(lambda a, b: capsule_mesh(a, b, FOREARM, FINE * WAVELENGTH), normals=False)
    assert fine.percentile(50) < 0.1e-3
    assert fine.percentile(90) < 0.35e-3
    assert np.percentile(levels, 95) < 0.25
    assert fine.detection >= 0.99
    coarse, _ = forearms.compared(lambda a, b: capsule_mesh(a, b, FOREARM, 1.2 * WAVELENGTH), normals=False)
    assert coarse.percentile(95) > 1e-3  # a prism of 24 sides is another body


@pytest.mark.parametrize("edge", [FINE, 0.8])
def test_a_meshed_sphere_agrees_with_the_series_of_partial_waves(device, edge):
    """Kirchhoff holds for k a of 22 and more."""

    def draw(rng: np.random.Generator) -> tuple:
        radius = rng.uniform(0.03, 0.1)
        return (rng.uniform(0.15, 1.5) + radius) * direction(rng, 40.0), radius

    balls = Truth(device, 80, draw, rigid_sphere)
    seen, levels = balls.compared(lambda center, radius: capsule_mesh(center, center, radius, edge * WAVELENGTH))
    assert seen.percentile(95) < 0.35e-3
    assert np.percentile(levels, 95) < 0.25
    assert seen.detection >= 0.98


def facing(center: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Sides [m] of a square that is turned to the origin."""
    side = np.cross([0.0, 0.0, 1.0], center)
    side *= width / np.linalg.norm(side)
    return side, np.cross(side, center) / np.linalg.norm(center)


@pytest.mark.parametrize("edge", [0.28, 2.0, 20.0])
def test_a_meshed_plate_agrees_with_the_integral_over_it(device, edge):
    def draw(rng: np.random.Generator) -> tuple:
        center = rng.uniform(0.2, 1.5) * direction(rng, 20.0)
        return center, facing(center + rng.normal(0, 0.1 * np.linalg.norm(center), 3), rng.uniform(0.1, 0.3))

    def spectrum(d: Device, center: np.ndarray, sides: tuple) -> np.ndarray:
        normal = np.cross(*sides)
        return kirchhoff(d, *rectangle_surface(center, normal / np.linalg.norm(normal), sides))

    plates = Truth(device, 40, draw, spectrum)
    seen, levels = plates.compared(lambda center, sides: plate_mesh(center, sides, edge * WAVELENGTH))
    assert seen.percentile(95) < 0.35e-3
    assert np.percentile(levels, 95) < 0.25
    assert seen.detection >= 0.975


@pytest.mark.parametrize("tilt", [0.0, 10.0, 25.0])
def test_the_middle_of_a_large_plate_is_an_image_source(device, tilt):
    """Its edges, 60 cm off, echo .3 m later, when the threshold has long been passed."""
    normal = -np.array([np.cos(np.radians(tilt)), 0.0, np.sin(np.radians(tilt))])
    point = -0.5 * normal
    read, level = heard(plate_mesh(point, tuple(2.4 * side for side in facing(point, 0.5)), 0.2))
    crossing, true = true_echo(device, image_source(device, point, normal))
    assert abs(read - crossing) * device.speed / 2 < 0.1e-3
    assert level == pytest.approx(true, abs=0.02)
