"""The jointed arms against MuJoCo, Newton's and Euler's laws, and closed forms."""

import numpy as np
import pytest
from numpy.polynomial.laguerre import lagroots
from scipy.optimize import brentq
from scipy.special import ellipk

from ulna.charts.arms import CARRYING, FOREARM, GRAVITY, UPPER_ARM, JointedArm, ball_arm, chain, hinge, planar_arm
from ulna.checks.textbook import load_model

MODEL = load_model("jointed_arm")
TWO_BALLS = JointedArm(
    "two_balls",
    (UPPER_ARM, FOREARM),
    ({"kind": "ball", "friction": 0.2}, {"kind": "ball", "friction": 0.3}),
    (),
    (),
    0.0,
)
HINGE_THEN_BALL = JointedArm(
    "hinge_then_ball", (FOREARM, UPPER_ARM), (hinge(0.2, CARRYING), {"kind": "ball", "friction": 0.3}), (), (), 0.0
)
ARMS = {arm.name: arm for arm in (planar_arm(), ball_arm(), chain(10, 0.02), TWO_BALLS, HINGE_THEN_BALL)}
NAMED = pytest.mark.parametrize("name", ARMS)


def modelled(arm, **changes):
    joints = [joint | changes for joint in arm.joints]
    return MODEL.jointed_arm(arm.bodies, joints, GRAVITY)


def some_state(model, seed):
    """Any attitude, speeds of some rad/s."""
    state = np.random.default_rng(seed).normal(size=model.size)
    place = 0
    for joint in model.joints:
        if joint["kind"] == "ball":
            state[place : place + 4] /= np.linalg.norm(state[place : place + 4])
        place += 4 if joint["kind"] == "ball" else 1
    return state


def mujoco_of(model):
    """The chain as a model of MuJoCo with its data."""
    mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: make .venv/importers")
    opened, place = "", np.zeros(3)
    for body, joint in zip(model.bodies, model.joints, strict=True):
        numbers = {"pos": place, "center": np.negative(body["base"]), "inertia": body["inertia"]}
        texts = {name: " ".join(repr(float(x)) for x in value) for name, value in numbers.items()}
        axis = f'axis="{" ".join(map(repr, joint["axis"]))}"' if joint["kind"] == "hinge" else ""
        opened += (
            f'<body pos="{texts["pos"]}"><joint type="{joint["kind"]}" {axis} damping="{joint["friction"]}"/>'
            f'<inertial pos="{texts["center"]}" mass="{body["mass"]!r}" diaginertia="{texts["inertia"]}"/>'
        )
        place = np.subtract(body["tip"], body["base"])
    gravity = " ".join(map(repr, model.gravity))
    text = (
        f'<mujoco><compiler angle="radian"/><option gravity="{gravity}" integrator="RK4" timestep="1e-3">'
        f'<flag energy="enable"/></option><worldbody>{opened}{"</body>" * len(model.bodies)}</worldbody></mujoco>'
    )
    compiled = mujoco.MjModel.from_xml_string(text)
    return mujoco, compiled, mujoco.MjData(compiled)


def put(model, data, state):
    """MuJoCo's angles are those to the body before."""
    place, speed = np.split(state, [model.places])
    if model.planar:
        place, speed = (np.diff(part, prepend=0.0) for part in (place, speed))
    data.qpos[:], data.qvel[:] = place, speed


@NAMED
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_accelerations_are_those_of_mujoco(name, seed):
    model = modelled(ARMS[name])
    mujoco, compiled, data = mujoco_of(model)
    state = some_state(model, seed)
    put(model, data, state)
    mujoco.mj_forward(compiled, data)
    found = model.slope(0.0, state)[model.places :]
    if model.planar:
        found = np.diff(found, prepend=0.0)
    # ten rods: the condition of the mass matrix, in angles to the rod before, is some 1e4
    assert found == pytest.approx(data.qacc, abs=1e-11 * np.abs(data.qacc).max())


