"""The watch on the coupling: its energy against the true change of the energy of all units, and what it calls wrong."""

import warnings

import numpy as np
import pytest
from jointed import angle_off, joined, truth

from ulna import Scene
from ulna.charts.arms import HINGE, planar_arm
from ulna.masters import MASTERS
from ulna.watch import CouplingWarning

SOFT = {"stiffness": 1e4, "damping": 50.0, "angular_stiffness": 500.0, "angular_damping": 1.0, "axis": HINGE}
ENERGIES = ("body0.kinetic_energy", "body0.potential_energy", "body1.kinetic_energy", "body1.potential_energy")
SPRINGS = ("shoulder.potential_energy", "elbow.potential_energy")
LOSSES = ("shoulder.dissipation", "elbow.dissipation")


def compliant_arm(**values) -> Scene:
    """Two bodies with springs for joints."""
    scene = Scene()
    upper, forearm = (scene.add("RigidBody", f"body{k}", **body) for k, body in enumerate(planar_arm().rigid_bodies))
    shoulder, elbow = (scene.add("CompliantJoint", name, **{**SOFT, **values}) for name in ("shoulder", "elbow"))
    scene.connect(upper.base, shoulder.second)
    scene.connect(upper.tip, elbow.first)
    scene.connect(forearm.base, elbow.second)
    return scene


def created(results, late: int = 0) -> float:
    """Energy (J) at the end that was not there at the start, nor lost in dampers.

    `late` is the number of rows by which the joints' rows are behind.
    """
    rows = len(results) - late
    bodies = sum(results[name] for name in ENERGIES)[:rows]
    springs, losses = (sum(results[name] for name in names)[late:] for names in (SPRINGS, LOSSES))
    energy = bodies + springs
    return energy[-1] - energy[0] + np.trapezoid(losses, results.time[:rows])


@pytest.mark.parametrize(("master", "late"), [("jacobi", 1), ("gauss_seidel", 0)])
def test_the_energy_of_the_coupling_is_what_the_units_gain(master, late):
    with compliant_arm() as scene:
        results = scene.run(1.0, 5e-4, master=master)
    gained = created(results, late)
    assert gained > 1e-3
    # both are sums of trapezia, which differ where the joint's own swing, some 100 rad/s, turns: (w h)^2
    assert results.summary["coupling_energy"] == pytest.approx(gained, rel=0.01)


def test_extrapolation_and_iteration_create_less_and_the_watch_says_so():
    found = {}
    for master, extrapolation in (("jacobi", 0), ("jacobi", 1), ("newton", 0)):
        with compliant_arm() as scene:
            results = scene.run(1.0, 1e-3, master=master, extrapolation=extrapolation)
        found[master, extrapolation] = abs(results.summary["coupling_energy"])
    assert found["newton", 0] < found["jacobi", 1] < 0.02 * found["jacobi", 0]


def test_a_run_that_the_coupling_makes_wrong_is_called_wrong_while_it_goes_on():
    """Too stiff for Jacobi at this step (fmus/compliant_joint/README.md): the joint shakes the arm."""
    seen = []
    with compliant_arm(stiffness=1e5) as scene, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")

        def progress(time: float) -> None:
            seen.append((time, len(caught)))

        results = scene.run(0.08, 1e-3, master="jacobi", progress=progress)
    (warning,) = [w for w in caught if issubclass(w.category, CouplingWarning)]
    assert "the coupling has gained" in str(warning.message)
    assert results.summary["wrong"]
    # before the end, and once
    assert [count for time, count in seen if time < 0.07][-1] == 1


