"""Theory of the coupled step against plain loops over two masses and a joint, against the units, and in closed form."""

import math

import numpy as np
import pytest

from toy_fmu import toy
from ulna.scene import Scene
from ulna.stability import coupling_theory as theory

MASTERS = list(theory.MATRICES)
ORDERS = {master: order for master, (order, _) in theory.FORCE_ERRORS.items()}
EVERY = pytest.mark.parametrize("master", MASTERS)
OSCILLATORS = [(0.8, 0.35, 1e4, 0.0), (0.8, 0.35, 1e4, 20.0), (2.0, 0.1, 500.0, 9.0)]


def flown(x, v, force, slope, mass, H):
    """A mass under force + slope t, from first to last."""
    return (
        x + H * v + H**2 * force / (2 * mass) + H**3 * slope / (6 * mass),
        v + H * force / mass + H**2 * slope / (2 * mass),
    )


class Simulated:
    """Masses and joint, each knowing its inputs only: what a master does to them, written out as such."""

    def __init__(self, m1, m2, k, c, H, motion=(0.0, 0.01, 0.2, -0.3)):
        self.masses, self.k, self.c, self.H = (m1, m2), k, c, H
        self.motion = np.array(motion)  # x1, x2, v1, v2
        self.force = self.joint(self.motion)
        self.motion_before, self.force_before = self.motion, self.force

    def joint(self, motion):
        """The force on the first mass; the opposite is on the second."""
        x1, x2, v1, v2 = motion
        return self.k * (x2 - x1) + self.c * (v2 - v1)

    def moved(self, force, slope):
        (x1, x2, v1, v2), (m1, m2) = self.motion, self.masses
        first, second = flown(x1, v1, force, slope, m1, self.H), flown(x2, v2, -force, -slope, m2, self.H)
        return np.array([first[0], second[0], first[1], second[1]])

    def step(self, master):
        shown, force, H = self.motion, self.force, self.H
        if master == "jacobi_order_0":
            self.motion = self.moved(force, 0.0)
            self.force = self.joint(shown)
        elif master == "jacobi_order_1":
            self.motion = self.moved(force, (force - self.force_before) / H)
            self.force = self.joint(2 * shown - self.motion_before)
        elif master == "gauss_seidel_order_0":
            self.motion = self.moved(force, 0.0)
            self.force = self.joint(self.motion)
        elif master == "gauss_seidel_order_1":
            self.motion = self.moved(force, (force - self.force_before) / H)
            self.force = self.joint(self.motion)
        else:
            # the force at the end is where a straight line meets: two trials give it
            far = 1.0 + abs(force)
            residuals = [self.joint(self.moved(force, (trial - force) / H)) - trial for trial in (0.0, far)]
            end = far * residuals[0] / (residuals[0] - residuals[1])
            self.motion = self.moved(force, (end - force) / H)
            self.force = self.joint(self.motion)
        self.motion_before, self.force_before = shown, force

    def distance(self):
        x1, x2, v1, v2 = self.motion
        return np.array([x2 - x1, v2 - v1])

    def held(self, master):
        """The state of the theory at the start, where nothing was before."""
        count = len(theory.MATRICES[master](*self.masses, self.k, self.c, self.H)) - 2
        return np.concatenate([self.distance(), np.full(count, self.force)])


@EVERY
@pytest.mark.parametrize("oscillator", OSCILLATORS)
@pytest.mark.parametrize("H", [1e-4, 2e-3, 2e-2])
def test_the_matrix_is_the_step_of_two_masses_and_a_joint(master, oscillator, H):
    m1, m2 = oscillator[:2]
    simulated = Simulated(*oscillator, H)
    matrix, expected = theory.MATRICES[master](*oscillator, H), simulated.held(master)
    center, drift = (np.array([m1, m2]) @ simulated.motion.reshape(2, 2).T) / (m1 + m2)
    for n in range(1, 31):
        simulated.step(master)
        expected = matrix @ expected
        # places are of order 1, and so is their round-off
        size = max(1.0, np.abs(expected[:2]).max())
        assert simulated.distance() == pytest.approx(expected[:2], rel=0.0, abs=1e-12 * size)
        place = np.array([m1, m2]) @ simulated.motion[:2] / (m1 + m2)
        assert place == pytest.approx(center + n * H * drift, abs=1e-12 * size)


