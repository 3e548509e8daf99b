"""Two free bodies that CompliantJoint makes an arm, by both masters."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from ulna import Results, Scene, UnitError

DECLARATION = tomllib.loads((Path(__file__).parents[2] / "fmus/compliant_joint/unit.toml").read_text())
START = {name: entry["start"] for name, entry in DECLARATION["parameter"].items()}
AXIS = np.array(START["axis"])
MASTERS = ("gauss_seidel", "jacobi")
ROUND_OFF = float(np.finfo(float).eps)

UPPER_ARM = {"mass": 1.9, "inertia": [0.0038, 0.0135, 0.0145], "base": [-0.15, 0, 0], "tip": [0.15, 0, 0]}
FOREARM = {"mass": 1.561, "inertia": [0.001664, 0.020226, 0.021105], "base": [-0.179, 0, 0]}


SPINS = {"upper": np.array([0.5, -2.0, 0.7]), "fore": np.array([-1.0, -6.0, 1.5])}  # rad/s


def flung_arm(master: str, step: float, until: float = 0.25, order: tuple = ("upper", "fore", "elbow")) -> Results:
    """Upper arm and forearm in free flight, straight at the start, the elbow at rest, each with a spin of its own."""
    scene = Scene("arm")
    for name in order:
        if name == "elbow":
            scene.add("CompliantJoint", name)
            continue
        values, center = (UPPER_ARM, [-0.15, 0, 0]) if name == "upper" else (FOREARM, [0.179, 0, 0])
        start = {
            "initial_position": center,
            "initial_velocity": np.cross(SPINS[name], center),
            "initial_angular_velocity": SPINS[name],
        }
        scene.add("RigidBody", name, gravity=[0, 0, 0], **values, **start)
    scene.connect(scene["upper"].tip, scene["elbow"].first)
    scene.connect(scene["elbow"].second, scene["fore"].base)
    with scene:
        return scene.run(until, step, master=master)


def total(results: Results, name: str) -> np.ndarray:
    """Sum over both bodies."""
    return results[f"upper.{name}"] + results[f"fore.{name}"]


def angular_momentum(results: Results) -> np.ndarray:
    """Of both bodies about the origin."""
    orbits = [np.cross(results[f"{b}.position"], results[f"{b}.linear_momentum"]) for b in ("upper", "fore")]
    return sum(orbits) + total(results, "angular_momentum")


@pytest.mark.parametrize("master", MASTERS)
def test_arm_keeps_its_momentum_to_round_off(master: str) -> None:
    momentum = total(flung_arm(master, 5e-4), "linear_momentum")
    # 500 steps, each some roundings of momenta of 2 kg m/s
    assert np.abs(momentum - momentum[0]).max() < 500 * 4 * ROUND_OFF * 2


def test_the_order_in_which_units_are_added_does_not_matter_to_gauss_seidel() -> None:
    """Both bodies step before the joint: between them it would give each the wrench of another time."""
    for order in (("upper", "elbow", "fore"), ("elbow", "upper", "fore"), ("fore", "upper", "elbow")):
        momentum = total(flung_arm("gauss_seidel", 5e-4, order=order), "linear_momentum")
        assert np.abs(momentum - momentum[0]).max() < 500 * 4 * ROUND_OFF * 2


def mobility(body: dict, lever: float) -> np.ndarray:
    """Accelerations of a frame on the bone, linear then angular, by a unit force or torque there; 6x6, at rest."""
    shift = np.cross(np.eye(3), [lever, 0, 0])  # the torque of a force: l x F = shift @ F
    turning = np.diag(1 / np.array(body["inertia"]))
    linear = np.eye(3) / body["mass"] + shift.T @ turning @ shift
    return np.block([[linear, shift.T @ turning], [turning @ shift, turning]])


def growth(master: str, step: float) -> float:
    """Largest factor a step of small errors of the straight arm at rest, those of the free axis aside."""
    response = mobility(UPPER_ARM, 0.15) + mobility(FOREARM, -0.179)
    across = np.diag([1.0, 0.0, 1.0])
    spring, damper = (
        np.block([[START[name] * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), START[f"angular_{name}"] * across]])
        for name in ("stiffness", "damping")
    )
    free = np.block([[np.eye(6), step * np.eye(6)], [np.zeros((6, 6)), np.eye(6)]])
    pushed = np.vstack([step**2 / 2 * response, step * response])
    wrench = -np.hstack([spring, damper])
    late = np.block([[free, pushed], [wrench, np.zeros((6, 6))]])
    sizes = np.abs(np.linalg.eigvals(free + pushed @ wrench if master == "gauss_seidel" else late))
    return sizes[np.abs(sizes - 1) > 1e-6].max()


@pytest.mark.parametrize(("master", "limit"), [("gauss_seidel", 2.26e-3), ("jacobi", 0.75e-3)])
def test_default_joint_holds_an_arm_up_to_the_step_of_linear_theory(master: str, limit: float) -> None:
    assert growth(master, 0.99 * limit) < 1 < growth(master, 1.01 * limit)
    # 10 % off it errors change by some percent a step; beyond it RigidBody gives up where the arm shakes apart
    gap = flung_arm(master, 0.9 * limit, until=1.0)["elbow.displacement"]
    assert np.abs(gap[-20:]).max() < np.abs(gap[:100]).max() < 1e-3
    with pytest.raises(UnitError):
        flung_arm(master, 1.1 * limit, until=2.0)


def test_angular_momentum_is_lost_only_to_frames_that_part_within_a_step() -> None:
    """Forces of a step's start act where the frames then go: h^2 / 2 (v2 - v1) x F a step, but for order 3."""

    def missing(step: float) -> tuple[float, float]:
        results = flung_arm("gauss_seidel", step)
        parting = results["fore.base_velocity"] - results["upper.tip_velocity"]
        lost = np.cross(parting, results["elbow.second_force"])[:-1].sum(axis=0) * step**2 / 2
        change = np.diff(angular_momentum(results)[[0, -1]], axis=0)[0]
        return np.linalg.norm(change), np.linalg.norm(change - lost)

    (coarse, coarse_rest), (fine, fine_rest) = missing(5e-4), missing(2.5e-4)
    assert math.log2(coarse / fine) == pytest.approx(1, abs=0.2)
    assert math.log2(coarse_rest / fine_rest) > 1.8
    assert fine_rest < 0.05 * fine


