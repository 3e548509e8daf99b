"""UltrasonicSensor: times from the image of the receiver and from Pythagoras, curvatures as derivatives of normals.

Sources: Pierce, *Acoustics*, 8.1 (Fermat, moving boundaries); Deschamps, Proc. IEEE 60 (1972) 1022 (wavefronts after a
mirror); Kinsler and Frey, *Fundamentals of Acoustics*, 7.4 (the piston).
The burst: two linear resonators after a carrier that is switched on and off.
"""

import math

import casadi as ca
from casadi import SX

from ..algebra import Values, rotation_matrix, substituted
from . import air

DECIBEL_PER_NEPER = 8.685889638065036553  # 20 / ln 10
PISTON_RADIUS = 0.00657  # m
PISTON_TERMS = 19  # of the series behind the first
PARTS_OF_DISPERSION = 7

NO_ECHO = -200.0  # dB
STARTED = ("start", "position", "sphere_center", "foreign_1_position", "foreign_2_position", "foreign_3_position")
"""What has had its value since the start."""


def equations(values: Values) -> Values:
    """Results by `FUNCTION` or `FUNCTION.RESULT`, values at the start as `initial(NAME)`; SI units and dB."""
    state = (values["temperature"], values["humidity"], values["pressure"])
    sound = air.speed_of_sound(*state)
    loss = air.absorption(*state, values["frequency"])
    ring = ring_time(values["bandwidth"])
    burst = values["burst_periods"] / values["frequency"] / ring
    half_baseline = values["baseline"] / 2
    half_way = values["speed"] * values["time_of_flight"] / 2
    return {
        "vapour_fraction": air.vapour_fraction(*state),
        "speed_of_sound_in_air": sound,
        "absorption_of_air": loss,
        "initial(speed_of_sound)": sound,
        "initial(absorption)": loss,
        "initial(distance)": values["maximum_range"],
        "initial(level)": SX(NO_ECHO),
        "initial(wave_number)": 2 * math.pi * values["frequency"] / sound,
        "initial(ring_time)": ring,
        "initial(burst_length)": burst,
        "initial(peak_time)": peak_time(burst),
        "initial(peak)": peak(burst),
        "initial(burst_height)": envelope(burst, burst),
        "initial(threshold_amplitude)": ca.exp(values["threshold"] / DECIBEL_PER_NEPER),
        "initial(nearest_time)": facing_time(values["minimum_range"], sound, half_baseline),
        "initial(farthest_time)": facing_time(values["maximum_range"], sound, half_baseline),
        "initial(burst_start)": values["time"] + values["trigger_latency"],
        "initial(burst_period)": values["period"],
        "initial(burst_rest)": rest_after_ping(values, burst, ring, sound),
        **burst_origin(values),
        "longer": (values["range"] + values["length"] + ca.sqrt((values["range"] - values["length"]) ** 2)) / 2,
        "ring_time_of": ring,
        "burst_peak_time": peak_time(values["length_of_burst"]),
        "burst_peak": peak(values["length_of_burst"]),
        "burst_height": envelope(values["length_of_burst"], values["length_of_burst"]),
        **{f"initial({name}_time)": values["time"] for name in STARTED},
        # the legs of an isosceles triangle over the baseline, and its height
        "distance_of_time": ca.sqrt((half_way - half_baseline) * (half_way + half_baseline)),
        "time_of_distance": facing_time(values["range"], values["speed"], half_baseline),
        "arrival_time": arrival_time(values["offset"], values["velocity"], values["speed"]),
        **_named("plane_path", plane_path(values)),
        **_named("aim_at", aim(values)),
        "first_aim": first_aim(values),
        **_named("ball_path_refined", ball_path(values)),
        "doppler_of": doppler(values),
        **_named("sphere_curvature", sphere_curvature(values)),
        **_named("cylinder_curvature", cylinder_curvature(values)),
        "spreading_square": spreading_square(values),
        "piston_directivity": piston(values["half_argument_squared"]),
        "piston_dispersion": dispersion(values["half_argument_squared"]),
        "beam_argument": beam_argument(values["incident"], values["axis"], values["sound_wave_number"]),
        "left_by_air": left_by_air(values["length"], values["absorption_per_metre"]),
        "path_amplitude": path_amplitude(values),
        "facing_amplitude": left_by_air(values["length"], values["absorption_per_metre"]) * 2 / values["length"],
    }


