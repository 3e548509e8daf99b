"""Masters: each against the closed form of its own scheme, to the bit, and against the true solution, in order."""

import math
import tracemalloc

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from toy_fmu import toy
from ulna.masters import MASTERS
from ulna.scene import Scene

VERSIONS = ("2.0", "3.0")
# Every master without joints, with every extrapolation that it knows.
LADDER = [(name, extrapolation) for name, m in MASTERS.items() if name != "rigid" for extrapolation in (0, 1)]


def integrators(version: str, names: str) -> Scene:
    """a -> b -> c, x' = u, added in the order of `names`; a has the constant input 1."""
    scene = Scene()
    for name in names:
        scene.add(toy(version), name)
    scene["a"].set("u", [1.0, 1.0, 1.0])
    scene.connect(scene["a"].x, scene["b"].u)
    scene.connect(scene["b"].x, scene["c"].u)
    return scene


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("names", ["abc", "cba", "bca"])
@pytest.mark.parametrize(
    ("master", "closed_form"),
    [
        # With step h, after n steps: a = n h; then b and c are sums of what the master lets each unit see.
        ("jacobi", lambda n: math.comb(n, 3)),
        ("gauss_seidel", lambda n: math.comb(n + 2, 3)),
    ],
)
def test_a_chain_of_integrators_follows_the_masters_own_sums_to_the_bit(version, names, master, closed_form):
    step = 0.125
    with integrators(version, names) as scene:
        results = scene.run(8.0, step, master=master)
    assert results["c.x"][:, 0].tolist() == [closed_form(n) * step**3 for n in range(65)]


def oscillator(master: str, step: float, until: float, extrapolation: int = 0) -> np.ndarray:
    """x' = v, v' = -x from x = 1, v = 0: the state at `until`, and the energy x^2 + v^2 of every row."""
    with Scene() as scene:
        position, velocity = scene.add(toy(), "position"), scene.add(toy(), "velocity")
        scene.connect(velocity.x, position.u, offset=0.0)
        # The toy starts at zero; x is measured from there, so the force is -(x + 1).
        scene.connect(position.x, velocity.u, factor=-1.0, offset=-1.0)
        results = scene.run(until, step, master=master, extrapolation=extrapolation)
    return np.array([1.0 + results["position.x"][:, 0], results["velocity.x"][:, 0]])


def observed_orders(errors: list[float]) -> np.ndarray:
    """From errors at steps that are halved."""
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.parametrize(("master", "extrapolation"), LADDER)
def test_a_coupled_oscillator_converges_at_the_declared_order(master, extrapolation):
    errors = []
    for step in (1e-2, 5e-3, 2.5e-3):
        position, velocity = oscillator(master, step, 2.0, extrapolation)[:, -1]
        errors.append(math.hypot(position - math.cos(2.0), velocity + math.sin(2.0)))
    # The next term of the error moves the measured order by about the step.
    declared = MASTERS[master].orders[extrapolation]
    np.testing.assert_allclose(observed_orders(errors), declared, atol=3e-2)


def test_jacobi_pumps_energy_into_an_oscillator_and_gauss_seidel_does_not():
    step, until = 0.125, 50.0
    growth = np.sum(oscillator("jacobi", step, until) ** 2, axis=0)
    steps = np.arange(len(growth))
    # Jacobi is explicit Euler here: each step multiplies x^2 + v^2 by 1 + h^2.
    np.testing.assert_allclose(growth, (1.0 + step**2) ** steps, rtol=1e-12)
    bounded = np.sum(oscillator("gauss_seidel", step, until) ** 2, axis=0)
    # Gauss-Seidel is symplectic Euler: x^2 + v^2 +- h x v is kept, so the energy stays within about h / 2 of it.
    assert np.all(np.abs(bounded - 1.0) < step)


