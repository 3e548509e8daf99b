"""What an ultrasonic sensor hears of a spectrum of echoes: burst, resonators, beam, comparator.

Shares nothing with the unit but the device's data. Pressures are relative to the echo of a large plane that faces the
sensor at 1 m without loss: a target's echo at the frequency f is P(f) = scattered pressure / (pressure at 1 m) x 2 m,
with exp(+i w t), so that a path of length L is exp(-i k L). `echoes` has such spectra.

Sources: the burst, two resonators of 2 kHz at -6 dB; the beam, a piston in a baffle, 2 J1(x)/x (Kinsler and Frey,
Fundamentals of Acoustics, 7.4).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import j1

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

    def level(self, *echoes: Complex | tuple[Complex, float]) -> float:
        """Level in dB of the echoes at their loudest."""
        return float(20 * np.log10(self.envelope(*echoes)[1].max()))

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