def _named(function: str, results: Values) -> Values:
    return {f"{function}.{name}": result for name, result in results.items()}


def facing_time(height: SX, speed: SX, half_baseline: SX) -> SX:
    """There and back by a plane at `height` that faces the pair: two hypotenuses."""
    return 2 * ca.norm_2(ca.vertcat(height, half_baseline)) / speed


def ring_time(bandwidth: SX) -> SX:
    """1/w of a resonator whose response 1 / (1 + i x/w) has the modulus 1/2 at x = pi bandwidth."""
    half = math.pi * bandwidth
    return ca.sqrt((2**2 - 1) * half**2) / half**2


def envelope(time: SX, length: SX) -> SX:
    """After a burst, of two equal resonators in a row: begun less ended, each 1 - (1 + t) exp(-t)."""
    return (1 + time - length) * ca.exp(length - time) - (1 + time) * ca.exp(-time)


def peak_time(length: SX) -> SX:
    """Where t exp(-t) and (t - length) exp(length - t) agree."""
    return length * ca.exp(length) / (ca.exp(length) - 1)


def peak(length: SX) -> SX:
    """The envelope at its loudest."""
    return envelope(peak_time(length), length)


def rest_after_ping(values: Values, burst: SX, ring: SX, sound: SX) -> SX:
    """From the end of the longest ping to the next periodic burst: it ends with the time-out, or as the echo from
    `maximum_range` is loudest, a peak time after the end of its burst.
    """
    time_out = values["time_out"]
    loudest = facing_time(values["maximum_range"], sound, values["baseline"] / 2) + ring * (burst + peak_time(burst))
    longer = (time_out + loudest + ca.sqrt((time_out - loudest) ** 2)) / 2
    return values["period"] - (values["trigger_latency"] + longer)


def burst_origin(values: Values) -> Values:
    """Place, direction and motion of the transmitter, half a baseline along the sensor's y."""
    turn = rotation_matrix(values["orientation"])
    return {
        "burst_position": values["position"] + turn @ ca.vertcat(0, values["baseline"] / 2, 0),
        "burst_axis": turn[:, 0],
        "burst_velocity": values["velocity"],
    }


def arrival_time(offset: SX, velocity: SX, speed: SX) -> SX:
    """The later root of (c^2 - v^2) t^2 - 2 (o.v) t - o^2 = 0, as what the earlier one leaves of the product."""
    approach = ca.dot(offset, velocity)
    square = ca.dot(offset, offset)
    return square / (ca.sqrt(approach**2 + (speed**2 - ca.dot(velocity, velocity)) * square) - approach)


def plane_path(values: Values) -> Values:
    """Straight from the transmitter to the image of the receiver, which moves as the mirror shows it."""
    normal, speed, transmitter = values["normal"], values["speed"], values["transmitter"]
    mirrored = SX.eye(3) - 2 * normal @ normal.T
    image = values["plane_point"] + mirrored @ (values["receiver"] - values["plane_point"])
    drift = mirrored @ values["velocity"]
    time = arrival_time(image - transmitter, drift, speed)
    incident = (image + time * drift - transmitter) / (speed * time)
    first = ca.dot(values["plane_point"] - transmitter, normal) / ca.dot(incident, normal)
    return {
        "time": time,
        "bounce_time": first / speed,
        "first": first,
        "second": speed * time - first,
        "share": first / (speed * time),
        "incident": incident,
        "reflected": mirrored @ incident,
        "normal": normal,
        "point": transmitter + first * incident,
    }


