"""The air, typed from the tables of its sources.

Sources: Cramer, J. Acoust. Soc. Am. 93 (1993) 2510, equation 15 and table III; water vapour as CIPM-81/91, Davis,
Metrologia 29 (1992) 67; absorption: ISO 9613-1:1993, equations 3 to 5 and annex B.
"""

import math

import casadi as ca
from casadi import SX

STANDARD_PRESSURE = 101325.0  # Pa
CARBON_DIOXIDE = 0.0004  # mole fraction
LN_10 = math.log(10.0)

SATURATION = ((1.2378847e-5, 2), (-1.9121316e-2, 1), (33.93711047, 0), (-6343.1645, -1))
"""ln of the saturation pressure in Pa: coefficient, power of the temperature in K."""

LINEAR = {
    "air": (331.5024, 0.603055, -0.000528),
    "water": (51.471935, 0.1495874, -0.000782),
    "pressure": (-1.82e-7, 3.73e-8, -2.93e-10),
    "carbon dioxide": (-85.20931, -0.228525, 5.91e-5),
}
"""a0 to a11 of the speed of sound: what multiplies 1 and the three others, by rising powers of the temperature in C."""

PRODUCTS = (
    (-2.835149, ("water", "water")),
    (-2.15e-13, ("pressure", "pressure")),
    (29.179762, ("carbon dioxide", "carbon dioxide")),
    (0.000486, ("water", "pressure", "carbon dioxide")),
)
"""a12 to a15."""


def vapour_fraction(temperature: SX, humidity: SX, pressure: SX) -> SX:
    """Mole fraction of water vapour; temperature in K, humidity from 0 to 1, pressure in Pa."""
    saturation = ca.exp(sum(factor * temperature**power for factor, power in SATURATION))
    enhancement = 1.00062 + 3.14e-8 * pressure + 5.6e-7 * (temperature - 273.15) ** 2
    return humidity * enhancement * saturation / pressure


def speed_of_sound(temperature: SX, humidity: SX, pressure: SX) -> SX:
    """In m/s; temperature in K, humidity from 0 to 1, pressure in Pa."""
    celsius = temperature - 273.15
    water = vapour_fraction(temperature, humidity, pressure)
    share = {"air": SX(1), "water": water, "pressure": pressure, "carbon dioxide": SX(CARBON_DIOXIDE)}
    speed = sum(sum(a * celsius**k for k, a in enumerate(row)) * share[name] for name, row in LINEAR.items())
    for factor, names in PRODUCTS:
        term = SX(factor)
        for name in names:
            term *= share[name]
        speed += term
    return speed


def absorption(temperature: SX, humidity: SX, pressure: SX, frequency: SX) -> SX:
    """In dB/m: classical and rotational, and the relaxing vibrations of oxygen and nitrogen."""
    cold = 293.15 / temperature
    thin = STANDARD_PRESSURE / pressure
    water = 100 * thin * humidity * ca.exp(LN_10 * (4.6151 - 6.8346 * ca.exp(1.261 * ca.log(273.16 / temperature))))
    root = ca.sqrt(1 / cold)
    oxygen = (24 + 40400 * water * (water + 0.02) / (water + 0.391)) / thin
    warming = 1 - ca.exp(ca.log(cold) / 3)
    nitrogen = ca.sqrt(cold) / thin * (9 + 280 * water * ca.exp(4.17 * warming))
    total = 1.84e-11 * thin * root * frequency**2
    for strength, temperature_of_vibration, relaxation in ((0.01275, 2239.1, oxygen), (0.1068, 3352.0, nitrogen)):
        ratio = frequency / relaxation
        vibration = strength * ca.exp(-temperature_of_vibration / temperature)
        total += cold**2 * ca.sqrt(cold) * vibration * frequency * ratio / (1 + ratio**2)
    return 8.686 * total
