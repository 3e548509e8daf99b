"""UltrasonicSensor: the points at which its equations are compared, made so that they need not be solved for.

A path is built from its bounce: directions and legs are free, and the target, the receiver and the normal follow.
"""

import casadi as ca
from casadi import SX

from ..algebra import Values, rotation_matrix, unit_quaternion, unit_vector

LENGTHS = ("baseline", "range", "length", "first", "second", "ball_radius", "leg_1", "leg_2", "spread")
SAMPLES = dict.fromkeys((*LENGTHS, "metre", "kilogram", "second_of_time"), (0.5, 1.0)) | {
    "temperature": (253.15, 323.15),
    "humidity": (0.1, 1.0),
    "pressure": (6e4, 1.1e5),
    "frequency": (2e4, 6e4),
    "bandwidth": (1e3, 4e3),
    "burst_periods": (2.0, 16.0),
    "length_of_burst": (0.25, 2.0),
    "reflection": (0.25, 1.0),
    "minimum_range": (0.02, 0.1),
    "trigger_latency": (0.25, 0.5),
    "period": (1.0, 2.0),
    "time_out": (1.0, 2.0),
    "speed": (3.0, 4.0),
    "time_of_flight": (1.0, 2.0),
    "trace": (0.5, 1.0),
    "determinant": (0.5, 1.0),
    "along": (0.1, 0.5),
    "half_argument_squared": (0.0, 4.0),
    "sound_wave_number": (100.0, 200.0),
    "incidence": (-0.6, 0.6),
    "height": (0.5, 1.0),
    "plane_distance": (8.0, 9.0),
    "sight_offset": (4.0, 9.0),
    "sight_half": (0.25, 1.0),
    "sight_product": (-0.25, 0.25),
    "aim_place": (-1.0, 1.0),
}


def scalar(name: str) -> SX:
    """A free number."""
    return SX.sym(name)


def mirror() -> Values:
    """A point of a mirror at rest: its normal, the directions of a ray there, and an axis within the surface."""
    attitude = rotation_matrix(unit_quaternion("mirror_attitude"))
    incidence = unit_vector("incidence")
    return {
        "normal": attitude[:, 0],
        "cylinder_axis": attitude[:, 2],
        "incident": attitude @ ca.vertcat(-incidence[0], incidence[1:]),
        "reflected": attitude @ incidence,
        "first": scalar("first"),
        "second": scalar("second"),
    }


def path(velocity: SX, ball_velocity: SX) -> Values:
    """Transmitter, receiver and ball of a path whose time is stationary; the ball and the sensor move."""
    transmitter, radius, speed = SX.sym("transmitter", 3), scalar("ball_radius"), scalar("speed")
    incident, reflected = unit_vector("leaving"), -unit_vector("coming")
    first, second = scalar("leg_1"), scalar("leg_2")
    slowness = [direction / (speed - ca.dot(direction, ball_velocity)) for direction in (incident, reflected)]
    normal = slowness[1] - slowness[0]
    normal /= ca.norm_2(normal)
    bounce_time, time = first / speed, (first + second) / speed
    bounce = transmitter + first * incident
    weights = [
        leg * (speed - ca.dot(direction, ball_velocity)) for leg, direction in ((first, incident), (second, reflected))
    ]
    return {
        "transmitter": transmitter,
        "receiver": bounce + second * reflected - time * velocity,
        "velocity": velocity,
        "speed": speed,
        "ball_center": bounce - radius * normal - bounce_time * ball_velocity,
        "ball_velocity": ball_velocity,
        "ball_radius": radius,
        "path_time": time,
        "path_bounce_time": bounce_time,
        "path_share": weights[0] / (weights[0] + weights[1]),
        "path_normal": normal,
        "path_point": bounce,
    }


def resting_path() -> Values:
    """The same, all at rest."""
    return path(SX.zeros(3), SX.zeros(3))


def symbols() -> Values:
    """What every function of the sensor takes, in SI units."""
    numbers = ("temperature", "humidity", "pressure", "frequency", "bandwidth", "burst_periods", "length_of_burst")
    ranges = ("minimum_range", "maximum_range", "time", "sound_wave_number", "absorption_per_metre", "reflection")
    times = ("trigger_latency", "period", "time_out")
    echoes = ("threshold", "spread")
    sights = ("sight_offset", "sight_product", "sight_half", "aim_place")
    more = ("half_argument_squared", "length", "time_of_flight", "range", "baseline", "trace", "determinant", "along")
    paths, mirrors = path(SX.sym("velocity", 3), SX.sym("ball_velocity", 3)), mirror()
    # so far behind the transmitter that the receiver is in front of the plane too
    foot = paths["transmitter"] - scalar("plane_distance") * mirrors["normal"]
    return {
        **{name: scalar(name) for name in numbers + ranges + times + echoes + sights + more},
        **paths,
        **mirrors,
        "transmitter_velocity": SX.sym("transmitter_velocity", 3),
        "position": SX.sym("position", 3),
        "orientation": unit_quaternion("sensor_attitude"),
        "axis": unit_vector("axis_slope"),
        "receiver_axis": unit_vector("receiver_axis_slope"),
        "plane_point": foot + ca.cross(mirrors["normal"], SX.sym("aside", 3)),
        "offset": SX.sym("offset", 3),
    }