def largest_swing(master, oscillator, H, count):
    """Of the last tenth of `count` steps, over that of the first; times the frequency, so that speed is alike."""
    simulated = Simulated(*oscillator, H)
    swings = []
    for _ in range(count):
        simulated.step(master)
        r, v = simulated.distance()
        swings.append(math.hypot(r, v / math.sqrt(oscillator[2])))
    tenth = count // 10
    return max(swings[-tenth:]) / max(swings[:tenth])


@EVERY
@pytest.mark.parametrize("oscillator", OSCILLATORS[1:])
def test_with_a_damper_the_motion_dies_out_below_the_limit_and_grows_above(master, oscillator):
    limit = theory.stable_step(master, *oscillator)
    assert 0.0 < limit < math.inf
    assert largest_swing(master, oscillator, 0.98 * limit, 3000) < 0.1
    assert largest_swing(master, oscillator, 1.02 * limit, 3000) > 10.0


@pytest.mark.parametrize(("master", "power", "factor"), [(m, *theory.UNDAMPED_GROWTH[m]) for m in MASTERS])
def test_without_a_damper_errors_grow_at_the_rate_of_the_table(master, power, factor):
    m1, m2, k, _ = OSCILLATORS[0]
    w = math.sqrt(k / theory.reduced_mass(m1, m2))
    for z in (0.02, 0.04):
        rate = theory.growth(master, m1, m2, k, 0.0, z / w) / w
        # the next term is two powers of z on, with a factor of some units
        assert rate == pytest.approx(factor * z**power, rel=10 * z**2, abs=1e-11)
    found = math.log(largest_swing(master, OSCILLATORS[0], 0.04 / w, 5000))
    # 4500 steps lie between the two looks; sampled, a swing misses its top by z^2 / 8
    assert found == pytest.approx(4500 * factor * 0.04 ** (power + 1), rel=0.02, abs=1e-3)


@pytest.mark.parametrize("master", [master for master in MASTERS if master != "converged"])
def test_without_a_damper_there_is_no_stable_step_but_one_of_bounded_growth(master):
    m1, m2, k, _ = OSCILLATORS[0]
    assert theory.stable_step(master, m1, m2, k, 0.0) == 0.0
    allowed = 0.01  # 1/s: so little that the leading term is all
    power, factor = theory.UNDAMPED_GROWTH[master]
    w = math.sqrt(k / theory.reduced_mass(m1, m2))
    expected = (allowed / (factor * w)) ** (1 / power) / w
    assert theory.stable_step(master, m1, m2, k, 0.0, allowed) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize(("m1", "m2", "k", "c"), [*OSCILLATORS, (1.0, math.inf, 4.0, 3.9)])
def test_limits_in_closed_form(m1, m2, k, c):
    """Newmark's sqrt(12 m / k); Jury's criterion for the held force, 2 c / k and 2 m / c; gain 1 of an iteration."""
    m = theory.reduced_mass(m1, m2)
    assert theory.stable_step("converged", m1, m2, k, c) == pytest.approx(math.sqrt(12 * m / k), rel=1.1e-3)
    held = min(2 * c / k, 2 * m / c) if c else 0.0
    assert theory.stable_step("gauss_seidel_order_0", m1, m2, k, c) == pytest.approx(held, rel=1.1e-3)
    assert theory.iteration_step(m1, m2, k, 0.0) == pytest.approx(math.sqrt(6 * m / k), rel=1e-14)
    assert theory.iteration_gain(m1, m2, k, c, theory.iteration_step(m1, m2, k, c)) == pytest.approx(1.0, rel=1e-14)


def test_a_converged_step_without_a_damper_keeps_areas():
    for H in (1e-3, 5e-3, 1e-2):
        matrix = theory.converged(0.8, 0.35, 1e4, 0.0, H)
        assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-14)


def test_a_lightly_damped_jacobi_needs_three_halves_of_the_stiffness_times_the_step():
    m1, m2, k, _ = OSCILLATORS[0]
    m = theory.reduced_mass(m1, m2)
    c = 0.002 * math.sqrt(k * m)
    # c / (k H) = 3/2 at the limit, up to (w H)^2 with w H = .0013
    assert theory.stable_step("jacobi_order_0", m1, m2, k, c, ratio=1.0001) == pytest.approx(2 * c / (3 * k), rel=2e-4)


