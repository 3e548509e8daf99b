"""CompliantJoint against springs, dampers and the slopes of their energy; and what coupling makes of them."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ulna import Results, Scene, Slave, UnitError

DECLARATION = tomllib.loads((Path(__file__).parents[2] / "fmus/compliant_joint/unit.toml").read_text())
START = {name: entry["start"] for name, entry in DECLARATION["parameter"].items()}
AXIS = np.array(START["axis"])
SKEW_AXIS = np.array([0.48, -0.6, 0.64])
VERSIONS = ("2.0", "3.0")
MASTERS = ("gauss_seidel", "jacobi")
ROUND_OFF = float(np.finfo(float).eps)


def joint(parameters: dict | None = None, version: str = "3.0", **inputs) -> Slave:
    """A joint with these parameters and inputs, initialized at t = 0."""
    unit = Slave("CompliantJoint", version=version)
    for name, value in ((parameters or {}) | inputs).items():
        unit.set(name, value)
    unit.initialize(start=0.0)
    return unit


def quaternion(turn: Rotation) -> np.ndarray:
    """w, x, y, z"""
    return np.roll(turn.as_quat(), 1)


def random_inputs(seed: int) -> dict[str, np.ndarray]:
    """Two frames in any attitude, less than a metre apart, that move."""
    random = np.random.default_rng(seed)
    inputs = {}
    for body in ("first", "second"):
        for name in ("position", "velocity", "angular_velocity"):
            inputs[f"{body}_{name}"] = random.uniform(-0.5, 0.5, 3)
        inputs[f"{body}_orientation"] = quaternion(Rotation.random(rng=random))
    return inputs


# --- one joint: springs, dampers, energy ---


@pytest.mark.parametrize("version", VERSIONS)
def test_nothing_connected_and_nothing_moved_gives_nothing(version: str) -> None:
    with joint(version=version) as unit:
        unit.step(0.0, 0.01)
        for name in DECLARATION["output"]:
            assert not np.any(unit.get(name)), name


@pytest.mark.parametrize("version", VERSIONS)
def test_linear_spring_and_damper_pull_second_back_and_first_along(version: str) -> None:
    place, velocity = np.array([0.001, -0.002, 0.0005]), np.array([0.02, 0.03, -0.01])
    with joint(version=version, second_position=place, second_velocity=velocity) as unit:
        force = -START["stiffness"] * place - START["damping"] * velocity
        np.testing.assert_allclose(unit.get("second_force"), force, rtol=4 * ROUND_OFF)
        np.testing.assert_array_equal(unit.get("first_force"), -np.array(unit.get("second_force")))
        # half of the moment of braking on either: the force acts half way
        moment = np.cross(place, START["damping"] * velocity) / 2
        for body in ("first", "second"):
            np.testing.assert_allclose(unit.get(f"{body}_torque"), moment, rtol=1e-12)
        assert unit.get("potential_energy") == pytest.approx(START["stiffness"] * place @ place / 2, rel=1e-15)
        assert unit.get("dissipation") == pytest.approx(START["damping"] * velocity @ velocity, rel=1e-15)
        np.testing.assert_array_equal(unit.get("displacement"), place)


@pytest.mark.parametrize("angle", [1e-9, 0.3, math.pi / 2, 3.0])
def test_axes_apart_are_turned_back_by_stiffness_times_the_sine(angle: float) -> None:
    across = np.array([0.0, 0.0, 1.0])
    with joint(second_orientation=quaternion(Rotation.from_rotvec(angle * across))) as unit:
        # round-off of the quaternion, which is of size 1
        limit = 4 * ROUND_OFF * START["angular_stiffness"]
        torque = -START["angular_stiffness"] * math.sin(angle) * across
        np.testing.assert_allclose(unit.get("second_torque"), torque, atol=limit)
        np.testing.assert_allclose(unit.get("first_torque"), -torque, atol=limit)
        np.testing.assert_allclose(unit.get("misalignment"), math.sin(angle) * across, atol=4 * ROUND_OFF)
        # 1 - cos, whose digits a small angle would lose
        energy = 2 * START["angular_stiffness"] * math.sin(angle / 2) ** 2
        assert unit.get("potential_energy") == pytest.approx(energy, rel=8 * ROUND_OFF / min(angle, 1.0))


def test_half_a_turn_across_the_axis_is_a_balance_without_torque() -> None:
    """A known limit: 1 - cos is flat there."""
    with joint(second_orientation=[0.0, 0.0, 0.0, 1.0]) as unit:
        assert not np.any(unit.get("second_torque"))
        assert unit.get("potential_energy") == 2 * START["angular_stiffness"]


@pytest.mark.parametrize("seed", range(3))
def test_wrenches_of_the_springs_are_the_slope_of_their_energy(seed: int) -> None:
    parameters = {"stiffness": 3.0, "angular_stiffness": 2.0, "axis": SKEW_AXIS}
    still = {name: value for name, value in random_inputs(seed).items() if "velocity" not in name}
    turns = {b: Rotation.from_quat(np.roll(still[f"{b}_orientation"], -1)) for b in ("first", "second")}

    def energy(body: str, shift: np.ndarray, turn: np.ndarray) -> float:
        """Half of stiffness times length squared, and 1 - cos of the angle between the axes."""
        ends = {b: still[f"{b}_position"] + (shift if b == body else 0.0) for b in turns}
        axes = [(Rotation.from_rotvec(turn) * q if b == body else q).apply(SKEW_AXIS) for b, q in turns.items()]
        angle = 2 * math.atan2(np.linalg.norm(axes[0] - axes[1]), np.linalg.norm(axes[0] + axes[1]))
        length = np.linalg.norm(ends["second"] - ends["first"])
        return parameters["stiffness"] * length**2 / 2 + parameters["angular_stiffness"] * (1 - math.cos(angle))

    h = 1e-4  # off by h^2 / 6 of the third derivative, 2, and by round-off of 2 over h
    with joint(parameters, **still) as unit:
        assert unit.get("potential_energy") == pytest.approx(energy("first", np.zeros(3), np.zeros(3)), rel=1e-14)
        for body in turns:
            for k, step in enumerate(h * np.eye(3)):
                none = np.zeros(3)
                force = (energy(body, -step, none) - energy(body, step, none)) / (2 * h)
                torque = (energy(body, none, -step) - energy(body, none, step)) / (2 * h)
                assert unit.get(f"{body}_force")[k] == pytest.approx(force, abs=1e-8)
                assert unit.get(f"{body}_torque")[k] == pytest.approx(torque, abs=1e-8)


def test_what_is_out_of_place_is_seen_from_the_first_frame() -> None:
    inputs = random_inputs(5)
    first, second = (Rotation.from_quat(np.roll(inputs[f"{b}_orientation"], -1)) for b in ("first", "second"))
    apart = first.inv().apply(inputs["second_position"] - inputs["first_position"])
    tilt = np.cross(SKEW_AXIS, (first.inv() * second).apply(SKEW_AXIS))
    with joint({"axis": SKEW_AXIS}, **inputs) as unit:
        np.testing.assert_allclose(unit.get("displacement"), apart, atol=8 * ROUND_OFF)
        np.testing.assert_allclose(unit.get("misalignment"), tilt, atol=8 * ROUND_OFF)


@pytest.mark.parametrize("seed", range(3))
def test_wrenches_balance_and_take_the_dissipation_from_bodies_that_move_as_one_shape(seed: int) -> None:
    inputs = random_inputs(seed)
    with joint({"axis": SKEW_AXIS, "friction": 0.7}, **inputs) as unit:
        wrench = {name: np.array(unit.get(name)) for name in DECLARATION["output"] if name[0] in "fs"}
        moments = [np.cross(inputs[f"{b}_position"], wrench[f"{b}_force"]) for b in ("first", "second")]
        size = sum(np.abs(v).max() for v in (*wrench.values(), *moments))
        assert np.all(wrench["first_force"] + wrench["second_force"] == 0.0)
        total = sum(moments) + wrench["first_torque"] + wrench["second_torque"]
        np.testing.assert_allclose(total, 0.0, atol=4 * ROUND_OFF * size)
        springs = joint({"axis": SKEW_AXIS}, **{n: v for n, v in inputs.items() if "velocity" not in n})
        with springs:
            power = 0.0
            for body in ("first", "second"):
                force = wrench[f"{body}_force"] - springs.get(f"{body}_force")
                torque = wrench[f"{body}_torque"] - springs.get(f"{body}_torque")
                power += force @ inputs[f"{body}_velocity"] + torque @ inputs[f"{body}_angular_velocity"]
        assert unit.get("dissipation") > 0.0
        # forces of 1e5 N cancel in the difference
        assert -power == pytest.approx(unit.get("dissipation"), abs=8 * ROUND_OFF * size)


def test_hinge_turned_by_any_angle_feels_friction_only() -> None:
    turn, rate, friction = Rotation.from_rotvec([0.4, -0.2, 0.9]), 5.0, 0.25
    axis = turn.apply(SKEW_AXIS)
    for angle in (0.0, 1.0, 3.0, -2.0):
        second = turn * Rotation.from_rotvec(angle * SKEW_AXIS)
        inputs = {
            "first_orientation": quaternion(turn),
            "second_orientation": quaternion(second),
            "second_angular_velocity": rate * axis,
        }
        for brake in (0.0, friction):
            with joint({"axis": SKEW_AXIS, "friction": brake}, **inputs) as unit:
                # axes of length 1 agree to some roundings, which stiffness multiplies
                limit = 8 * ROUND_OFF * START["angular_stiffness"]
                np.testing.assert_allclose(unit.get("second_torque"), -brake * rate * axis, atol=limit)
                assert unit.get("dissipation") == pytest.approx(brake * rate**2, abs=1e-25)


def test_damping_across_the_axis_and_friction_along_it_do_not_mix() -> None:
    across, rate = np.array([0.6, 0.0, 0.8]), np.array([0.3, -0.7, 0.2])
    with joint({"friction": 0.25, "angular_damping": 2.0}, second_angular_velocity=rate) as unit:
        along = (rate @ AXIS) * AXIS
        np.testing.assert_allclose(unit.get("second_torque"), -0.25 * along - 2.0 * (rate - along), rtol=1e-14)
    with joint(second_angular_velocity=across) as unit:
        np.testing.assert_allclose(unit.get("first_torque"), START["angular_damping"] * across, rtol=1e-14)


def test_ball_joint_has_no_torque_and_with_even_damping_no_axis() -> None:
    inputs = random_inputs(4)
    inputs |= {"second_position": inputs["first_position"], "second_velocity": inputs["first_velocity"]}
    rate = inputs["second_angular_velocity"] - inputs["first_angular_velocity"]
    for damping in (0.0, 0.6):
        ball = {"angular_stiffness": 0.0, "angular_damping": damping, "friction": damping}
        with joint(ball, **inputs) as unit:
            np.testing.assert_allclose(unit.get("second_torque"), -damping * rate, rtol=1e-13)
            assert not np.any(unit.get("second_force"))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("axis", [0.0, 0.0, 0.0]),
        ("axis", [0.0, -1.0, 1e-4]),
        ("axis", [1e200, 0.0, 0.0]),
        ("axis", [math.nan, -1.0, 0.0]),
        ("stiffness", -1.0),
        ("damping", -1e-9),
        ("angular_stiffness", math.inf),
        ("angular_damping", -0.1),
        ("friction", -0.1),
        ("first_orientation", [0.0, 0.0, 0.0, 0.0]),
        ("second_orientation", [0.1, 0.1, 0.1, 0.1]),
        ("second_position", [0.0, math.nan, 0.0]),
        ("first_angular_velocity", [0.0, 0.0, -math.inf]),
    ],
)
def test_what_makes_no_joint_is_refused_with_its_name(version: str, name: str, value) -> None:
    with Slave("CompliantJoint", version=version) as unit, pytest.raises(UnitError, match=rf"{name}.*allowed range"):
        unit.set(name, value)
        unit.initialize(start=0.0)


# --- a mass on the joint: what the coupling does to a spring ---

MASS = 0.5  # kg


def pulled_mass(master: str, step: float, steps: int, stiffness: float, damping: float) -> Results:
    """A body that the joint ties to the world, 1 mm off at the start, without weight."""
    scene = Scene("spring")
    body = scene.add("RigidBody", "body", mass=MASS, gravity=[0, 0, 0], initial_position=[1e-3, 0, 0])
    tie = scene.add("CompliantJoint", "tie", stiffness=stiffness, damping=damping)
    scene.connect(tie.second, body.base)
    with scene:
        return scene.run(steps * step, step, master=master)


@pytest.mark.parametrize("master", MASTERS)
def test_a_mass_moves_as_the_force_held_over_each_step_says(master: str) -> None:
    """x and v one step on under a force that is constant, of the state now or, by jacobi, of the state before."""
    step, steps, stiffness, damping = 1e-3, 200, 2e4, 60.0
    results = pulled_mass(master, step, steps, stiffness, damping)
    x, v, held = 1e-3, 0.0, -stiffness * 1e-3
    for row in range(steps):
        now = -stiffness * x - damping * v
        force, held = (now, now) if master == "gauss_seidel" else (held, now)
        x, v = x + step * v + step**2 * force / MASS / 2, v + step * force / MASS
        # a few roundings of the start a step
        assert results["body.position"][row + 1, 0] == pytest.approx(x, abs=4 * (row + 1) * ROUND_OFF * 1e-3)


def dampings_at_the_limit(master: str, step: float, stiffness: float) -> tuple[float, float]:
    """Least and largest stable damping (N s/m): h k / 2 < c < 2 m / h at once; a step late, see the unit's README."""
    if master == "gauss_seidel":
        return step * stiffness / 2, 2 * MASS / step
    tightness = step**2 * stiffness / MASS
    root = math.sqrt(1 - 4 * tightness)
    return tuple(MASS / step * (tightness + 1 + sign * root) / 2 for sign in (-1, 1))