def test_gauss_seidel_rows_are_consistent_and_jacobi_lags_a_step_per_unit():
    with Scene() as scene:
        last, middle, first = (scene.add(toy(), name) for name in ("last", "middle", "first"))
        scene.connect(first.y, middle.u)
        scene.connect(middle.y, last.u)
        scene.signal(first.u, lambda t: [t, 0.0, 0.0])
        consistent = scene.run(8.0, 1.0, master="gauss_seidel")
        lagging = scene.run(8.0, 1.0, master="jacobi")
    np.testing.assert_array_equal(consistent["last.y"][:, 0], consistent.time)
    np.testing.assert_array_equal(lagging["last.y"][:, 0], np.maximum(lagging.time - 3.0, 0.0))


def tethered(version: str, master: str, step: float, extrapolation: int = 0) -> np.ndarray:
    """Two bodies of 1 and 2 kg; a spring of 3 N/m holds the first to the origin, and drives the second (N/m: 1.5)."""
    with Scene() as scene:
        common = {"gravity": [0.0, 0.0, 0.0], "solver": "rk4", "version": version}
        first = scene.add("RigidBody", "first", mass=1.0, initial_position=[1.0, 0.5, 0.0], **common)
        second = scene.add("RigidBody", "second", mass=2.0, initial_velocity=[0.0, 0.1, 0.2], **common)
        scene.connect(first.position, first.force, factor=-3.0)
        scene.connect(first.position, second.force, factor=1.5)
        results = scene.run(2.0, step, master=master, extrapolation=extrapolation)
    return np.hstack([results["first.position"], results["second.position"]])


@pytest.mark.parametrize(("master", "extrapolation"), LADDER)
def test_both_versions_give_the_same_trajectory_to_the_bit(master, extrapolation):
    trajectories = [tethered(version, master, 0.01, extrapolation) for version in VERSIONS]
    np.testing.assert_array_equal(*trajectories)


@pytest.mark.parametrize("master", ["jacobi", "newton"])
def test_input_derivatives_of_fmi_2_do_what_the_rate_inputs_do(master, monkeypatch):
    """To the bit: the slope is one number, whichever function brings it to the unit."""
    by_rates = tethered("2.0", master, 0.01, 1)
    monkeypatch.setattr("ulna.slopes.RATE", "_by_no_such_name")
    np.testing.assert_array_equal(tethered("2.0", master, 0.01, 1), by_rates)
    # FMI 3 has no such function: there the unit gets constants in two half steps instead
    assert not np.array_equal(tethered("3.0", master, 0.01, 1), by_rates)
    np.testing.assert_allclose(tethered("3.0", master, 0.01, 1), by_rates, atol=1e-6)


@pytest.mark.parametrize(("master", "extrapolation"), LADDER)
def test_coupled_bodies_converge_to_the_solution_of_scipy(master, extrapolation):
    def rates(_: float, state: np.ndarray) -> np.ndarray:
        return np.concatenate([state[6:], -3.0 * state[:3], 1.5 / 2.0 * state[:3]])

    initial = [1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.2]
    truth = solve_ivp(rates, (0.0, 2.0), initial, method="DOP853", rtol=1e-12, atol=1e-12).y[:6, -1]
    steps = (4e-3, 2e-3, 1e-3)
    errors = [np.linalg.norm(tethered("3.0", master, step, extrapolation)[-1] - truth) for step in steps]
    np.testing.assert_allclose(observed_orders(errors), MASTERS[master].orders[extrapolation], atol=3e-2)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_run_keeps_no_memory_but_its_rows(version):
    with integrators(version, "abc") as scene:
        scene.record(scene["c"].x)

        def work(steps: int) -> int:
            results = scene.run(steps * 1e-3, 1e-3)
            del results
            return tracemalloc.get_traced_memory()[0]

        tracemalloc.start()
        try:
            work(1000)
            first, second = work(1000), work(11000)
        finally:
            tracemalloc.stop()
    # One number kept in each of the 10000 further steps would be 240 kB; what a run itself leaves to the interpreter's
    # lists of free objects is some 20 kB.
    assert second - first < 100_000
