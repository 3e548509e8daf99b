"""What an ultrasonic sensor can hear, in closed form: levels of lone echoes, interference, gas theory, rays.

Distances in m, angles in rad, levels in dB; 0 dB is a large plane that faces the sensor at 1 m without loss. Targets
lie in the plane across the baseline, so that both ears are equally far and the mirror point is that of the middle.

Sources: beam, Kinsler and Frey, Fundamentals of Acoustics, 7.4, with Bessel's integral (DLMF 10.9.2); spreading, a ray
tube by a curved mirror (Deschamps, Proc. IEEE 60 (1972) 1022), its planes of incidence and across apart; absorption,
ISO 9613-1:1993, equations 3 to 5; speed of sound, a mixture of ideal gases with vibrations after Einstein.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

PISTON_RADIUS = 6.57e-3  # m
FREQUENCY = 40000.0  # Hz
BANDWIDTH = 2000.0  # Hz, of each resonator, at -6 dB
PERIODS = 8.0  # of the burst
BASELINE = 0.026  # m
FIRMWARE = 0.01 / 58e-6  # m of distance by second of echo: 58 us a centimetre
TURNS = np.linspace(0.0, math.pi, 65)
KELVIN = 273.15

MIRRORS: dict[str, tuple[bool, bool]] = {"plane": (False, False), "sphere": (True, True), "forearm": (False, True)}
"""Whether a target is curved in the plane of incidence, which is that of the baseline, and across."""


@dataclass(frozen=True)
class Air:
    """What sound finds."""

    speed: float
    """m/s"""
    absorption: float
    """dB/m"""

    @property
    def wave_number(self) -> float:
        """1/m"""
        return 2 * math.pi * FREQUENCY / self.speed


def air(celsius: float = 20.0, humidity: float = 0.5) -> Air:
    """At one atmosphere."""
    return Air(speed_of_sound(celsius, humidity), absorption(celsius, humidity))


def speed_of_sound(celsius: float, humidity: float) -> float:
    """sqrt(gamma R T / M) in m/s of moist air at one atmosphere; saturation pressure after Buck (1981)."""
    gases = {  # share of dry air, kg/mol, cp/R without vibration, vibrational temperatures
        "N2": (0.78084, 28.0134e-3, 3.5, (3393.0,)),
        "O2": (0.20946, 31.9988e-3, 3.5, (2273.0,)),
        "Ar": (0.00930, 39.948e-3, 2.5, ()),
        "CO2": (0.00040, 44.0095e-3, 3.5, (960.0, 960.0, 1992.0, 3380.0)),
        "H2O": (0.0, 18.0153e-3, 4.0, (2295.0, 5255.0, 5400.0)),
    }
    temperature = celsius + KELVIN
    water = humidity * 611.21 * math.exp((18.678 - celsius / 234.5) * celsius / (257.14 + celsius)) / 101325.0
    mass = heat = 0.0
    for name, (share, molar_mass, rigid, vibrations) in gases.items():
        fraction = water if name == "H2O" else share * (1 - water)
        ratios = np.array(vibrations) / temperature
        mass += fraction * molar_mass
        heat += fraction * (rigid + np.sum(ratios**2 * np.exp(ratios) / np.expm1(ratios) ** 2))
    return math.sqrt(heat / (heat - 1) * 8.314462618 * temperature / mass)


def absorption(celsius: float, humidity: float) -> float:
    """dB/m at FREQUENCY and one atmosphere."""
    temperature = celsius + KELVIN
    warmth = temperature / 293.15
    water = 100 * humidity * 10 ** (4.6151 - 6.8346 * (273.16 / temperature) ** 1.261)
    oxygen = 24 + 4.04e4 * water * (0.02 + water) / (0.391 + water)
    nitrogen = warmth**-0.5 * (9 + 280 * water * math.exp(-4.170 * (warmth ** (-1 / 3) - 1)))
    square = FREQUENCY**2
    relaxing = 0.01275 * math.exp(-2239.1 / temperature) / (oxygen + square / oxygen)
    relaxing += 0.1068 * math.exp(-3352.0 / temperature) / (nitrogen + square / nitrogen)
    return 8.686 * square * (1.84e-11 * warmth**0.5 + warmth**-2.5 * relaxing)


def beam(sine: float, wave_number: float) -> float:
    """Amplitude 2 J1(x) / x of the piston."""
    x = wave_number * PISTON_RADIUS * sine
    if x < 1e-6:
        return 1.0
    values = np.cos(TURNS - x * np.sin(TURNS))
    return 2 / x * float((values.sum() - (values[0] + values[-1]) / 2) / (len(TURNS) - 1))


def level(target: str, distance: float, aside: float, radius: float, here: Air) -> float:
    """Of the lone echo of a target whose surface is `distance` away, `aside` off the axis."""
    leg = math.hypot(distance, BASELINE / 2)
    cosine = distance / leg
    within, across = (leg / radius if curved else 0.0 for curved in MIRRORS[target])
    # 2 legs in each plane; a mirror of radius a adds 2 r1 r2 / (a cos i) in that of incidence, times cos i across
    tube = (2 * leg + 2 * leg * within / cosine) * (2 * leg + 2 * leg * across * cosine)
    towards = cosine * math.cos(aside)
    amplitude = 2 / math.sqrt(tube) * beam(math.sqrt(max(0.0, 1 - towards**2)), here.wave_number) ** 2
    loss = here.absorption * 2 * leg
    return 20 * math.log10(max(abs(amplitude), 1e-30)) - loss if towards > 0 else -math.inf


def farthest(heard: Callable[[float], bool], low: float, high: float, within: float = 1e-3) -> float:
    """Largest distance up to which it is heard, to a part `within`; 0 if it is not at `low`."""
    if not heard(low):
        return 0.0
    if heard(high):
        return high
    while high - low > within * low:
        middle = (low + high) / 2
        low, high = (middle, high) if heard(middle) else (low, middle)
    return (low + high) / 2


def interference(gap: float, ratio: float, here: Air) -> float:
    """Loudest of two echoes over the louder alone, dB; the second `gap` m farther, with `ratio` of the amplitude.

    Two resonators after a burst: u(t) - u(t - burst), u(t) = 1 - (1 + t) exp(-t); the carrier of the second is late by
    2 gap, its envelope too.
    """
    ring = math.sqrt(3) / (math.pi * BANDWIDTH)
    burst = PERIODS / FREQUENCY / ring
    times = np.linspace(0.0, 12.0, 24001)
    late = 2 * gap / here.speed / ring

    def begun(t: np.ndarray) -> np.ndarray:
        t = np.maximum(t, 0.0)
        return 1 - (1 + t) * np.exp(-t)

    def envelope(t: np.ndarray) -> np.ndarray:
        return begun(t) - begun(t - burst)

    first = envelope(times)
    total = first + ratio * envelope(times - late) * np.exp(-2j * here.wave_number * gap)
    return 20 * math.log10(np.abs(total).max() / first.max())


def firmware_error(celsius: float, humidity: float) -> float:
    """Of the distance that 58 us a centimetre gives, relative."""
    return FIRMWARE * 2 / speed_of_sound(celsius, humidity) - 1


def ray_error(tilt: float) -> float:
    """Of a ray along the axis to a plane, relative to its perpendicular distance."""
    return 1 / math.cos(tilt) - 1


def cone_error(tilt: float, field_of_view: float) -> float:
    """Of the nearest ray in a cone: along the perpendicular while that is within, else along the rim."""
    return 1 / math.cos(max(0.0, tilt - field_of_view / 2)) - 1
