"""Stable but wrong: what a run creates of energy, and what the watch says of it."""

import math
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sprung_fmu import sprung
from ulna.scene import Scene
from ulna.stability import coupling_theory as theory
from ulna.stability.oscillator import STEP, parameters
from ulna.watch import SHARE, CouplingWarning

HELD = ("jacobi_order_0", "gauss_seidel_order_0")


@pytest.mark.parametrize("master", HELD)
def test_the_watch_finds_the_energy_that_a_held_wrench_creates(coupled, master):
    """To the leading order in H: off by some z of it, the more the steps leave of a swing."""
    for row in [row for row in coupled["energies"] if row["master"] == master]:
        assert row["watched"] == pytest.approx(row["created"], rel=0.005 + 0.15 * row["z"]), row
        assert row["created"] > 0.0
        if abs(row["created"] / row["system"] / SHARE - 1.0) > 0.1:
            assert row["wrong"] == (row["created"] > SHARE * row["system"]), row
        assert row["warned"] >= row["wrong"]


@pytest.mark.parametrize("master", ["jacobi_order_1", "gauss_seidel_order_1", "iterated", "newton"])
def test_the_watch_finds_what_lines_create_to_a_tenth(coupled, master):
    """Of order 2 in H; what is below a millionth of the energy is the next order's."""
    for row in [row for row in coupled["energies"] if row["master"] == master]:
        assert row["watched"] == pytest.approx(row["created"], rel=0.1, abs=1e-6 * row["system"]), row


def test_the_drawn_run_is_stable_wrong_and_flagged_and_newton_is_right(coupled):
    """The joint seems to have 0.28 of its damper: 1 - 3/2 H (k/c - c/m) = 1 - 3/4 (1 - 4 zeta^2) for z = zeta."""
    swings = {row["master"]: np.array(row["distance"]) for row in coupled["swings"]}
    true = swings.pop("")
    *masses, k, c = parameters(0.1, 0.1)
    assert theory.effective_joint("jacobi_order_0", *masses, k, c, STEP)[1] == pytest.approx(0.28 * c, rel=1e-9)
    assert theory.growth("jacobi_order_0", *masses, k, c, STEP) < 0.0
    assert np.abs(swings["jacobi_order_0"] - true).max() > 0.4
    assert np.abs(swings["jacobi_order_0"]).max() < 1.5
    assert np.abs(swings["newton"] - true).max() < 0.01


def test_newton_and_iterated_create_little_and_are_not_flagged(coupled):
    rows = [row for row in coupled["energies"] if row["master"] in ("iterated", "newton") and row["z"] < 0.4]
    assert len(rows) == 6
    for row in rows:
        assert abs(row["created"]) < SHARE * row["system"]
        assert not row["wrong"] and not row["warned"]


CARRIER, LOAD = 0.8, 0.35  # kg
STIFFNESS, DAMPING = 1e5, 50.0
MASTERS = pytest.mark.parametrize("master", ["jacobi", "gauss_seidel"])


def watched(scene, until, H, **how):
    """Results, and whether it was said while the run went on that the coupling makes it wrong."""
    with scene, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        results = scene.run(until, H, **how)
    return results, [str(w.message) for w in caught if issubclass(w.category, CouplingWarning)]


def carried(H, until=0.1, k=STIFFNESS, c=DAMPING, **how):
    """A body that carries another, which holds spring and damper: both at 1 m/s, nothing to slow or drive them."""
    scene = Scene()
    carrier = scene.add(
        "RigidBody", "carrier", mass=CARRIER, gravity=[0.0] * 3, initial_velocity=[1.0, 0.0, 0.0], solver="rk4"
    )
    load = scene.add(sprung(), "load", mass=LOAD, stiffness=k, damping=c, initial_velocity=[1.0, 0.0, 0.0])
    scene.connect(carrier.tip, load.anchor)
    return watched(scene, until, H, **how)


def energy(results, unit, frame, k, c, weight=0.0, friction=0.0):
    """Energy (J) of both units with the spring as it is, and what damper and friction have taken, at every row."""
    apart, parting = (results[f"load.{x}"] - results[f"{unit}.{frame}_{x}"] for x in ("position", "velocity"))
    total = results[f"{unit}.kinetic_energy"] + results["load.kinetic_energy"] + k / 2 * np.sum(apart**2, axis=1)
    total += results[f"{unit}.potential_energy"] + weight * results["load.position"][:, 2]
    power = c * np.sum(parting**2, axis=1)
    if friction:
        power += friction * results[f"{unit}.rate"] ** 2
    lost = np.append(0.0, np.cumsum(np.diff(results.time) * (power[1:] + power[:-1]) / 2))
    return total + lost - total[0]