def test_a_hinged_body_on_a_free_one_is_watched_as_well():
    """A reaction that depends on the acceleration of its anchor, from a unit with states of its own.

    What such a unit makes of an anchor that is told late is its own affair: the estimate gives the size, not the sign.
    """

    def run(master: str) -> tuple[float, float]:
        with Scene() as scene:
            body = scene.add("RigidBody", "body", mass=5.0, inertia=[0.5, 0.75, 1.0], tip=[0.0, 0.0, -0.2])
            body.set("initial_angular_velocity", [0.3, 1.0, 0.4])
            body.set("gravity", [0.0, 0.0, 0.0])
            arm = scene.add("HingedBody", "arm", stiffness=0.0, damping=0.0, initial_rate=3.0, gravity=[0.0, 0.0, 0.0])
            scene.connect(body.tip, arm.anchor)
            results = scene.run(0.5, 0.01, master=master)
        energy = sum(results[f"{unit}.{kind}_energy"] for unit in ("body", "arm") for kind in ("kinetic", "potential"))
        return abs(energy[-1] - energy[0]), abs(results.summary["coupling_energy"])

    for master in ("jacobi", "gauss_seidel"):
        true, told = run(master)
        assert 1e-4 < true < 1e-3
        assert 0.2 < told / true < 5.0
    true, told = run("newton")
    assert true < 1e-5
    assert told < 1e-5


def test_the_error_of_an_input_is_the_change_that_was_not_foretold():
    """A body in free fall drives another by its place: with a step of h the held place is off by up to v h."""
    with Scene() as scene:
        first = scene.add("RigidBody", "first", gravity=[0.0, 0.0, -10.0])
        second = scene.add("RigidBody", "second", gravity=[0.0, 0.0, 0.0])
        scene.connect(first.position, second.force, factor=1.0)
        held = scene.run(1.0, 0.01, master="jacobi").summary
        lines = scene.run(1.0, 0.01, master="jacobi", extrapolation=1).summary
    # 10 t h over 1 + 5 t^2, the nominal and the largest place by then: largest at 5 t^2 = 1; but twenty reviews look
    # ahead by up to 0.05 s. Then the second difference, g h^2, over what has been seen at the first review.
    assert held["input_error"] == pytest.approx(10.0 * 0.01 * 0.2**0.5 / 2.0, rel=0.05)
    assert lines["input_error"] == pytest.approx(10.0 * 0.01**2, rel=0.05)
    assert held["input_error_at"] == "first.position -> second.force"


@pytest.mark.parametrize("master", [name for name in MASTERS if name != "rigid"])
def test_tolerance_rules_the_macro_step(master):
    """Rows 10 ms apart, far too long for the joint: within tolerance the arm swings as with very short steps."""
    ends, steps = [], []
    for tolerance in (3e-2, 3e-3):
        with compliant_arm() as scene:
            results = scene.run(0.3, 0.01, master=master, tolerance=tolerance)
        ends.append(results["body1.orientation"][-1])
        steps.append(results.summary["macro_steps"])
        # Jacobi sees what a step does in the next one, which may be three times as long
        assert results.summary["input_error"] < 3.0 * tolerance
        np.testing.assert_array_equal(results.time, 0.01 * np.arange(31))
    with compliant_arm() as scene:
        truth = scene.run(0.3, 1e-4, master="newton")["body1.orientation"][-1]
    errors = [np.linalg.norm(end - truth) for end in ends]
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 5e-3
    # order 1 takes ten times as many steps for a tenth of the error, order 2 at least the root of it
    order = 2 if MASTERS[master].implicit else 1
    assert steps[1] > 0.5 * 10 ** (1 / order) * steps[0]


def test_tolerance_rules_the_step_of_a_rigid_joint():
    """Its error goes with the square of the jump between the lines of two steps: order 4."""
    arm = planar_arm()
    errors, steps = [], []
    for tolerance in (1e-4, 1e-8):
        with joined(arm) as scene:
            results = scene.run(arm.end, 0.05, tolerance=tolerance)
        errors.append(angle_off(results, truth(planar_arm)))
        steps.append(results.summary["macro_steps"])
        assert results.summary["largest_gap"] <= 1e-12
    # a tenth of the step for a ten-thousandth of the error, but that the first run is held by its rows
    assert steps[1] > 4 * steps[0]
    assert errors[1] < 1e-2 * errors[0]
    assert errors[1] < 1e-5


def test_repeating_steps_leaves_no_trace():
    """A signal that jumps makes steps be taken back; the same rows come again in a second run."""
    with compliant_arm() as scene:
        scene.signal(scene["body1"].torque, lambda t: [0.0, 5.0 if t > 0.055 else 0.0, 0.0])
        first, second = (scene.run(0.1, 0.01, master="gauss_seidel", tolerance=1e-2) for _ in range(2))
    assert first.summary["repeated_steps"] == second.summary["repeated_steps"] > 0
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])