def aim(values: Values) -> Values:
    """Alhazen's problem by heights: a round mirror's normal aims at `place`, and what Newton's method makes of it.

    o from the centre to the middle of the pair, l half its line, drawn in a plane: o o, o l and l l are given. The
    normal aims at o + place l. The transmitter, o - l, and the receiver, o + l, are to be as high above the plane that
    touches as 1 + place to 1 - place.
    """
    place = SX.sym("place")
    length = ca.sqrt(values["sight_offset"])
    along = values["sight_product"] / length
    o, half = ca.vertcat(length, 0), ca.vertcat(along, ca.sqrt(values["sight_half"] - along**2))
    aimed = o + place * half
    reach = ca.norm_2(aimed)
    there, back = (ca.dot(end, aimed) / reach - values["ball_radius"] for end in (o - half, o + half))
    excess = reach / 2 * ((1 + place) * back - (1 - place) * there)
    results = {"place": place, "reach": reach, "change": -excess / ca.jacobian(excess, place)}
    return {name: ca.substitute(result, place, values["aim_place"]) for name, result in results.items()}


def first_aim(values: Values) -> SX:
    """From the middle of the pair towards the ratio of the two heights there, with the reach as the mean of two sides.

    They are those of a rectangle of the area o o, one of them the rough length.
    """
    reach = (values["length"] + values["sight_offset"] / values["length"]) / 2
    return -values["sight_product"] / (values["sight_offset"] - values["ball_radius"] * reach + values["sight_half"])


def ball_path(values: Values) -> Values:
    """The path by the point of a ball whose normal aims at `path_share` of the way from transmitter to receiver.

    The new share is Newton's: where the aim of the path so found and the aim that led to it would agree.
    """
    share, given = SX.sym("share"), values["path_share"]
    path = _aimed_path(values | {"path_share": share})
    newton = share - (path["share"] - share) / (ca.jacobian(path["share"], share) - 1)
    return {name: ca.substitute(result, share, given) for name, result in (path | {"share": newton}).items()}


def _aimed_path(values: Values) -> Values:
    speed, velocity, drift = values["speed"], values["velocity"], values["ball_velocity"]
    transmitter, share = values["transmitter"], values["path_share"]
    at_reception = values["receiver"] + values["path_time"] * velocity
    outward = transmitter + share * (at_reception - transmitter)
    outward -= values["ball_center"] + values["path_bounce_time"] * drift
    normal = outward / ca.norm_2(outward)
    surface = values["ball_center"] + values["ball_radius"] * normal
    there = arrival_time(surface - transmitter, drift, speed)
    point = surface + there * drift
    back = arrival_time(values["receiver"] + there * velocity - point, velocity, speed)
    incident = (point - transmitter) / (speed * there)
    reflected = (values["receiver"] + (there + back) * velocity - point) / (speed * back)
    weights = [leg * (speed - ca.dot(direction, drift)) for leg, direction in ((there, incident), (back, reflected))]
    return {
        "time": there + back,
        "bounce_time": there,
        "first": speed * there,
        "second": speed * back,
        "share": weights[0] / (weights[0] + weights[1]),
        "incident": incident,
        "reflected": reflected,
        "normal": normal,
        "point": point,
    }


def doppler(values: Values) -> SX:
    """d emission / d reception, less one: from when what left a little later arrives, by the same point of the target.

    The target flies with `ball_velocity`, the transmitter with `transmitter_velocity`, the receiver with `velocity`.
    """
    later, speed = SX.sym("later"), values["speed"]
    drift, ears = values["ball_velocity"], (values["transmitter_velocity"], values["velocity"])
    first, second = values["first"] * values["incident"], values["second"] * values["reflected"]
    # the point, seen from where the burst leaves, and the receiver, seen from the point when it is met
    there = arrival_time(first + later * (drift - ears[0]) - values["first"] / speed * drift, drift, speed)
    met = later + there - values["first"] / speed
    back = arrival_time(second + met * (ears[1] - drift) - values["second"] / speed * ears[1], ears[1], speed)
    at_once = ca.substitute(ca.jacobian(later + there + back, later), later, SX(0))
    return 1 / at_once - 1