@MASTERS
@pytest.mark.parametrize(("H", "bound"), [(1e-3, 5e-3), (1e-4, 5e-4)])
def test_a_spring_inside_a_unit_pushes_both_by_half_the_stiffness_times_the_step(master, H, bound):
    """The reaction is read while the anchor stands where it was a step ago: k v H too much, on what carries it. The
    load feels k v t over the step, k v H / 2 in the mean. So both gain k H v^2 / 2, v of their centre."""
    results, said = carried(H, master=master)
    created = energy(results, "carrier", "tip", STIFFNESS, DAMPING)
    speed = (CARRIER * results["carrier.velocity"] + LOAD * results["load.velocity"])[:, 0] / (CARRIER + LOAD)
    late = slice(len(speed) // 2, None)  # once the spring has taken its length
    expected = np.trapezoid(STIFFNESS * H / 2 * speed[late] ** 2, dx=H)
    assert created[-1] - created[late][0] == pytest.approx(expected, rel=bound)
    assert said and "gained" in said[0]
    assert results.summary["wrong"]


@MASTERS
@pytest.mark.parametrize(("H", "k", "c"), [(1e-3, 1e5, 50.0), (1e-3, 1e4, 50.0), (1e-4, 1e5, 200.0), (1e-4, 1e4, 20.0)])
def test_the_watch_finds_the_energy_of_a_spring_inside_a_unit(master, H, k, c):
    results, said = carried(H, k=k, c=c, master=master)
    created = energy(results, "carrier", "tip", k, c)[-2]
    # off by some H sqrt(k/m) squared, or by the jerk that the damper makes of the growth
    bound = 0.02 + 0.1 * H**2 * k * (1 / CARRIER + 1 / LOAD)
    assert results.summary["coupling_energy"] == pytest.approx(created, rel=bound)
    assert said


def test_a_unit_with_a_spring_is_right_with_newton_and_a_short_step():
    results, said = carried(1e-4, master="newton")
    assert results["carrier.velocity"][-1, 0] == pytest.approx(1.0, abs=2e-3)
    assert abs(energy(results, "carrier", "tip", STIFFNESS, DAMPING)[-1]) < SHARE * results.summary["system_energy"]
    assert not said and not results.summary["wrong"]


UPPER = {"mass": 1.9, "inertia": [0.0037, 0.0106, 0.0119], "center_of_mass": [0.16, 0.0, 0.0]}
REACH, MOMENT, WEIGHT = 0.28, 0.0106 + 1.9 * 0.16**2, 9.80665


def arm(H, friction, until=1.0, **how):
    """An upper arm that is let go level, with the load on its tip."""
    scene = Scene()
    upper = scene.add(
        "HingedBody",
        "upper",
        tip=[REACH, 0.0, 0.0],
        stiffness=0.0,
        damping=0.0,
        friction=friction,
        solver="rk4",
        **UPPER,
    )
    start = {"initial_position": [REACH, 0.0, 0.0], "gravity": [0.0, 0.0, -WEIGHT]}
    load = scene.add(sprung(), "load", mass=LOAD, stiffness=STIFFNESS, damping=DAMPING, **start)
    scene.connect(upper.tip, load.anchor)
    results, said = watched(scene, until, H, **how)
    created = energy(results, "upper", "tip", STIFFNESS, DAMPING, LOAD * WEIGHT, friction)[-2]
    return results, said, created


def true_angle(times, friction):
    """The same arm in one piece."""

    def slope(_, y):
        angle, rate, x, z, u, w = y
        tip, speed = REACH * np.array([math.cos(angle), math.sin(angle)]), REACH * rate
        pull = STIFFNESS * (np.array([x, z]) - tip)
        pull += DAMPING * (np.array([u, w]) - speed * np.array([-math.sin(angle), math.cos(angle)]))
        torque = tip[0] * pull[1] - tip[1] * pull[0] - 1.9 * WEIGHT * 0.16 * math.cos(angle) - friction * rate
        return [rate, torque / MOMENT, u, w, -pull[0] / LOAD, -pull[1] / LOAD - WEIGHT]

    start = [0.0, 0.0, REACH, 0.0, 0.0, 0.0]
    return solve_ivp(slope, (0.0, times[-1]), start, method="Radau", t_eval=times, rtol=1e-7, atol=1e-9).y[0]


def error(results, friction):
    return np.abs(results["upper.angle"] - true_angle(results.time, friction)).max()


def test_the_treacherous_case_stays_finite_is_wrong_by_more_than_a_radian_and_is_flagged():
    """k = 1e5, c = 50, H = 1 ms: the thrust of k H / 2 takes 3.9 of the 4.5 N m s/rad of friction away."""
    friction = 4.5
    assert pytest.approx(3.92) == STIFFNESS * STEP / 2 * REACH**2
    results, said, created = arm(STEP, friction, master="jacobi")
    assert np.all(np.isfinite(results["upper.angle"])) and np.abs(results["upper.rate"]).max() < 5.0
    assert error(results, friction) > 1.0
    assert results.summary["coupling_energy"] == pytest.approx(created, rel=0.05)
    assert results.summary["wrong"] and len(said) == 1
    # it says so long before the end
    assert float(said[0].split("t = ")[1].split(" s")[0]) < 0.5


@pytest.mark.parametrize(
    ("H", "friction", "wrong"),
    [(1e-3, 10.0, 0.1), (1e-4, 1.0, 0.3), (1e-4, 4.5, 0.05), (2e-5, 0.0, 1.0), (2e-5, 3.0, 0.01)],
)
def test_short_steps_and_strong_friction_are_flagged_as_long_as_they_are_wrong(H, friction, wrong):
    results, said, created = arm(H, friction, master="jacobi")
    assert error(results, friction) > wrong
    # a swing that gains is off in the watch's eyes by as much as it gains in a step
    assert results.summary["coupling_energy"] == pytest.approx(created, rel=0.03)
    assert results.summary["wrong"] and said


@pytest.mark.parametrize(
    ("master", "H", "friction"), [("newton", 2e-4, 4.5), ("newton", 1e-4, 0.0), ("jacobi", 1e-5, 10.0)]
)
def test_good_runs_of_the_arm_are_not_flagged(master, H, friction):
    results, said, created = arm(H, friction, until=0.5, master=master)
    assert error(results, friction) < 5e-3
    assert abs(created) < SHARE * results.summary["system_energy"]
    assert not said and not results.summary["wrong"]
