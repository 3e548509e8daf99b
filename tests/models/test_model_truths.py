"""The models' numbers against truths from outside: closed forms, tables of standards, other libraries."""

import math

import casadi as ca
import numpy as np
import pytest
from casadi import SX
from scipy.integrate import solve_ivp
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from scipy.special import j1

from ulna.checks.textbook import load_model

BODY, HINGE = load_model("rigid_body"), load_model("hinged_body")
SKIN, SENSOR = load_model("arm_skin"), load_model("ultrasonic_sensor")


def values_of(model, **given):
    """A model's symbols by number: those given, zero for the rest."""
    zeros = {name: np.zeros(symbol.numel()) for name, symbol in model.symbols().items()}
    numbers = zeros | {name: np.atleast_1d(np.asarray(value, float)) for name, value in given.items()}
    return {name: SX(ca.DM(number)) for name, number in numbers.items()}


def number(expression):
    """A constant expression as numbers."""
    return np.array(ca.evalf(expression)).ravel()


def test_a_symmetric_top_precesses_at_its_closed_form():
    """Without torque, w in body axes turns about the symmetry axis with (I3 - I1) / I1 w3 (Landau and Lifshitz, 36)."""
    inertia, spin, tilt = np.array([2.0, 2.0, 3.0]), 1.5, 0.4
    values = values_of(
        BODY, mass=1, inertia=inertia, orientation=[1, 0, 0, 0], angular_momentum=inertia * [tilt, 0, spin]
    )
    acceleration = number(BODY.equations(values)["angular_acceleration"])
    assert acceleration == pytest.approx([0, (3 - 2) / 2 * spin * tilt, 0], abs=1e-15)


def test_the_body_turns_as_scipy_turns():
    """A quaternion of length 1.7 that carries the tip, and a momentum, as scipy's rotations do."""
    q, tip, inertia, momentum = [0.2, -0.7, 1.1, 1.0], [0.3, -0.1, 0.5], np.array([1.0, 2.0, 2.5]), [0.4, 1.2, -0.6]
    turn = Rotation.from_quat(q, scalar_first=True).as_matrix()
    values = values_of(BODY, mass=1, inertia=inertia, orientation=q, tip=tip, angular_momentum=momentum)
    results = BODY.equations(values)
    assert number(results["tip_position"]) == pytest.approx(turn @ tip, abs=1e-15)
    expected = turn @ np.diag(1 / inertia) @ turn.T @ momentum
    assert number(results["angular_velocity"]) == pytest.approx(expected, abs=1e-15)


def test_a_physical_pendulum_falls_as_in_every_textbook():
    """(I + m l^2) d2a/dt2 = -m g l cos a for a rod that hangs along x at angle 0, axis -y; muscle off."""
    mass, length, about, angle = 1.5, 0.2, 0.03, 0.7
    values = values_of(
        HINGE, mass=mass, inertia=[0.01, about, about], center_of_mass=[length, 0, 0], axis=[0, -1, 0],
        gravity=[0, 0, -9.8], angle=angle, anchor_orientation=[1, 0, 0, 0],
    )  # fmt: skip
    expected = -mass * 9.8 * length * math.cos(angle) / (about + mass * length**2)
    assert number(HINGE.equations(values)["der(rate)"]) == pytest.approx([expected], rel=1e-14)


def test_a_pendulum_on_a_turntable_is_driven_outward():
    """Watt's governor: a point mass on an arm at angle a to the horizontal feels w^2 l^2 cos a sin a inward."""
    mass, length, speed, angle = 1.3, 0.4, 2.0, 0.6
    values = values_of(
        HINGE, mass=mass, inertia=[1e-300] * 3, center_of_mass=[length, 0, 0], axis=[0, -1, 0], angle=angle,
        anchor_orientation=[1, 0, 0, 0], anchor_angular_velocity=[0, 0, speed],
    )  # fmt: skip
    expected = -(speed**2) * math.cos(angle) * math.sin(angle)
    assert number(HINGE.equations(values)["der(rate)"]) == pytest.approx([expected], rel=1e-14)