@pytest.mark.parametrize("master", MASTERS)
def test_energy_falls_by_what_the_joint_dissipates_to_first_order(master: str) -> None:
    def balance(step: float) -> tuple[float, float]:
        results = flung_arm(master, step)
        energy = total(results, "kinetic_energy") + results["elbow.potential_energy"]
        lost = np.trapezoid(results["elbow.dissipation"], results.time)
        return energy[-1] - energy[0], energy[-1] - energy[0] + lost

    (change, coarse), (_, fine) = balance(2.5e-4), balance(1.25e-4)
    assert change < 0.0
    assert abs(coarse) < 0.5 * abs(change)
    assert math.log2(coarse / fine) == pytest.approx(1, abs=0.3)


def test_elbow_of_the_arm_bends_about_its_axis_and_gives_way_as_its_springs_say() -> None:
    results = flung_arm("gauss_seidel", 5e-4)
    turns = [Rotation.from_quat(np.roll(results[f"{b}.orientation"], -1, axis=1)) for b in ("upper", "fore")]
    assert (turns[0].inv() * turns[1]).as_rotvec()[-1] @ AXIS > 0.5
    # the springs hold no more than the energy at the start
    energy = total(results, "kinetic_energy")[0]
    chord = np.linalg.norm(turns[0].apply(AXIS) - turns[1].apply(AXIS), axis=1).max()
    assert 1e-3 < chord < math.sqrt(2 * energy / START["angular_stiffness"])
    # where the gap is largest it does not change, so that braking stands across the pull of the spring
    force = np.linalg.norm(results["elbow.second_force"], axis=1).max()
    gap = np.linalg.norm(results["elbow.displacement"], axis=1).max()
    assert 1e-5 < gap < force / START["stiffness"]


@pytest.mark.parametrize("master", MASTERS)
def test_forearm_on_a_stiff_joint_swings_as_on_a_hinge_but_for_order_one_in_the_compliance(master: str) -> None:
    mass, lever, weight, end = FOREARM["mass"], 0.179, 9.80665, 1.0
    moment = FOREARM["inertia"][1] + mass * lever**2
    swing = solve_ivp(
        lambda _, y: [y[1], -mass * weight * lever * math.cos(y[0]) / moment],
        (0, end),
        [0.0, 0.0],
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
    ).y

    def angle(stiffness: float) -> tuple[float, float]:
        """At the end, and the largest give of the joint (m)."""
        scene = Scene("pendulum")
        body = scene.add("RigidBody", "body", initial_position=[lever, 0, 0], **FOREARM)
        hinge = scene.add("CompliantJoint", "hinge", stiffness=stiffness, damping=2e-3 * stiffness)
        scene.connect(hinge.second, body.base)
        with scene:
            results = scene.run(end, 1.25e-4, master=master)
        w, _, y, _ = results["body.orientation"][-1]
        return -2 * math.atan2(y, w), np.linalg.norm(results["hinge.displacement"], axis=1).max()

    (soft, _), (stiff, give) = angle(1e4), angle(1e5)
    exact = swing[0, -1]
    assert math.log10((soft - exact) / (stiff - exact)) == pytest.approx(1, abs=0.05)
    # a pendulum longer by the give is late by half of that share of its length, on a way of some 2.5 rad and back
    way = np.abs(np.diff(swing[0])).sum()
    assert abs(stiff - exact) < 2 * give / (moment / mass / lever) * way