@NAMED
def test_places_energies_and_momenta_are_those_of_mujoco(name):
    model = modelled(ARMS[name])
    mujoco, compiled, data = mujoco_of(model)
    state = some_state(model, 4)
    put(model, data, state)
    mujoco.mj_forward(compiled, data)
    mujoco.mj_subtreeVel(compiled, data)
    found = model.results(state)
    center = data.subtree_com[0]
    assert found["base_position"] == pytest.approx(data.xpos[1:], abs=1e-13)
    assert found["position"] == pytest.approx(data.xipos[1:], abs=1e-13)
    turns = np.abs(np.sum(found["orientation"] * data.xquat[1:], axis=1))
    assert turns == pytest.approx(np.ones(len(turns)), abs=1e-13)
    assert found["potential_energy"].sum() == pytest.approx(data.energy[0], abs=1e-12)
    assert found["kinetic_energy"].sum() == pytest.approx(data.energy[1], rel=1e-12)
    assert found["linear_momentum"] == pytest.approx(data.subtree_linvel[0] * compiled.body_subtreemass[0], abs=1e-11)
    about_origin = data.subtree_angmom[0] + np.cross(center, found["linear_momentum"])
    assert found["angular_momentum"] == pytest.approx(about_origin, abs=1e-11)


@pytest.mark.parametrize("name", ["planar_arm", "ball_arm"])
def test_mujoco_converges_to_the_reference_at_order_four(name):
    arm = ARMS[name]
    model = modelled(arm)
    mujoco, compiled, data = mujoco_of(model)
    truth = model.results(MODEL.reference(model, arm.state, [0.0, arm.end])[-1])
    errors = []
    for step in (4e-3, 2e-3, 1e-3):
        mujoco.mj_resetData(compiled, data)
        compiled.opt.timestep = step
        put(model, data, arm.state)
        mujoco.mj_step(compiled, data, round(arm.end / step))
        mujoco.mj_forward(compiled, data)
        errors.append(np.abs(data.xipos[1:] - truth["position"]).max())
    # a step of 1 ms turns the bodies by some .01 rad; the next order's share is of that size, and grows on the way
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([4.0, 4.0], abs=0.25)
    assert errors[-1] < 1e-8


@NAMED
def test_newton_and_euler_find_friction_only_along_the_freedoms(name):
    """Forces and torques in the joints, from the tip to the shoulder, are what mass times acceleration leaves over."""
    model = modelled(ARMS[name])
    found = model.results(some_state(model, 5))
    force, torque, place, spins = np.zeros(3), np.zeros(3), found["tip_position"][-1], found["angular_velocity"]
    for i in reversed(range(len(model.bodies))):
        body, joint = model.bodies[i], model.joints[i]
        w, x, y, z = found["orientation"][i]
        attitude = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])  # fmt: skip
        inertia = attitude @ np.diag(body["inertia"]) @ attitude.T
        center, base, spin = found["position"][i], found["base_position"][i], spins[i]
        # of the body before on this one, at its base
        torque = torque + np.cross(place - center, force)
        force = force + body["mass"] * (found["acceleration"][i] - GRAVITY)
        torque = torque + inertia @ found["angular_acceleration"][i] + np.cross(spin, inertia @ spin)
        torque = torque + np.cross(center - base, force)
        place = base
        turning = spin - (spins[i - 1] if i else 0.0)
        free = np.eye(3) if joint["kind"] == "ball" else attitude @ np.array([joint["axis"]]).T
        # terms of some 10 N m are left over to round-off
        assert free.T @ torque == pytest.approx(-joint["friction"] * free.T @ turning, abs=1e-11)
    assert np.sum(found["power"]) < 0.0 or joint["friction"] == 0.0