def test_the_hinge_swings_as_a_maximal_coordinate_simulation():
    """Half a second against a free rigid body, one frame of which a stiff damped spring holds at the origin.

    The pull is at most 40 N, the spring gives way by 4e-7 m of .3 m: angles agree to some 1e-6 rad.
    """
    mass, inertia, center = 1.2, np.array([0.02, 0.05, 0.05]), np.array([0.3, 0.0, 0.0])
    body = ca.Function("body", *_free_body(mass, inertia, center))
    free = solve_ivp(
        lambda t, y: np.array(body(y)).ravel(), (0, 0.5), [*center, 1, 0, 0, 0, *np.zeros(6)], rtol=1e-9, atol=1e-10,
        method="LSODA",
    )  # fmt: skip
    given = {"mass": mass, "inertia": inertia, "center_of_mass": center, "gravity": [0, 0, -9.8]}
    y = SX.sym("y", 2)
    values = values_of(HINGE, **given, axis=[0, -1, 0], anchor_orientation=[1, 0, 0, 0])
    slope = HINGE.equations(values | {"angle": y[0], "rate": y[1]})
    hinge = ca.Function("hinge", [y], [ca.vertcat(slope["der(angle)"], slope["der(rate)"])])
    held = solve_ivp(lambda t, y: np.array(hinge(y)).ravel(), (0, 0.5), [0, 0], rtol=1e-10, atol=1e-12)
    fallen = math.atan2(free.y[2, -1], free.y[0, -1])
    assert fallen == pytest.approx(math.remainder(held.y[0, -1], 2 * math.pi), abs=5e-6)
    assert fallen < -0.5


def _free_body(mass, inertia, center):
    """A RigidBody whose frame `base` is tied to the origin by a stiff damped spring."""
    state = SX.sym("state", 13)
    places = {"position": state[:3], "orientation": state[3:7]}
    momenta = {"linear_momentum": state[7:10], "angular_momentum": state[10:]}
    values = values_of(BODY, mass=mass, inertia=inertia, gravity=[0, 0, -9.8], base=-center) | places | momenta
    loose = BODY.equations(values)
    force = -1e8 * loose["base_position"] - 3000 * loose["base_velocity"]
    tied = BODY.equations(values | {"base_force": force})
    names = ("position", "orientation", "linear_momentum", "angular_momentum")
    return [state], [ca.vertcat(*[tied[f"der({name})"] for name in names])]


def bent(angle, axis, **vertex):
    """An arm with its elbow at the origin, the forearm turned by an angle about an axis."""
    q = [math.cos(angle / 2), *(math.sin(angle / 2) * np.array(axis))]
    return values_of(
        SKIN, upper_arm_position=[-1, 0, 0], upper_arm_length=1, forearm_length=1, radius=0.1,
        upper_arm_orientation=[1, 0, 0, 0], forearm_orientation=q, **vertex,
    )  # fmt: skip


@pytest.mark.parametrize("angle", [0.5, 1.5, 3.0])
def test_a_twisted_section_collapses_by_linear_blend_and_not_by_dual_quaternions(angle):
    """At w = 1/2 the radius is r cos(theta / 2), or stays r."""
    results = SKIN.equations(bent(angle, [1, 0, 0], point=[0, 0.1, 0], weight=0.5))
    radius = np.linalg.norm(number(results["linear_blend_vertex"]))
    assert radius == pytest.approx(0.1 * math.cos(angle / 2), rel=1e-12)
    half = Rotation.from_rotvec([angle / 2, 0, 0]).apply([0, 0.1, 0])
    assert number(results["dual_quaternion_vertex"]) == pytest.approx(half, abs=1e-15)


def test_normals_are_those_of_differences_of_the_deformed_skin():
    """Central differences over 1e-5 m of points on the cylinder, the weight a smooth function of x: 1e-9."""
    step, place = 1e-5, np.array([0.02, 0.06, 0.08])

    def carried(point):
        weight = 0.5 + 4 * point[0]
        return number(SKIN.equations(bent(1.2, [0, -1, 0], point=point, weight=weight))["dual_quaternion_vertex"])

    sides = []
    for side in ([1, 0, 0], [0, 0.8, -0.6]):
        ahead, behind = place + step * np.array(side), place - step * np.array(side)
        sides.append((carried(ahead) - carried(behind)) / (2 * step))
    expected = np.cross(*sides)
    vertex = {"point": place, "weight": 0.5 + 4 * place[0], "weight_gradient": [4, 0, 0], "rest_normal": [0, 0.6, 0.8]}
    normal = number(SKIN.equations(bent(1.2, [0, -1, 0], **vertex))["dual_quaternion_normal"])
    assert abs(normal @ expected) / np.linalg.norm(expected) == pytest.approx(1, abs=1e-9)
    assert np.linalg.norm(np.cross(normal, expected)) < 1e-8 * np.linalg.norm(expected)


