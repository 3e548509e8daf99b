"""UltrasonicSensor: what holds for every path of sound, whatever computes it: Fermat, the image source, reciprocity."""

import math
from collections.abc import Mapping

import casadi as ca
from casadi import SX

from ..algebra import Equations, Values, in_other_units, substituted
from .equations import PISTON_TERMS
from .points import resting_path, symbols

PATH_UNITS = {
    "time": "s",
    "bounce_time": "s",
    "first": "m",
    "second": "m",
    "share": "1",
    "incident": "1",
    "reflected": "1",
    "normal": "1",
    "point": "m",
}
CURVATURE_UNITS = {"trace": "1/m", "determinant": "1/m2", "along": "1/m"}
VALUE_UNITS = {
    "transmitter": "m",
    "receiver": "m",
    "velocity": "m/s",
    "transmitter_velocity": "m/s",
    "speed": "m/s",
    "plane_point": "m",
    "ball_center": "m",
    "ball_velocity": "m/s",
    "ball_radius": "m",
    "sight_offset": "m2",
    "sight_product": "m2",
    "sight_half": "m2",
    "path_time": "s",
    "path_bounce_time": "s",
    "first": "m",
    "second": "m",
    "baseline": "m",
    "range": "m",
    "time_of_flight": "s",
    "offset": "m",
    **CURVATURE_UNITS,
}
RESULT_UNITS = {
    "distance_of_time": "m",
    "time_of_distance": "s",
    "arrival_time": "s",
    "spreading_square": "m2",
    "aim_at.reach": "m",
    **{f"{path}.{name}": unit for path in ("plane_path", "ball_path_refined") for name, unit in PATH_UNITS.items()},
    **{f"{body}_curvature.{name}": unit for body in ("sphere", "cylinder") for name, unit in CURVATURE_UNITS.items()},
}


def identities(f: Equations) -> dict[str, SX]:
    """Claims by their words, expressions that vanish."""
    return {
        **_times(f),
        **_plane(f),
        **_ball(f),
        **_round_mirror(f),
        **_doppler(f),
        **_spreading(f),
        **_amplitudes(f),
        **_burst(f),
        **_foreign(f),
        "every equation is right in its units, which x = v/t is not": in_other_units(
            f, symbols(), VALUE_UNITS | RESULT_UNITS, RESULT_UNITS
        ),
    }


def _times(f: Equations) -> dict[str, SX]:
    """Distance and time are inverse; sound arrives where the point then is."""
    values = symbols()
    results = f(values)
    there = f(values | {"time_of_flight": results["time_of_distance"]})
    back = f(values | {"range": results["distance_of_time"]})
    time = results["arrival_time"]
    met = values["offset"] + time * values["velocity"]
    height, across = SX.sym("height"), values["baseline"] / 2 * values["cylinder_axis"]
    middle = values["plane_point"] + height * values["normal"]
    pair = {"transmitter": middle + across, "receiver": middle - across, "velocity": SX.zeros(3)}
    facing = f(values | pair)["plane_path.time"]
    return {
        "distance and time of flight are inverse": ca.vertcat(
            there["distance_of_time"] - values["range"], back["time_of_distance"] - values["time_of_flight"]
        ),
        "sound arrives where the moving point then is": ca.dot(met, met) - (values["speed"] * time) ** 2,
        "the distance of a plane facing the pair is its distance": f(values | {"time_of_flight": facing})[
            "distance_of_time"
        ]
        - height,
    }


def _path(results: Mapping[str, SX], function: str) -> Values:
    return {name: results[f"{function}.{name}"] for name in PATH_UNITS}


def _legs(path: Values, values: Values) -> SX:
    """The legs run from the transmitter to the point to the receiver, in the time that sound takes."""
    at_reception = values["receiver"] + path["time"] * values["velocity"]
    return ca.vertcat(
        path["point"] - values["transmitter"] - path["first"] * path["incident"],
        at_reception - path["point"] - path["second"] * path["reflected"],
        path["first"] + path["second"] - values["speed"] * path["time"],
        path["first"] - values["speed"] * path["bounce_time"],
        ca.dot(path["incident"], path["incident"]) - 1,
        ca.dot(path["reflected"], path["reflected"]) - 1,
    )


def _swapped(values: Values) -> Values:
    return values | {"transmitter": values["receiver"], "receiver": values["transmitter"]}


def _reversed(here: Values, there: Values) -> SX:
    """A path walked the other way is the same path."""
    return ca.vertcat(
        there["time"] - here["time"],
        there["point"] - here["point"],
        there["first"] - here["second"],
        there["second"] - here["first"],
        there["incident"] + here["reflected"],
        there["share"] + here["share"] - 1,
    )