def _curvature(normal_at: SX, place: SX, values: Values) -> Values:
    """Of a surface with the normal field `normal_at` (`place`), where it has the normal of the path."""
    here = [(place, values["ball_radius"] * values["normal"])]
    shape = substituted(ca.jacobian(normal_at, place), here)
    return {
        "trace": ca.trace(shape),
        "determinant": (ca.trace(shape) ** 2 - ca.trace(shape @ shape)) / 2,
        "along": values["incident"].T @ shape @ values["incident"],
    }


def sphere_curvature(values: Values) -> Values:
    """Trace and determinant of the normal's derivative, and its value along the ray."""
    place = SX.sym("place", 3)
    return _curvature(place / ca.norm_2(place), place, values)


def cylinder_curvature(values: Values) -> Values:
    """The same of a cylinder about `cylinder_axis`."""
    place, axis = SX.sym("place", 3), values["cylinder_axis"]
    across = place - axis * ca.dot(axis, place)
    return _curvature(across / ca.norm_2(across), place, values)


def spreading_square(values: Values) -> SX:
    """Cross-section of a ray tube over its solid angle, m2."""
    cosine = ca.dot(values["reflected"], values["normal"])
    first, second = values["first"], values["second"]
    trace = 2 * (cosine * values["trace"] + values["along"] / cosine)
    # any matrix of the mirror's trace and determinant
    mirror = ca.blockcat([[SX(0), -4 * values["determinant"]], [SX(1), trace]])
    return ca.det((first + second) * SX.eye(2) + first * second * mirror)


def piston(half_argument_squared: SX) -> SX:
    """2 J1(x) / x by its power series in (x/2)^2."""
    term = total = SX(1)
    for k in range(1, PISTON_TERMS + 1):
        term = -term * half_argument_squared / (k * (k + 1))
        total += term
    return total


def dispersion(half_argument_squared: SX) -> SX:
    """x J2(x) / J1(x), a convergent of its continued fraction (DLMF 10.10.1) by the recurrence of Euler and Wallis."""
    square = 4 * half_argument_squared
    above, below = (SX(1), SX(0)), (SX(0), SX(1))  # the last two numerators and denominators
    for k in range(2, PARTS_OF_DISPERSION + 2):
        numerator = square if k == 2 else -square
        above = (above[1], 2 * k * above[1] + numerator * above[0])
        below = (below[1], 2 * k * below[1] + numerator * below[0])
    return above[1] / below[1]


def beam_argument(direction: SX, axis: SX, wave_number: SX) -> SX:
    """(k a sin / 2)^2."""
    return (wave_number * PISTON_RADIUS / 2) ** 2 * (1 - ca.dot(direction, axis) ** 2)


def left_by_air(length: SX, absorption: SX) -> SX:
    """Of an amplitude, from the absorption in dB/m."""
    return ca.exp(-1 / DECIBEL_PER_NEPER * absorption * length)


def path_amplitude(values: Values) -> SX:
    """Relative to a plane that faces the sensor at 1 m: spreading, the beam twice, the target, the air."""
    amplitude = 2 * values["reflection"] / values["spread"]
    for direction, axis in (("incident", "axis"), ("reflected", "receiver_axis")):
        aside = ca.cross(values[direction], values[axis])
        half_argument = values["sound_wave_number"] * PISTON_RADIUS / 2
        amplitude *= piston(half_argument**2 * ca.dot(aside, aside))
    return amplitude * left_by_air(values["first"] + values["second"], values["absorption_per_metre"])