# ISO 9613-2, table 2: dB/km at 10 C and 70 %, 20 C and 70 %, 15 C and 20 %, for octave bands from 63 Hz to 8 kHz
ABSORPTION_TABLE = {
    (10, 0.70): (0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117.0),
    (20, 0.70): (0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6),
    (15, 0.20): (0.3, 0.6, 1.2, 2.7, 8.2, 28.2, 88.8, 202.0),
}


@pytest.mark.parametrize("air", ABSORPTION_TABLE)
def test_absorption_is_that_of_the_standards_table(air):
    """Its frequencies are 1000 times powers of 10^0.3; half a unit of the last printed digit (.1, or 1 above 100)."""
    celsius, humidity = air
    for band, printed in zip(range(-4, 4), ABSORPTION_TABLE[air], strict=True):
        air_now = {"temperature": celsius + 273.15, "humidity": humidity, "pressure": 101325.0}
        values = values_of(SENSOR, frequency=1000 * 10 ** (0.3 * band), **air_now)
        computed = 1000 * number(SENSOR.equations(values)["absorption_of_air"])[0]
        assert computed == pytest.approx(printed, abs=0.5 if printed > 100 else 0.051)


@pytest.mark.parametrize("celsius", [0, 10, 20, 30])
def test_speed_of_sound_in_dry_air_is_that_of_an_ideal_gas(celsius):
    """sqrt(gamma R T / M) with gamma 1.4 and M 28.966 g/mol: real air is within .1 % of it from 0 to 30 C."""
    kelvin = celsius + 273.15
    speed = number(SENSOR.equations(values_of(SENSOR, temperature=kelvin, pressure=101325.0))["speed_of_sound_in_air"])[
        0
    ]
    assert speed == pytest.approx(math.sqrt(1.4 * 8.314462618 * kelvin / 0.028966), rel=1e-3)


def test_the_beam_is_scipys_bessel_function():
    for argument in (0.3, 2.0, 5.0, 7.8):
        beam = SENSOR.equations(values_of(SENSOR, half_argument_squared=argument**2 / 4))["piston_directivity"]
        assert number(beam)[0] == pytest.approx(2 * j1(argument) / argument, abs=1e-12)


def test_decibels_are_those_of_a_logarithm_to_base_10():
    amplitude = SENSOR.equations(values_of(SENSOR, threshold=20.0))["initial(threshold_amplitude)"]
    assert number(amplitude)[0] == pytest.approx(10.0, rel=1e-15)


def test_the_path_by_a_ball_is_the_shortest_that_an_optimiser_finds():
    """A ball at rest, the mirror point over two angles by Nelder and Mead; the time to 1e-12."""
    transmitter, receiver, center, radius = (
        np.array([0, 0.3, 0]),
        np.array([0, -0.2, 0.1]),
        np.array([2, 0.4, 0.3]),
        0.5,
    )

    def way(angles):
        up, side = angles
        out = np.array([-math.cos(up) * math.cos(side), math.cos(up) * math.sin(side), math.sin(up)])
        point = center + radius * out
        return np.linalg.norm(point - transmitter) + np.linalg.norm(receiver - point)

    shortest = minimize(way, [0, 0], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-15}).fun
    values = values_of(
        SENSOR, transmitter=transmitter, receiver=receiver, ball_center=center, ball_radius=radius, speed=1,
        path_share=0.5, path_time=4, path_bounce_time=2,
    )  # fmt: skip
    for _ in range(5):
        share = SENSOR.equations(values)["ball_path_refined.share"]
        values["path_share"] = SX(ca.evalf(share))
    time = number(SENSOR.equations(values)["ball_path_refined.time"])[0]
    assert time == pytest.approx(shortest, rel=1e-12)