def _plane(f: Equations) -> dict[str, SX]:
    """The plane's path: the image source, Fermat's principle, reciprocity."""
    values = symbols()
    path, normal = _path(f(values), "plane_path"), values["normal"]
    place = SX.sym("place", 3)
    at_reception = values["receiver"] + path["time"] * values["velocity"]
    way = ca.norm_2(place - values["transmitter"]) + ca.norm_2(at_reception - place)
    slope = substituted(ca.gradient(way, place), [(place, path["point"])])
    height = ca.dot(normal, values["transmitter"] - values["plane_point"])
    image = values["transmitter"] - 2 * height * normal
    resting = values | {"velocity": SX.zeros(3)}
    same_place = resting | {"receiver": values["transmitter"]}
    return {
        "plane: the legs make the path": _legs(path, values),
        "plane: the ray leaves as it came, on the other side of the normal": ca.vertcat(
            ca.cross(path["normal"], path["reflected"] - path["incident"]),
            ca.dot(path["normal"], path["reflected"] + path["incident"]),
        ),
        "plane: the normal of the path is the plane's": path["normal"] - normal,
        "plane: the mirror point lies in the plane": ca.dot(normal, path["point"] - values["plane_point"]),
        "plane: the way is straight from the image source": ca.cross(path["point"] - image, at_reception - image),
        "plane: the way is as long as from the image source": ca.dot(at_reception - image, at_reception - image)
        - (values["speed"] * path["time"]) ** 2,
        "plane: the way is stationary on the plane (Fermat)": ca.cross(normal, slope),
        "plane: emitter and receiver may be exchanged": _reversed(
            _path(f(resting), "plane_path"), _path(f(_swapped(resting)), "plane_path")
        ),
        "plane: emitter and receiver in one place measure the height": (
            values["speed"] * f(same_place)["plane_path.time"]
        )
        ** 2
        - (2 * height) ** 2,
    }


def _ball(f: Equations) -> dict[str, SX]:
    """The ball's path: a path that obeys Fermat's principle stays, and an error in its aim hardly shows."""
    values = symbols()
    path, surface_normal = _path(f(values), "ball_path_refined"), values["path_normal"]
    resting = values | resting_path()
    here = _path(f(resting), "ball_path_refined")
    back = _swapped(resting) | {"path_share": 1 - resting["path_share"]}
    lengthwise = resting | {"receiver": resting["transmitter"]}
    from_center = resting["transmitter"] - resting["ball_center"]
    reach = ca.sqrt(ca.dot(from_center, from_center)) - resting["ball_radius"]
    return {
        "ball: the legs make the path": _legs(path, values),
        "ball: a path of stationary time stays as it is": ca.vertcat(
            path["time"] - values["path_time"],
            path["bounce_time"] - values["path_bounce_time"],
            path["share"] - values["path_share"],
            path["point"] - values["path_point"],
            path["normal"] - surface_normal,
        ),
        "ball: the time is stationary on the moving ball (Fermat)": _stationary(f, values),
        "ball: an error in the aim shows in the time as its square": _slope(f, values, "time"),
        "ball at rest: each refinement is a Newton step": _slope(f, resting, "share"),
        "ball: emitter and receiver may be exchanged": _reversed(here, _path(f(back), "ball_path_refined")),
        "ball: emitter and receiver in one place measure the nearest point": resting["speed"]
        * f(lengthwise)["ball_path_refined.time"]
        - 2 * reach,
    }


def _doppler(f: Equations) -> dict[str, SX]:
    """An echo's pace: none where nothing moves, Doppler's formulas for one that does, and the way back undoes it."""
    values, rest = symbols(), SX.zeros(3)
    still = values | {"velocity": rest, "ball_velocity": rest, "transmitter_velocity": rest}
    mover, speed = SX.sym("mover", 3), values["speed"]
    doppler = {name: f(still | {name: mover})["doppler_of"] for name in ("velocity", "ball_velocity")}
    along, back = ca.dot(values["incident"], mover), ca.dot(values["reflected"], mover)
    flown = f(values | {"transmitter_velocity": mover, "ball_velocity": mover, "velocity": mover})
    return {
        "Doppler: none where nothing moves": f(still)["doppler_of"],
        "Doppler: a receiver that flees hears (1 - v/c) of it": speed * doppler["velocity"] + back,
        "Doppler: a transmitter that comes is heard 1 / (1 - v/c) of it": (1 - along / speed)
        * (1 + f(still | {"transmitter_velocity": mover})["doppler_of"])
        - 1,
        "Doppler: a mirror receives and sends": (speed - back) * (1 + doppler["ball_velocity"]) - (speed - along),
        "Doppler: none where all flies as one": flown["doppler_of"],
    }