@pytest.mark.parametrize("count", [1, 2, 3, 10])
def test_small_swings_of_point_masses_have_the_zeros_of_laguerre_as_frequencies(count):
    """n equal masses on equal light links: w^2 = g / l times the zeros of L_n; for two 2 -+ sqrt(2) (Landau and
    Lifshitz, 23, problem 2)."""
    length = 0.3
    link = {"mass": 0.7, "inertia": [0.0] * 3, "base": [-length, 0, 0], "tip": [0.0] * 3}
    model = MODEL.jointed_arm([link] * count, [hinge()] * count, GRAVITY)
    hanging = np.concatenate([np.full(count, -np.pi / 2), np.zeros(count)])
    step = 1e-4
    columns = [model.slope(0.0, hanging + d) - model.slope(0.0, hanging - d) for d in step * np.eye(2 * count)[:count]]
    squares = -np.linalg.eigvals(np.array(columns).T[count:] / (2 * step))
    # the central difference misses by step^2 / 6 of the third derivative; zeros of higher degree are found less well
    expected = 9.80665 / length * lagroots([0] * count + [1])
    assert np.sort(squares.real) == pytest.approx(expected, rel=1e-6)
    assert model.slope(0.0, hanging) == pytest.approx(np.zeros(2 * count), abs=1e-13)


def test_a_compound_pendulum_returns_after_four_quarter_periods():
    """T = 4 sqrt(J / (m g c)) K(sin^2 (a / 2)) for a swing of a: 2 rad here."""
    model = MODEL.jointed_arm([FOREARM], [hinge()], GRAVITY)
    moment = FOREARM["inertia"][1] + FOREARM["mass"] * FOREARM["base"][0] ** 2
    period = 4 * np.sqrt(moment / (FOREARM["mass"] * 9.80665 * 0.17901)) * ellipk(np.sin(1.0) ** 2)
    start = np.array([2.0 - np.pi / 2, 0.0])
    states = MODEL.reference(model, start, [0.0, period / 4, period / 2, period])
    # the integrator's tolerance is 3e-14 a step, in some hundred steps
    assert states[1][0] == pytest.approx(-np.pi / 2, abs=2e-12)
    assert states[2] == pytest.approx([-2.0 - np.pi / 2, 0.0], abs=5e-12)
    assert states[3] == pytest.approx(start, abs=1e-11)


def test_a_heavy_top_precesses_steadily_at_its_closed_form():
    """I3 w3 P - I1 P^2 cos(tilt) = m g c: a symmetric top whose axis keeps its tilt turns about the vertical with P."""
    mass, center, along, across, tilt, spin = 1.2, 0.25, 0.02, 0.03, 0.7, 60.0
    about = across + mass * center**2
    top = {"mass": mass, "inertia": [along, across, across], "base": [-center, 0, 0], "tip": [0.0] * 3}
    model = MODEL.jointed_arm([top], [{"kind": "ball", "friction": 0.0}], GRAVITY)
    # the axis x stands up: 90 degrees less the tilt about -y
    turn = np.pi / 2 - tilt
    q = np.array([np.cos(turn / 2), 0.0, -np.sin(turn / 2), 0.0])
    precession = brentq(lambda p: along * spin * p - about * p**2 * np.cos(tilt) - mass * 9.80665 * center, 0.0, 4.0)
    # the vertical seen from the body is cos(tilt) x + sin(tilt) z; the rate about the axis is the whole spin
    rate = np.array([spin, 0.0, precession * np.sin(tilt)])
    found = model.results(np.concatenate([q, rate]))
    change = np.cross([0.0, 0.0, precession], found["angular_velocity"][0])
    assert found["angular_acceleration"][0] == pytest.approx(change, abs=1e-11)
    assert found["orientation"][0] == pytest.approx(q, abs=1e-15)


@pytest.mark.parametrize("name", ["planar_arm", "ball_arm", "chain_10"])
def test_the_reference_keeps_energy_and_vertical_momentum(name):
    """Without friction nothing turns the whole about the vertical; with it the energy goes as the power says."""
    arm = ARMS[name]
    free, braked = modelled(arm, friction=0.0), modelled(arm, friction=0.05)
    kept = free.results(MODEL.reference(free, arm.state, [0.0, arm.end / 2, arm.end]))
    assert kept["energy"] == pytest.approx(np.full(3, kept["energy"][0]), abs=1e-12)
    vertical = kept["angular_momentum"][:, 2]
    assert vertical == pytest.approx(np.full(3, vertical[0]), abs=1e-12)

    # the integral of the power over .2 s, by Gauss and Legendre's rule of 40 points: to round-off
    points, weights = np.polynomial.legendre.leggauss(40)
    times = [0.0, *(0.1 * (points + 1)), 0.2]
    lost = braked.results(MODEL.reference(braked, arm.state, times))
    assert lost["energy"][-1] - lost["energy"][0] == pytest.approx(0.1 * weights @ lost["power"][1:-1], rel=1e-9)
    assert lost["energy"][-1] < lost["energy"][0] - 1e-5


