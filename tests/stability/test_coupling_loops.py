"""The loop of two hinges as the masters see it: where passes settle, and that iterated and newton solve it anyway."""

import math

import numpy as np
import pytest

from ulna.charts.arms import FOREARM, UPPER_ARM, hinge
from ulna.checks.textbook import load_model
from ulna.scene import Scene
from ulna.stability import hinges
from ulna.stability.mobility import settling_mass_ratio


def test_every_pass_changes_the_error_by_the_gain(coupled):
    gains = [row["theory"] for row in coupled["loops"]]
    assert min(gains) < 0.1 and max(gains) > 20.0
    for row in coupled["loops"]:
        # from accelerations with 16 digits over a few passes at least
        assert row["gain"] == pytest.approx(row["theory"], rel=1e-5), row


def test_plain_passes_settle_below_gain_1_and_do_not_above(coupled):
    for row in coupled["loops"]:
        # a hundred passes must leave less than a part in 1e13
        if row["theory"] < 0.7 or row["theory"] > 1.0:
            assert row["settled"] == (row["theory"] < 1.0), row
    for row in coupled["mass_ratios"]:
        assert row["measured"] == pytest.approx(row["theory"], rel=0.01), row


@pytest.mark.parametrize("master", ["jacobi", "gauss_seidel"])
@pytest.mark.parametrize("elbow", [0.0, 1.0, math.pi / 2])
def test_explicit_masters_diverge_step_by_step_beyond_the_border(master, elbow):
    """From the border on: below it the accelerations are right to some H, above they grow until a unit refuses."""
    border = settling_mass_ratio(hinges.SLENDERNESS, elbow)
    below, settled = hinges.run(master, 0.65 * border, elbow, steps=50, H=1e-4)
    assert settled
    assert np.abs(below["upper.tip_angular_acceleration"]).max() < 200.0
    above, settled = hinges.run(master, 1.3 * border, elbow)
    assert not settled
    assert np.abs(above["upper.tip_angular_acceleration"]).max() > 1e8


@pytest.mark.parametrize("master", ["iterated", "newton"])
def test_on_both_sides_of_the_border_initial_values_and_steps_are_solved(coupled, master):
    gains = [row["theory"] for row in coupled["loops"]]
    assert min(gains) < 0.5 and max(gains) > 2.0
    for row in coupled["loops"]:
        # a step ends at 1e-10 of nominal plus largest value, and the inverse of moments enlarges that
        assert row[master] < 1e-9, row


def test_iterated_gives_up_where_the_least_relaxation_is_too_much_and_newton_does_not():
    ratio = 110.0  # the gain at a right angle
    assert hinges.solution_error("iterated", ratio, math.pi / 2) == math.inf
    assert hinges.solution_error("newton", ratio, math.pi / 2) < 1e-9


@pytest.mark.parametrize("elbow", [0.0, 0.7, 2.5])
@pytest.mark.parametrize("scale", [0.2, 1.0, 5.0])
def test_accelerations_are_those_of_the_reference(elbow, scale):
    """models/jointed_arm derives them from the energies."""
    heavy = {"mass": scale * FOREARM["mass"], "inertia": scale * np.array(FOREARM["inertia"])}
    model = load_model("jointed_arm").jointed_arm([UPPER_ARM, FOREARM | heavy], [hinge(), hinge()])
    state = np.array([-0.8, elbow - 0.8, 1.5, 3.0])
    expected = -model.results(state)["angular_acceleration"][:, 1]
    ratio = scale * FOREARM["mass"] / hinges.FELT
    found = hinges.accelerations(ratio, state[:2], state[2:], gravity=9.80665)
    assert found == pytest.approx(expected, rel=1e-12)


def test_the_torque_of_the_elbow_is_in_the_accelerations():
    results, _ = hinges.run("newton", 0.5, 0.7, moving=False)
    found = -np.array([results[f"{unit}.tip_angular_acceleration"][0, 1] for unit in ("upper", "forearm")])
    expected = hinges.accelerations(0.5, np.array([0.0, 0.7]), np.zeros(2), hinges.TORQUE)
    assert found == pytest.approx(expected, rel=1e-9)


def test_a_warning_names_the_loop_and_the_master_that_solves_it():
    with Scene() as scene:
        upper = scene.add("HingedBody", "upper", **hinges._hinged(UPPER_ARM, 1.0, 0.0, 0.0, True))
        forearm = scene.add("HingedBody", "forearm", **hinges._hinged(FOREARM, 1.0, math.pi / 2, 0.0, True))
        scene.connect(upper.tip, forearm.anchor)
        with pytest.warns(UserWarning, match="upper, forearm.*newton solves them"):
            scene.run(0.0, 1e-3, master="gauss_seidel")
