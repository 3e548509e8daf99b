"""What an ultrasonic sensor hears, from wave theory: echoes as spectra over the burst, summed and compared in time.

Shares nothing with the unit but the device's data. Pressures are relative to the echo of a large plane that faces the
sensor at 1 m without loss: a target's echo at the frequency f is P(f) = scattered pressure / (pressure at 1 m) x 2 m,
with exp(+i w t), so that a path of length L is exp(-i k L).

Sources: the burst, two resonators of 2 kHz at -6 dB; the beam, a piston in a baffle, 2 J1(x)/x; the rigid sphere, its
series of partial waves (Morse and Ingard, Theoretical Acoustics, 8.2; Bowman, Senior, Uslenghi, 10.4); any other convex
body, the Kirchhoff integral over what both ends see (Pierce, Acoustics, 5.4).
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.special import eval_legendre, j1, spherical_jn, spherical_yn

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
PISTON_RADIUS = 6.57e-3  # m


@dataclass(frozen=True)
class Device:
    """The sensor at rest at the origin, looking along +x, its ears on y."""

    speed: float
    """Of sound, m/s."""
    absorption: float = 0.0
    """dB/m."""
    threshold: float = -36.0
    """dB."""
    frequency: float = 40000.0
    bandwidth: float = 2000.0
    periods: float = 8.0
    baseline: float = 0.026
    minimum_time: float = 0.0
    """When the comparator opens, s."""
    maximum_time: float = 0.0234
    window: float = 0.03
    """Length of the record in s: spectra have lines 1/window apart."""
    half_width: float = 25000.0
    """Hz on both sides of the carrier; beyond, two resonators leave 5e-4 of the amplitude times that of the burst."""
    ears: tuple[Array, Array] = field(init=False)

    def __post_init__(self) -> None:
        """Places the ears."""
        ear = np.array([0.0, self.baseline / 2, 0.0])
        object.__setattr__(self, "ears", (ear, -ear))

    @property
    def offsets(self) -> Array:
        """Frequencies off the carrier [n], Hz."""
        count = round(self.half_width * self.window)
        return np.arange(-count, count + 1) / self.window

    @property
    def frequencies(self) -> Array:
        """Frequencies [n] at which an echo is to be known, Hz."""
        return self.frequency + self.offsets

    @property
    def wave_numbers(self) -> Array:
        """Their wave numbers [n], 1/m."""
        return 2 * np.pi * self.frequencies / self.speed

    def burst(self, pace: float = 1.0) -> Complex:
        """Spectrum [n] of the burst after both resonators, where what leaves in `pace` seconds arrives in one."""
        leaving, arriving = (2j * np.pi * x for x in (self.frequencies / pace - self.frequency, self.offsets))
        length = self.periods / self.frequency
        burst = np.where(leaving == 0, length, (1 - np.exp(-leaving * length)) / np.where(leaving == 0, 1, leaving))
        edge = np.pi * self.bandwidth / np.sqrt(3)
        return burst / pace / (1 + leaving / edge) / (1 + arriving / edge)

    def envelope(self, *echoes: Complex | tuple[Complex, float], pitch: float = 1e-6) -> tuple[Array, Array]:
        """Times [m] and the envelope [m] of the sum of echoes, 1 for the loudest of the facing plane.

        An echo is a spectrum [n] and, where what it came by moves, its pace.
        """
        count = round(self.window / pitch)
        lines = np.zeros(count, complex)
        places = np.round(self.offsets * self.window).astype(int)

        def shaped(lines_of: Complex) -> Complex:
            lines[:] = 0
            lines[places] = lines_of
            return np.fft.ifft(lines)

        alone = np.abs(shaped(self.burst())).max()
        parts = [echo if isinstance(echo, tuple) else (echo, 1.0) for echo in echoes]
        received = sum(spectrum * self.burst(pace) for spectrum, pace in parts)
        return np.arange(count) * pitch, np.abs(shaped(received)) / alone

    def heard(self, *echoes: Complex | tuple[Complex, float]) -> float:
        """Time in s at which the echoes pass the threshold, infinity for never; between samples by a line.

        What is above the threshold when the comparator opens is heard then.
        """
        times, envelope = self.envelope(*echoes)
        threshold = 10 ** (self.threshold / 20)
        within = (times >= self.minimum_time) & (times <= self.maximum_time)
        above = np.flatnonzero(within & (envelope >= threshold))
        if not above.size:
            return np.inf
        k = above[0]
        if k == 0 or (times[k - 1] < self.minimum_time and np.interp(self.minimum_time, times, envelope) >= threshold):
            return self.minimum_time
        return times[k] - (envelope[k] - threshold) / (envelope[k] - envelope[k - 1]) * (times[k] - times[k - 1])

    def beam(self, directions: Array, pace: float = 1.0) -> Complex:
        """Amplitude [..., n] of the piston towards directions [..., 3] from it; nothing behind it.

        For the transmitter of a moving echo, `pace` is that of the echo.
        """
        sine = np.sqrt(np.clip(1 - directions[..., 0] ** 2, 0, None))
        x = np.maximum(sine[..., None] * self.wave_numbers / pace * PISTON_RADIUS, 1e-9)
        return np.where(directions[..., :1] > 0, 2 * j1(x) / x, 0.0)

    def loss(self, length: Array) -> Array:
        """What the air leaves of the amplitude on a way of `length` m."""
        return 10 ** (-self.absorption * length / 20)


def image_source(device: Device, point: Array, normal: Array) -> Complex:
    """Spectrum of a large plane: the mirror image of the transmitter."""
    n = normal / np.linalg.norm(normal)
    there, back = device.ears
    image = there - 2 * np.dot(there - point, n) * n
    way = back - image
    length = np.linalg.norm(way)
    coming = way / length
    leaving = coming - 2 * np.dot(coming, n) * n
    beam = device.beam(leaving) * device.beam(-coming)
    return 2 / length * beam * device.loss(length) * np.exp(-1j * device.wave_numbers * length)


def rigid_sphere(device: Device, center: Array, radius: float, coarse: int = 20) -> Complex:
    """Spectrum of a rigid sphere: sum over n of i k (2n+1) j_n'(ka)/h_n'(ka) h_n(k r1) h_n(k r2) P_n(cos).

    h_n is that of outgoing waves with exp(+i w t), h2. The beams are those towards the mirror point. Frequencies
    are taken every `coarse` lines and joined by a spline, with the phase of the mirror path taken out.
    """
    legs = [ear - center for ear in device.ears]
    reaches = [np.linalg.norm(leg) for leg in legs]
    cosine = np.dot(*legs) / (reaches[0] * reaches[1])
    places = np.unique(np.append(np.arange(0, device.offsets.size, coarse), device.offsets.size - 1))
    k = device.wave_numbers[places]
    order = np.arange(int(k.max() * radius + 6 * (k.max() * radius) ** (1 / 3) + 12))[:, None]
    ka = k * radius

    def outgoing(x: Array, derivative: bool = False) -> Complex:
        return spherical_jn(order, x, derivative) - 1j * spherical_yn(order, x, derivative)

    ratio = spherical_jn(order, ka, True) / outgoing(ka, True)
    waves = ratio * outgoing(k * reaches[0]) * outgoing(k * reaches[1])
    pressure = 1j * k * np.sum((2 * order + 1) * waves * eval_legendre(order, cosine), axis=0)
    aim = np.add(*[leg / reach for leg, reach in zip(legs, reaches, strict=True)])
    point = center + radius * aim / np.linalg.norm(aim)
    beam = np.ones(device.offsets.size, complex)
    length = 0.0
    for ear in device.ears:
        leg = np.linalg.norm(point - ear)
        beam *= device.beam((point - ear) / leg)
        length += leg
    smooth = CubicSpline(device.offsets[places], pressure * np.exp(1j * k * length))(device.offsets)
    return 2 * smooth * np.exp(-1j * device.wave_numbers * length) * beam * device.loss(length)


def kirchhoff(device: Device, points: Array, normals: Array, areas: Array, coarse: int = 40) -> Complex:
    """Spectrum of surface elements [m, 3], [m, 3], [m] m2 that both ends see: i k/(4 pi) of the integral of
    (n.d1 + n.d2) p1 p2, d from the surface to the ends. Frequencies are taken every `coarse` lines and joined by
    a spline, with the phase of the mean length taken out.
    """
    legs = [ear - points for ear in device.ears]
    reaches = [np.linalg.norm(leg, axis=1) for leg in legs]
    towards = [leg / reach[:, None] for leg, reach in zip(legs, reaches, strict=True)]
    cosines = [np.sum(normals * d, axis=1) for d in towards]
    lit = (cosines[0] > 0) & (cosines[1] > 0) & (towards[0][:, 0] < 0) & (towards[1][:, 0] < 0)
    if not lit.any():
        return np.zeros(device.offsets.size, complex)
    weight = (cosines[0] + cosines[1])[lit] * areas[lit] / (4 * np.pi * reaches[0][lit] * reaches[1][lit])
    length = (reaches[0] + reaches[1])[lit]
    weight = weight * device.loss(length)
    sines = [np.sqrt(np.clip(1 - d[lit, 0] ** 2, 0, None)) for d in towards]
    places = np.unique(np.append(np.arange(0, device.offsets.size, coarse), device.offsets.size - 1))
    reference = length.min()
    values = np.empty(places.size, complex)
    for i, place in enumerate(places):
        k = device.wave_numbers[place]
        x = [np.maximum(sine * k * PISTON_RADIUS, 1e-9) for sine in sines]
        beam = 4 * j1(x[0]) * j1(x[1]) / (x[0] * x[1])
        values[i] = 1j * k * np.sum(weight * beam * np.exp(-1j * k * (length - reference)))
    smooth = CubicSpline(device.offsets[places], values)(device.offsets)
    return 2 * smooth * np.exp(-1j * device.wave_numbers * reference)


def grid(first: Array, second: Array) -> tuple[Array, Array, float]:
    """Midpoints of a grid between evenly spaced edges, and the area of a cell in the two parameters."""
    a, b = ((edges[1:] + edges[:-1]) / 2 for edges in (first, second))
    A, B = np.meshgrid(a, b, indexing="ij")
    return A.ravel(), B.ravel(), float((first[1] - first[0]) * (second[1] - second[0]))


def capsule_surface(start: Array, end: Array, radius: float, pitch: float = 0.0012) -> tuple[Array, Array, Array]:
    """Points, normals and areas of a capsule, cells about `pitch` m wide."""
    whole = end - start
    length = np.linalg.norm(whole)
    axis = whole / length
    side = np.cross(axis, [1.0, 0, 0] if abs(axis[0]) < 0.9 else [0, 1.0, 0])
    side /= np.linalg.norm(side)
    up = np.cross(axis, side)
    turns = np.linspace(0, 2 * np.pi, int(2 * np.pi * radius / pitch) + 2)
    along, angle, cell = grid(np.linspace(0, length, int(length / pitch) + 2), turns)
    normal = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up
    parts = [(start + along[:, None] * axis + radius * normal, normal, np.full(along.size, cell * radius))]
    for center, out in ((start, -axis), (end, axis)):
        rise, angle, cell = grid(np.linspace(0, np.pi / 2, int(np.pi / 2 * radius / pitch) + 2), turns)
        flat = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up
        normal = np.sin(rise)[:, None] * out + np.cos(rise)[:, None] * flat
        parts.append((center + radius * normal, normal, radius**2 * np.cos(rise) * cell))
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


def rectangle_surface(
    center: Array, normal: Array, sides: tuple[Array, Array], pitch: float = 0.0012
) -> tuple[Array, Array, Array]:
    """Points, normals and areas of a rectangle; `sides` are its two edges as vectors."""
    counts = [int(np.linalg.norm(side) / pitch) + 2 for side in sides]
    a, b, cell = grid(*[np.linspace(-0.5, 0.5, count) for count in counts])
    points = center + a[:, None] * sides[0] + b[:, None] * sides[1]
    area = cell * np.linalg.norm(np.cross(*sides))
    return points, np.tile(normal, (a.size, 1)), np.full(a.size, area)


def box_surface(
    center: Array, axes: Array, size: Array, ears: tuple[Array, Array], pitch: float = 0.0012
) -> tuple[Array, Array, Array]:
    """The faces of a box, axes as rows of `axes`, that both ears see."""
    parts = []
    for i in range(3):
        for sign in (-1.0, 1.0):
            normal = sign * axes[i]
            middle = center + normal * size[i] / 2
            if all(np.dot(ear - middle, normal) > 0 for ear in ears):
                others = tuple(axes[j] * size[j] for j in range(3) if j != i)
                parts.append(rectangle_surface(middle, normal, others, pitch))
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


@dataclass
class Agreement:
    """How a device agrees with the truth over many poses."""

    errors: list[float] = field(default_factory=list)
    agreed: int = 0
    total: int = 0

    def see(self, read: float, true: float, speed: float) -> None:
        """Two times in s; infinity for no echo."""
        self.total += 1
        self.agreed += np.isfinite(read) == np.isfinite(true)
        if np.isfinite(read) and np.isfinite(true):
            self.errors.append(abs(read - true) * speed / 2)

    def percentile(self, share: float) -> float:
        """Of the range error, m."""
        return float(np.percentile(self.errors, share))

    @property
    def detection(self) -> float:
        """Share of the poses at which both hear or neither does."""
        return self.agreed / self.total


Read = Callable[[dict], float]
