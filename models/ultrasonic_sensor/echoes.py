"""Spectra of echoes from wave theory: plane, rigid sphere, and any convex body by its surface.

In the units of `hearing`, over the frequencies of its `Device`. Sources: the plane, its image source; the rigid sphere,
its series of partial waves (Morse and Ingard, Theoretical Acoustics, 8.2; Bowman, Senior, Uslenghi, 10.4); any other
convex body, the Kirchhoff integral over what both ends see (Pierce, Acoustics, 5.4).
"""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import eval_legendre, j1, spherical_jn, spherical_yn

from .hearing import PISTON_RADIUS, Array, Complex, Device


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
    (n.d1 + n.d2) p1 p2, d from the surface to the ends. Frequencies are taken every `coarse` lines, or as many as give
    six to a turn of the longest and the shortest path, and joined by a spline, with the phase of the path in the middle
    taken out.
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
    reference, spread = (length.max() + length.min()) / 2, (length.max() - length.min()) / 2
    coarse = max(1, min(coarse, int(device.window * device.speed / (6 * max(spread, 1e-6)))))
    places = np.unique(np.append(np.arange(0, device.offsets.size, coarse), device.offsets.size - 1))
    values = np.empty(places.size, complex)
    for i, place in enumerate(places):
        k = device.wave_numbers[place]
        x = [np.maximum(sine * k * PISTON_RADIUS, 1e-9) for sine in sines]
        beam = 4 * j1(x[0]) * j1(x[1]) / (x[0] * x[1])
        values[i] = 1j * k * np.sum(weight * beam * np.exp(-1j * k * (length - reference)))
    smooth = CubicSpline(device.offsets[places], values)(device.offsets)
    return 2 * smooth * np.exp(-1j * device.wave_numbers * reference)