def _stationary(f: Equations, values: Values) -> SX:
    """The slope of the time over the ball's surface, by the arrival times of the two legs."""
    direction = SX.sym("direction", 3)
    surface = values["ball_center"] + values["ball_radius"] * direction
    leg = {"offset": surface - values["transmitter"], "velocity": values["ball_velocity"]}
    there = f(values | leg)["arrival_time"]
    bounce = surface + there * values["ball_velocity"]
    back = f(values | {"offset": values["receiver"] + there * values["velocity"] - bounce})["arrival_time"]
    slope = ca.gradient(there + back, direction)
    return ca.cross(values["path_normal"], substituted(slope, [(direction, values["path_normal"])]))


def _slope(f: Equations, values: Values, result: str) -> SX:
    """The derivative of a result of a refinement by the share."""
    share = SX.sym("share")
    slope = ca.jacobian(f(values | {"path_share": share})[f"ball_path_refined.{result}"], share)
    return ca.substitute(slope, share, values["path_share"])


def _round_mirror(f: Equations) -> dict[str, SX]:
    """Where the normal of a ball or a cylinder at rest aims: on a path that obeys the law of reflection it stays."""
    values, resting = symbols(), symbols() | resting_path()
    half = (resting["receiver"] - resting["transmitter"]) / 2
    offset = resting["transmitter"] + half - resting["ball_center"]
    place = 2 * resting["path_share"] - 1
    # a cylinder: the same, moved along an axis across the normal
    axis = ca.cross(resting["path_normal"], SX.sym("any", 3))
    axis /= ca.norm_2(axis)
    across = SX.eye(3) - axis @ axis.T
    claims = {}
    for shape, flat in (("ball", SX.eye(3)), ("cylinder", across)):
        o, line = flat @ offset, flat @ half
        sight = {"sight_offset": ca.dot(o, o), "sight_product": ca.dot(o, line), "sight_half": ca.dot(line, line)}
        aim = f(resting | sight | {"aim_place": place})
        claims[f"{shape} at rest: the law of reflection holds where the normal aims"] = aim["aim_at.change"]
        claims[f"{shape} at rest: the normal aims from its centre"] = ca.vertcat(
            aim["aim_at.reach"] * resting["path_normal"] - o - place * line, aim["aim_at.place"] - place
        )
        slope = ca.jacobian(f(resting | sight)["aim_at.change"], resting["aim_place"])
        claims[f"{shape} at rest: what the aim misses is Newton's"] = (
            ca.substitute(slope, resting["aim_place"], place) + 1
        )
    length = values["length"]
    first = f(values)["first_aim"]
    known = f(values | {"sight_offset": length**2, "aim_place": SX(0)})
    slope = ca.jacobian(first, length)
    claims |= {
        "round mirror: with the length known the first aim is Newton's": known["first_aim"] - known["aim_at.change"],
        "round mirror: an error of the length shows in the first aim as its square": ca.substitute(
            slope, values["sight_offset"], length**2
        ),
    }
    return claims


def _tube(values: Values, shape: str) -> SX:
    """Cross-section at the receiver of a ray tube of unit solid angle, by derivatives of its rays."""
    incident, normal, radius = values["incident"], values["normal"], values["ball_radius"]
    offset = radius * normal - values["first"] * incident  # of the transmitter, from the centre of curvature
    aside = SX.sym("aside", 2)
    # two directions across the ray
    a, bend = incident[0], ca.vertcat(incident[1], incident[2])
    across = ca.vertcat(-bend.T, SX.eye(2) - bend @ bend.T / (1 + a))
    ray = incident + across @ aside
    ray /= ca.norm_2(ray)
    if shape == "plane":
        reach = ca.dot(normal, radius * normal - offset) / ca.dot(normal, ray)
        outward = normal
    else:
        keep = SX.eye(3)
        if shape == "cylinder":
            keep -= values["cylinder_axis"] @ values["cylinder_axis"].T
        flat_offset, flat = keep @ offset, keep @ ray
        square, mixed = ca.dot(flat, flat), ca.dot(flat, flat_offset)
        reach = -(mixed + ca.sqrt(mixed**2 - square * (ca.dot(flat_offset, flat_offset) - radius**2))) / square
        outward = (flat_offset + reach * flat) / radius
    reflected = ray - 2 * ca.dot(ray, outward) * outward
    ends = offset + reach * ray + values["second"] * reflected
    sides = substituted(ca.jacobian(ends, aside), [(aside, SX.zeros(2))])
    return -ca.dot(ca.cross(sides[:, 0], sides[:, 1]), values["reflected"])