@EVERY
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_rates_converge_in_order_and_the_effective_joint_says_how(master, oscillator):
    m1, m2, k, c = oscillator
    m, order = theory.reduced_mass(m1, m2), ORDERS[master]
    fastest = np.abs(theory.true_rates(m1, m2, k, c)).max()
    errors, left = [], []
    for H in (0.02 / fastest, 0.01 / fastest):
        errors.append(theory.rate_error(master, m1, m2, k, c, H))
        spring, damper = theory.effective_joint(master, m1, m2, k, c, H)
        found = np.sort_complex(theory.rates(master, m1, m2, k, c, H))
        left.append(np.abs(found - np.sort_complex(np.roots([m, damper, spring]))).max() / fastest)
    # the next power of H is off by at most some ten times .02
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)
    assert math.log2(left[0] / left[1]) > order + 0.75
    assert left[1] < 0.2 * errors[1]


@EVERY
@pytest.mark.parametrize("oscillator", OSCILLATORS)
def test_rates_are_those_of_a_simulated_swing(master, oscillator):
    """Ratio of far steps: what is left of the motion after others have died out."""
    m1, m2, k, c = oscillator
    H = 0.05 / np.abs(theory.true_rates(m1, m2, k, c)).max()
    simulated = Simulated(m1, m2, k, c, H)
    rows = []
    for _ in range(60):
        simulated.step(master)
        rows.append(simulated.distance())
    # Prony's method: every row is the same combination of the two before
    rows = np.array(rows[20:])
    scaled = rows / np.abs(rows).max(axis=0)
    before, after = np.hstack([scaled[1:-1], scaled[:-2]]).reshape(-1, 2, 2), scaled[2:]
    design = before.transpose(0, 2, 1).reshape(-1, 2)
    first, second = np.linalg.lstsq(design, after.ravel(), rcond=None)[0]
    factors = np.sort_complex(np.roots([1.0, -first, -second]).astype(complex))
    expected = np.sort_complex(np.exp(H * theory.rates(master, m1, m2, k, c, H)))
    assert factors == pytest.approx(expected, abs=1e-9)


@EVERY
def test_an_accurate_step_is_stable_and_as_long_as_its_error_allows(master):
    for oscillator in OSCILLATORS:
        H = theory.accurate_step(master, *oscillator, bound=0.01)
        assert theory.rate_error(master, *oscillator, H) == pytest.approx(0.01, rel=5e-3)
        assert theory.rate_error(master, *oscillator, 0.5 * H) < 0.006


def test_a_stable_step_may_be_wrong():
    """The brief life of a damper: at 2/3 of its limit a jacobi of order 0 has a third of the damping left."""
    m1, m2, k, c = 0.8, 0.35, 1e4, 2.0
    H = 2 / 3 * theory.stable_step("jacobi_order_0", m1, m2, k, c)
    assert theory.growth("jacobi_order_0", m1, m2, k, c, H) < 0.0
    found = theory.rates("jacobi_order_0", m1, m2, k, c, H)[0].real / theory.true_rates(m1, m2, k, c)[0].real
    assert found == pytest.approx(1 / 3, rel=0.02)
    assert theory.effective_joint("jacobi_order_0", m1, m2, k, c, H)[1] / c == pytest.approx(1 / 3, rel=0.02)


@pytest.mark.parametrize("oscillator", OSCILLATORS)
@pytest.mark.parametrize("share", [0.5, 0.99, 1.01, 2.0])
def test_an_iteration_converges_by_its_gain(oscillator, share):
    H = share * theory.iteration_step(*oscillator[:4])
    simulated = Simulated(*oscillator, H)
    ends = [simulated.force]
    for _ in range(3):
        ends.append(simulated.joint(simulated.moved(simulated.force, (ends[-1] - simulated.force) / H)))
    changes = np.diff(ends)
    gain = theory.iteration_gain(*oscillator, H)
    assert changes[1:] / changes[:-1] == pytest.approx([-gain] * 2, rel=1e-9)
    assert (gain < 1.0) == (share < 1.0)


def test_the_best_relaxation_is_best():
    gains = [0.3, 1.7, 4.0]
    factor, gain = theory.best_relaxation(gains)
    error = np.ones(3)
    for _ in range(50):
        error = error - factor * (error + np.array(gains) * error)
    assert np.abs(error).max() ** (1 / 50) == pytest.approx(gain, rel=1e-12)
    assert theory.relaxed_gain(gains, factor) == pytest.approx(gain, rel=1e-14)
    assert all(theory.relaxed_gain(gains, factor + change) > gain for change in (-0.01, 0.01))
    assert theory.best_relaxation([2.0]) == (1 / 3, 0.0)
    assert theory.relaxed_gain([2.0], 1.0) == 2.0


