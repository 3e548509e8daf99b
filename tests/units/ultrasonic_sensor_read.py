"""Reads an UltrasonicSensor after a ping; and the truth's picture of the default one."""

import numpy as np
from ultrasonic_sensor_truth import Device

from ulna import Slave

READ = ("distance", "device_distance", "time_of_flight", "echo_width", "valid", "level", "speed_of_sound", "absorption")
BASELINE = 0.026  # m, the default
FREQUENCY = 40000.0  # Hz
RING_TIME = np.sqrt(3) / (np.pi * 2000.0)  # s, of 2 kHz at -6 dB


def pings(until: float, **values: object) -> dict[str, float]:
    """Outputs at `until` [s]; nothing is rounded."""
    with Slave("UltrasonicSensor", version="3.0") as sensor:
        for name, value in ({"resolution": 0.0} | values).items():
            sensor.set(name, value)
        sensor.initialize(start=0.0)
        sensor.step(0.0, until)
        return {name: sensor.get(name) for name in READ}


def ping(**values: object) -> dict[str, float]:
    """The same after the first ping."""
    return pings(0.0599, **values)


def width(**values: object) -> float:
    """Echo width [s] of the first ping, infinite without an echo."""
    seen = ping(**values)
    return seen["echo_width"] if seen["valid"] else np.inf


def default_device() -> Device:
    """The default sensor at rest at the origin."""
    seen = ping()
    nearest, farthest = (2 * np.hypot(reach, BASELINE / 2) / seen["speed_of_sound"] for reach in (0.02, 4.0))
    # an echo that arrives in time is waited for: its peak comes 388 us later
    return Device(seen["speed_of_sound"], seen["absorption"], minimum_time=nearest, maximum_time=farthest + 4e-4)