def _spreading(f: Equations) -> dict[str, SX]:
    """Geometrical acoustics conserves the power in a tube of rays."""
    values = symbols()
    results = f(values)
    claims = {}
    for shape in ("plane", "sphere", "cylinder"):
        curvature = {name: SX(0) for name in CURVATURE_UNITS}
        if shape != "plane":
            curvature = {name: results[f"{shape}_curvature.{name}"] for name in CURVATURE_UNITS}
        square = f(values | curvature)["spreading_square"]
        claims[f"{shape}: the power in a tube of rays is kept"] = square - _tube(values, shape)
    return claims


def _amplitudes(f: Equations) -> dict[str, SX]:
    """Amplitudes: reciprocity, the facing plane, Bessel's equation of the beam."""
    values = symbols()
    amplitude = f(values)["path_amplitude"]
    legs = {"first": values["second"], "second": values["first"]}
    ends = {
        "incident": -values["reflected"],
        "reflected": -values["incident"],
        "axis": values["receiver_axis"],
        "receiver_axis": values["axis"],
    }
    back = values | legs | ends
    straight = {
        "incident": values["axis"],
        "reflected": -values["axis"],
        "normal": -values["axis"],
        "receiver_axis": values["axis"],
        "reflection": SX(1),
    }
    flat = {"spread": values["first"] + values["second"]}
    facing = f(values | straight | flat)["path_amplitude"]
    whole = f(values | {"length": values["first"] + values["second"]})["facing_amplitude"]
    other = {"length": values["spread"]}
    both = f(values | {"length": values["length"] + values["spread"]})["left_by_air"]
    argument = values["half_argument_squared"]
    beam = f(values)["piston_directivity"]
    slope = ca.jacobian(beam, argument)
    left_out = SX(1)
    for k in range(1, PISTON_TERMS + 1):
        left_out *= -argument / (k * (k + 1))
    here, there = f(values), f(back)
    round_bodies = [f"{shape}_curvature.{name}" for shape in ("sphere", "cylinder") for name in CURVATURE_UNITS]
    return {
        "emitter and receiver may be exchanged: the amplitude stays": f(back)["path_amplitude"] - amplitude,
        "the air takes as much of one way as of its parts": f(values)["left_by_air"] * f(values | other)["left_by_air"]
        - both,
        "a plane seen straight on has the amplitude of the facing plane": facing - whole,
        "the beam obeys Bessel's equation, but for the last term of its series": argument * ca.jacobian(slope, argument)
        + 2 * slope
        + beam
        - left_out,
        "the beam's argument is 0 on its axis": f(values | {"incident": values["axis"]})["beam_argument"],
        "the beam is 1 on its axis": ca.substitute(beam, argument, SX(0)) - 1,
        "emitter and receiver may be exchanged: the curvatures stay": ca.vertcat(
            *[there[name] - here[name] for name in round_bodies]
        ),
    }


def _foreign(f: Equations) -> dict[str, SX]:
    """What others are told: the transmitter is at the end of the path by a wall that faces it, and of two times one."""
    values = symbols()
    results = f(values)
    offset, axis = results["burst_position"] - values["position"], results["burst_axis"]
    one, other = values["range"], values["length"]
    return {
        "a burst looks along a unit vector": ca.dot(axis, axis) - 1,
        "a burst leaves half a baseline beside the middle, across its direction": ca.vertcat(
            ca.dot(offset, offset) - (values["baseline"] / 2) ** 2, ca.dot(offset, axis)
        ),
        "the longer of two times is one of them": (results["longer"] - one) * (results["longer"] - other),
    }


def _burst(f: Equations) -> dict[str, SX]:
    """The envelope of a burst solves the equation of two resonators in a row, from rest."""
    values = symbols()
    time, length = SX.sym("time_since"), values["length_of_burst"]
    results = f(values)
    loudest = results["burst_peak"]
    # z'' + 2 z' + z = 0 once the burst has ended, from where 1 - (1 + t) exp(-t) has come by then
    value, slope = 1 - (1 + length) * ca.exp(-length), length * ca.exp(-length)
    later = time - length
    after = (value + (value + slope) * later) * ca.exp(-later)
    peak = results["burst_peak_time"]
    bandwidth = values["bandwidth"]
    edge = math.pi * bandwidth * results["ring_time_of"]  # where the response 1 / (1 + i edge) has the modulus 1/2
    return {
        "a resonator answers with a half at the edges of its bandwidth": 1 + edge**2 - 4,
        "the envelope of a burst is flat at its peak": ca.substitute(ca.jacobian(after, time), time, peak),
        "the envelope of a burst is as high as its peak": ca.substitute(after, time, peak) - loudest,
        "the burst ends as high as its begin has come": results["burst_height"] - value,
    }