@pytest.mark.parametrize(
    ("m1", "m2", "k", "c", "H"),
    [
        (0.0, 1, 1, 0, 1),
        (1, -1, 1, 0, 1),
        (math.inf, math.inf, 1, 0, 1),
        (math.nan, 1, 1, 0, 1),
        (1, 1, 0, 1, 1),
        (1, 1, 1, -1, 1),
        (1, 1, 1, 0, 0.0),
        (1, 1, 1, 0, math.nan),
    ],
)
def test_what_is_no_oscillator_is_refused(m1, m2, k, c, H):
    with pytest.raises(ValueError, match="allowed are"):
        theory.converged(m1, m2, k, c, H)


COMMON = {"gravity": [0.0, 0.0, 0.0], "solver": "rk4"}
START = {"initial_position": [0.02, 0.0, 0.0], "initial_velocity": [0.1, 0.0, 0.0]}


def followed(scene, master, H, count=50):
    with scene:
        results = scene.run(count * H, H, master=master)
    return results


def rows_of(matrix, start, count=50):
    rows = [start]
    for _ in range(count):
        rows.append(matrix @ rows[-1])
    return np.array(rows)[:, :2]


@pytest.mark.parametrize("H", [1e-3, 1e-2, 5e-2])
@pytest.mark.parametrize("master", ["jacobi", "gauss_seidel"])
def test_a_body_that_connections_tie_to_a_wall_steps_as_theory_says(master, H):
    """A connection is a joint that loses no step: the held force of gauss_seidel, whoever is the master."""
    mass, k, c = 0.5, 300.0, 4.0
    scene = Scene()
    body = scene.add("RigidBody", "body", mass=mass, **COMMON, **START)
    scene.connect(body.position, body.force, factor=-k)
    scene.connect(body.velocity, body.base_force, factor=-c)
    results = followed(scene, master, H)
    expected = rows_of(theory.gauss_seidel_order_0(mass, math.inf, k, c, H), np.array([0.02, 0.1]))
    found = np.stack([results["body.position"][:, 0], results["body.velocity"][:, 0]], axis=1)
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("H", [1e-3, 1e-2, 2e-2])
@pytest.mark.parametrize(("master", "named"), [("jacobi", "jacobi_order_0"), ("gauss_seidel", "gauss_seidel_order_0")])
def test_a_joint_in_a_unit_of_its_own_costs_jacobi_a_step(master, named, H):
    """Units without states for spring and damper, the body before them."""
    mass, k, c = 0.5, 300.0, 4.0
    scene = Scene()
    body = scene.add("RigidBody", "body", mass=mass, **COMMON, **START)
    spring, damper = scene.add(toy(), "spring"), scene.add(toy(), "damper")
    for joint, source, target, factor in (
        (spring, body.position, body.force, -k),
        (damper, body.velocity, body.base_force, -c),
    ):
        scene.connect(source, joint.u, factor=factor)
        scene.connect(joint.y, target, factor=1.0)
    results = followed(scene, master, H)
    start = [0.02, 0.1, k * 0.02 + c * 0.1] if master == "jacobi" else [0.02, 0.1]
    expected = rows_of(theory.MATRICES[named](mass, math.inf, k, c, H), np.array(start))
    found = np.stack([results["body.position"][:, 0], results["body.velocity"][:, 0]], axis=1)
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("H", [1e-3, 1e-2, 3e-2])
def test_two_bodies_with_a_spring_between_step_as_theory_says(H):
    m1, m2, k = 0.8, 0.35, 300.0
    scene = Scene()
    first = scene.add("RigidBody", "first", mass=m1, **COMMON, **START)
    second = scene.add("RigidBody", "second", mass=m2, **COMMON)
    for body, other in ((first, second), (second, first)):
        scene.connect(body.position, body.force, factor=-k)
        scene.connect(other.position, body.base_force, factor=k)
    results = followed(scene, "jacobi", H)
    expected = rows_of(theory.gauss_seidel_order_0(m1, m2, k, 0.0, H), np.array([-0.02, -0.1]))
    found = np.stack(
        [results[f"second.{what}"][:, 0] - results[f"first.{what}"][:, 0] for what in ("position", "velocity")], axis=1
    )
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-11 * np.abs(expected).max())