@pytest.mark.parametrize("master", MASTERS)
@pytest.mark.parametrize("limit", [0, 1])
def test_damping_is_stable_between_its_two_limits_and_not_beyond(master: str, limit: int) -> None:
    step, stiffness, steps = 1e-3, 0.2 * MASS / 1e-3**2, 2000
    damping = dampings_at_the_limit(master, step, stiffness)[limit]
    inside, outside = (0.98, 1.02) if limit else (1.02, 0.98)
    for factor, stable in ((inside, True), (outside, False)):
        position = pulled_mass(master, step, steps, stiffness, factor * damping)["body.position"][:, 0]
        # 2 % off the limit, a mode grows or falls by 1e-3 a step or more, e^2 over 2000
        assert (np.abs(position[-50:]).max() < np.abs(position[:50]).max()) == stable


@pytest.mark.parametrize("master", MASTERS)
def test_spring_stiffer_than_a_quarter_of_mass_over_step_squared_has_no_stable_damping_by_jacobi(master: str) -> None:
    step, stiffness = 1e-3, 0.26 * MASS / 1e-3**2
    for share in (0.2, 0.4, 0.6, 0.63, 0.7, 0.9):
        position = pulled_mass(master, step, 3000, stiffness, share * MASS / step)["body.position"][:, 0]
        assert (np.abs(position[-50:]).max() < 1e-3) == (master == "gauss_seidel")