def lagrange(nodes, j, x):
    """The polynomial that is 1 at node j and 0 at the others."""
    others = np.delete(nodes, j)
    return np.prod((x[:, None] - others) / (nodes[j] - others), axis=1)


def gauss(model, state, end, count, stages=6):
    """State at `end` by Gauss and Legendre's collocation of order 2 `stages`, in `count` steps, by fixed point."""
    points, weights = np.polynomial.legendre.leggauss(stages)
    nodes, weights = (points + 1) / 2, weights / 2
    table = np.array([[c * weights @ lagrange(nodes, j, c * nodes) for j in range(stages)] for c in nodes])
    step = end / count
    slopes = np.tile(model.slope(0.0, state), (stages, 1))
    for _ in range(count):
        for _ in range(60):
            before = slopes
            slopes = np.array([model.slope(0.0, place) for place in state + step * table @ slopes])
            if np.abs(slopes - before).max() < 1e-13 * np.abs(slopes).max():
                break
        state = state + step * weights @ slopes
    return state


# a tolerance of 1e-13 a step, a hundred steps, errors that grow tenfold on the whole; tenfold again for ten rods
@pytest.mark.parametrize(("name", "bound"), [("planar_arm", 2e-12), ("ball_arm", 2e-12), ("chain_10", 2e-11)])
def test_the_reference_is_that_of_another_method_and_of_another_tolerance(name, bound):
    arm = ARMS[name]
    model = modelled(arm)
    state = MODEL.reference(model, arm.state, [0.0, arm.end])[-1]
    assert state == pytest.approx(MODEL.reference(model, arm.state, [0.0, arm.end], 1e-13)[-1], abs=bound)
    assert state == pytest.approx(MODEL.reference(model, arm.state, np.linspace(0.0, arm.end, 701))[-1], abs=bound)
    assert state == pytest.approx(gauss(model, arm.state, arm.end, 400), abs=bound)


@pytest.mark.parametrize("name", ["planar_arm", "ball_arm", "chain_10"])
def test_small_errors_stay_small(name):
    """The standard problems are not chaotic within their time: an error at the start grows by less than 300."""
    arm = ARMS[name]
    model = modelled(arm)
    small = 1e-4
    ends = [
        [MODEL.reference(model, arm.state + sign * d, [0.0, arm.end], 1e-9)[-1] for sign in (1, -1)]
        for d in small * np.eye(model.size)
    ]
    assert np.linalg.norm(np.subtract.reduce(ends, axis=1) / (2 * small), 2) < 300


def test_shapes_of_results_and_what_is_refused():
    model = modelled(ball_arm())
    found = model.results(np.tile(ball_arm().state, (5, 7, 1)))
    assert found["position"].shape == (5, 7, 2, 3)
    assert found["orientation"].shape == (5, 7, 2, 4)
    assert found["kinetic_energy"].shape == (5, 7, 2)
    assert found["angular_momentum"].shape == (5, 7, 3)
    assert found["energy"].shape == (5, 7)
    assert modelled(chain(1)).results(chain(1).state)["position"].shape == (1, 3)
    with pytest.raises(ValueError, match="one joint for each"):
        MODEL.jointed_arm([FOREARM], [], GRAVITY)
    with pytest.raises(ValueError, match="allowed are hinge, ball"):
        MODEL.jointed_arm([FOREARM], [{"kind": "slide", "friction": 0.0}], GRAVITY)
    with pytest.raises(ValueError, match="vector of length 1"):
        MODEL.jointed_arm([FOREARM], [hinge(axis=(0.0, 1.1, 0.0))], GRAVITY)
    with pytest.raises(ValueError, match="each later than the one before"):
        MODEL.reference(model, ball_arm().state, [0.0, 1.0, 1.0])
