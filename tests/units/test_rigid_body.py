"""RigidBody against closed forms, and against Euler's equations integrated by another library."""

import math
import re
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp
from scipy.spatial.transform import Rotation

from ulna import Slave, UnitError

DECLARATION = tomllib.loads((Path(__file__).parents[2] / "fmus/rigid_body/unit.toml").read_text())
ORDERS = {
    solver: int(order[1])
    for solver, text in DECLARATION["enumeration"]["Solver"].items()
    if (order := re.search(r"order (\d+)", text))
}
GRAVITY = np.array([0.0, 0.0, -9.80665])
INERTIA = np.array([1.0, 2.0, 3.0])

TUMBLE = {
    "mass": 2.0,
    "inertia": INERTIA,
    "initial_orientation": [0.8, 0.0, 0.6, 0.0],
    "initial_velocity": [0.5, -1.0, 2.0],
    "initial_angular_velocity": [0.6, 1.0, 0.4],
    "base": [-0.4, 0.1, 0.2],
    "tip": [0.7, -0.3, 0.1],
}
LOADS = {
    "free": {},
    "at the centre, with slopes": {
        "force": [1.0, 2.0, -1.0],
        "force_rate": [-3.0, 1.0, 2.0],
        "torque": [0.5, -1.0, 2.0],
        "torque_rate": [2.0, 3.0, -4.0],
    },
    "at the frames, with slopes": {
        "base_force": [4.0, 1.0, -2.0],
        "base_force_rate": [1.0, -2.0, 3.0],
        "base_torque": [0.3, 0.2, -0.6],
        "base_torque_rate": [0.5, -0.4, 0.3],
        "tip_force": [-3.0, 2.0, 5.0],
        "tip_force_rate": [2.0, 4.0, -1.0],
        "tip_torque": [-0.7, 0.1, 0.4],
        "tip_torque_rate": [0.2, 0.6, -0.8],
    },
}


def start(parameters: dict, version: str = "3.0") -> Slave:
    """A RigidBody with these parameters, initialized at t = 0."""
    body = Slave("RigidBody", version=version)
    for name, value in parameters.items():
        body.set(name, value)
    body.initialize(start=0.0)
    return body


def run(parameters: dict, end: float, steps: int, inputs: dict | None = None) -> dict[str, np.ndarray]:
    """Pose, momenta and kinetic energy after one communication step of `steps` internal steps."""
    names = ("position", "orientation", "linear_momentum", "angular_momentum", "kinetic_energy")
    with start(parameters | {"solver_step": end / steps}) as body:
        for name, value in (inputs or {}).items():
            body.set(name, value)
        body.step(0.0, end)
        return {name: body.get(name) for name in names}


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """Matrix [3, 3], body to world, of w, x, y, z."""
    return Rotation.from_quat(np.roll(quaternion, -1)).as_matrix()


def attitude_error(a: np.ndarray, b: np.ndarray) -> float:
    """Angle (rad) of the rotation between two attitudes w, x, y, z."""
    return (Rotation.from_quat(np.roll(a, -1)).inv() * Rotation.from_quat(np.roll(b, -1))).magnitude()


def measured_order(error_of, steps: int) -> float:
    """log2 of the error's fall over a halving of the step."""
    return math.log2(error_of(steps) / error_of(2 * steps))


def exact(parameters: dict, end: float, inputs: dict) -> dict[str, np.ndarray]:
    """DOP853 on x, v, the rotation matrix and Euler's equations in body axes."""
    mass, inertia = parameters["mass"], np.array(parameters["inertia"])
    levers = {name: np.array(parameters.get(name, [0, 0, 0])) for name in ("base", "tip")}

    def load(name: str, t: float) -> np.ndarray:
        return np.array(inputs.get(name, [0, 0, 0])) + t * np.array(inputs.get(name + "_rate", [0, 0, 0]))

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        velocity, matrix, rate = y[3:6], y[6:15].reshape(3, 3), y[15:18]
        force, torque = mass * GRAVITY + load("force", t), matrix.T @ load("torque", t)
        for frame, lever in levers.items():
            force = force + load(frame + "_force", t)
            torque = torque + matrix.T @ load(frame + "_torque", t)
            torque = torque + np.cross(lever, matrix.T @ load(frame + "_force", t))
        x, y_, z = rate
        spin = np.array([[0, -z, y_], [z, 0, -x], [-y_, x, 0]])
        euler = (torque - np.cross(rate, inertia * rate)) / inertia
        return np.concatenate([velocity, force / mass, (matrix @ spin).ravel(), euler])

    matrix = rotation(np.array(parameters.get("initial_orientation", [1, 0, 0, 0])))
    rate = matrix.T @ parameters["initial_angular_velocity"]
    velocity = parameters.get("initial_velocity", [0, 0, 0])
    first = np.concatenate([np.zeros(3), velocity, matrix.ravel(), rate])
    last = solve_ivp(slope, (0, end), first, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    matrix = last[6:15].reshape(3, 3)
    return {
        "position": last[:3],
        "orientation": np.roll(Rotation.from_matrix(matrix).as_quat(), 1),
        "linear_momentum": mass * last[3:6],
        "angular_momentum": matrix @ (inertia * last[15:18]),
    }


exact_tumble = cache(lambda end, load: exact(TUMBLE, end, LOADS[load]))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(("solver", "offset"), [("explicit_euler", -0.5), ("notes", 0.5), ("rk4", 0.0)])
def test_free_flight_is_the_parabola_but_for_the_known_offset(solver: str, offset: float, version: str) -> None:
    velocity, end, h = np.array([3.0, -1.0, 10.0]), 2.0, 0.001
    parabola = velocity * end + GRAVITY * end**2 / 2
    with start({"initial_velocity": velocity, "solver": solver, "solver_step": h}, version) as body:
        body.step(0.0, end)
        # n steps sum g h^2 n (n -+ 1) / 2; 2000 roundings of numbers up to 20
        np.testing.assert_allclose(body.get("position"), parabola + offset * GRAVITY * end * h, atol=1e-11)
        np.testing.assert_allclose(body.get("velocity"), velocity + GRAVITY * end, atol=1e-11)


def swing_on_spring(solver: str, phase: float, steps: int) -> float:
    """Largest deflection (m) of 1 kg on a spring, let go at 1 m; `phase` is h sqrt(k / m)."""
    parameters = {
        "mass": 1.0,
        "gravity": [0, 0, 0],
        "initial_position": [1, 0, 0],
        "solver": solver,
        "solver_step": 1.0,
    }
    largest = 0.0
    with start(parameters) as body:
        for k in range(steps):
            position = body.get("position")
            largest = max(largest, abs(position[0]))
            body.set("force", -(phase**2) * position)
            body.step(float(k), 1.0)
    return largest


def test_notes_stay_bounded_on_a_spring_where_explicit_euler_diverges() -> None:
    # symplectic Euler keeps x^2 - h w x v / w + v^2 / w^2: at most 1 / sqrt(1 - (h w)^2 / 4) = 1.001
    assert swing_on_spring("notes", 0.1, 2000) < 1.002
    # explicit Euler multiplies the amplitude by sqrt(1.01) a step
    assert swing_on_spring("explicit_euler", 0.1, 2000) > 1e4


def test_notes_fail_on_a_spring_beyond_two_over_its_frequency() -> None:
    assert swing_on_spring("notes", 1.99, 200) < 12
    assert swing_on_spring("notes", 2.01, 200) > 1e3


# --- rotation without torque ----------------------------------------------------------------


@pytest.mark.parametrize("solver", ORDERS)
def test_angular_momentum_is_kept_to_round_off_without_torque(solver: str) -> None:
    matrix = rotation(TUMBLE["initial_orientation"])
    momentum = matrix @ np.diag(INERTIA) @ matrix.T @ TUMBLE["initial_angular_velocity"]
    last = run(TUMBLE | {"solver": solver}, 20.0, 2000)["angular_momentum"]
    np.testing.assert_allclose(last, momentum, atol=1e-15 * 2000)
    assert np.linalg.norm(last) == pytest.approx(np.linalg.norm(momentum), rel=1e-13)


@pytest.mark.parametrize(("solver", "steps", "order"), [("notes", 20000, 1), ("rk4", 200, 4)])
def test_energy_without_torque_drifts_at_the_order_of_the_solver_or_better(solver: str, steps: int, order: int) -> None:
    free = TUMBLE | {"solver": solver, "gravity": [0, 0, 0]}
    energy = run(free, 1e-9, 1)["kinetic_energy"]

    def error(count: int) -> float:
        return abs(run(free, 20.0, count)["kinetic_energy"] - energy)

    assert measured_order(error, steps) > order - 0.2


def test_energy_of_the_notes_drifts_one_way() -> None:
    free = TUMBLE | {"solver": "notes", "gravity": [0, 0, 0]}
    energies = [run(free, end, int(100 * end))["kinetic_energy"] for end in (1.0, 10.0, 20.0, 40.0)]
    assert np.all(np.diff(energies) > 0) or np.all(np.diff(energies) < 0)


def test_without_torque_the_attitude_of_the_notes_is_explicit_eulers_to_the_bit() -> None:
    notes, euler = (run(TUMBLE | {"solver": solver}, 1.0, 100)["orientation"] for solver in ("notes", "explicit_euler"))
    np.testing.assert_array_equal(notes, euler)


def test_symmetric_top_precesses_as_in_the_closed_form() -> None:
    inertia, rate, end = np.array([2.0, 2.0, 0.7]), np.array([0.9, -0.4, 3.0]), 10.0
    momentum = inertia * rate
    # about L by norm(L) t / I_1 in space, after (1 - I_3 / I_1) w_3 t about the body's own axis
    precession = Rotation.from_rotvec(momentum / inertia[0] * end)
    spin = Rotation.from_rotvec([0, 0, (1 - inertia[2] / inertia[0]) * rate[2] * end])
    expected = np.roll((precession * spin).as_quat(), 1)
    last = run({"inertia": inertia, "initial_angular_velocity": rate}, end, 10000)
    # h w = 0.003 over 30 rad: some 30 (h w)^4 / 120
    assert attitude_error(last["orientation"], expected) < 2e-11


def test_spin_about_the_middle_axis_needs_more_than_first_order() -> None:
    spin = {"mass": 1.0, "inertia": INERTIA, "initial_angular_velocity": [0.01, 1.0, 0.01]}
    end = 100.0
    attitude = exact(spin, end, {})["orientation"]

    def error(solver: str) -> float:
        return attitude_error(run(spin | {"solver": solver}, end, 100_000)["orientation"], attitude)

    # an error grows by exp(0.58 t) on the way to each turn; the attitude of order 1 is lost, at 1 ms
    assert error("explicit_euler") > 1.0
    assert error("notes") > 1.0
    assert error("rk4") < 1e-8


# --- orders under loads ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("solver", "load"),
    # without torque moser_veselov is of order 10: see its own file
    [(solver, load) for solver in ORDERS for load in LOADS if (solver, load) != ("moser_veselov", "free")],
)
def test_each_solver_has_its_declared_order(solver: str, load: str) -> None:
    end = 1.0
    expected = exact_tumble(end, load)

    def error(steps: int) -> float:
        last = run(TUMBLE | {"solver": solver}, end, steps, LOADS[load])
        distances = [np.linalg.norm(last[name] - value) for name, value in expected.items() if name != "orientation"]
        return math.hypot(attitude_error(last["orientation"], expected["orientation"]), *distances)

    assert measured_order(error, {1: 1000, 2: 200, 4: 40}[ORDERS[solver]]) == pytest.approx(ORDERS[solver], abs=0.2)


@pytest.mark.parametrize("load", LOADS)
def test_rk4_agrees_with_euler_equations_of_another_integrator(load: str) -> None:
    expected = exact_tumble(1.0, load)
    last = run(TUMBLE | {"solver": "rk4"}, 1.0, 1000, LOADS[load])
    assert attitude_error(last["orientation"], expected["orientation"]) < 1e-11
    for name in ("position", "linear_momentum", "angular_momentum"):
        np.testing.assert_allclose(last[name], expected[name], atol=1e-11)


def test_notes_solver_is_the_scheme_of_the_notes_step_by_step() -> None:
    """P1 = P0 + h F0, v1 = P1 / m, x1 = x0 + h v1, L1 = L0 + h tau0, w1 = I_world(q0)^-1 L1, then q."""
    h, mass, force, torque = 0.05, TUMBLE["mass"], np.array([3.0, -1.0, 2.0]), np.array([4.0, 1.0, -5.0])
    with start(TUMBLE | {"solver": "notes", "solver_step": h}) as body:
        body.set("force", force)
        body.set("torque", torque)
        for k in range(3):
            matrix = rotation(body.get("orientation"))
            linear = body.get("linear_momentum") + h * (force + mass * GRAVITY)
            angular = body.get("angular_momentum") + h * torque
            position = body.get("position") + h * linear / mass
            rate = matrix @ np.diag(1 / INERTIA) @ matrix.T @ angular
            # q + h/2 (0, w) q, normalised, is the turn by 2 atan(h w / 2) about w
            speed = np.linalg.norm(rate)
            turn = Rotation.from_rotvec(2 * math.atan(h * speed / 2) * rate / speed)
            body.step(k * h, h)
            np.testing.assert_allclose(body.get("linear_momentum"), linear, rtol=1e-14)
            np.testing.assert_allclose(body.get("angular_momentum"), angular, rtol=1e-14)
            np.testing.assert_allclose(body.get("position"), position, rtol=1e-13)
            np.testing.assert_allclose(rotation(body.get("orientation")), turn.as_matrix() @ matrix, atol=1e-14)


# --- conventions ----------------------------------------------------------------------------


def test_inertia_in_the_world_is_r_i_rt_and_not_the_notes_form() -> None:
    with start(TUMBLE) as body:
        body.step(0.0, 0.7)
        matrix, momentum = rotation(body.get("orientation")), body.get("angular_momentum")
        rate = body.get("angular_velocity")
    np.testing.assert_allclose(matrix @ np.diag(1 / INERTIA) @ matrix.T @ momentum, rate, atol=1e-14)
    assert np.linalg.norm(matrix.T @ np.diag(1 / INERTIA) @ matrix @ momentum - rate) > 0.1


def work_balance(times: np.ndarray, energies: np.ndarray, rates: np.ndarray, torque: np.ndarray) -> float:
    """J; energy gained less the work of a constant torque, by Simpson's rule."""
    return energies[-1] - energies[0] - simpson(rates @ torque, x=times)


TORQUE = np.array([0.8, -0.5, 1.5])


def test_power_of_force_and_torque_is_all_the_energy_gained() -> None:
    force, count, h = np.array([1.0, -2.0, 15.0]), 1000, 0.002
    rates, energies, positions = np.empty((count + 1, 3)), np.empty(count + 1), np.empty((count + 1, 3))
    with start(TUMBLE) as body:
        body.set("force", force)
        body.set("torque", TORQUE)
        for k in range(count + 1):
            rates[k], positions[k] = body.get("angular_velocity"), body.get("position")
            energies[k] = body.get("kinetic_energy") + body.get("potential_energy")
            body.step(k * h, h)
    energies -= positions @ force
    # Simpson's rule: some T h^4 / 180 times the fourth derivative of the power, of size 50
    assert abs(work_balance(np.arange(count + 1) * h, energies, rates, TORQUE)) < 1e-11


def test_notes_form_of_the_inertia_breaks_the_balance_of_power_by_order_one() -> None:
    """The same run with w = R^T I^-1 R L, R from body to world, integrated in NumPy."""
    times = np.linspace(0, 2, 1001)
    first = rotation(TUMBLE["initial_orientation"])
    momentum = first @ (INERTIA * (first.T @ TUMBLE["initial_angular_velocity"]))

    def balance(angular_velocity) -> float:
        def slope(t: float, y: np.ndarray) -> np.ndarray:
            matrix = y.reshape(3, 3)
            return np.cross(angular_velocity(matrix, t), matrix, axisb=0, axisc=0).ravel()

        solution = solve_ivp(slope, (0, 2), first.ravel(), "DOP853", times, rtol=1e-12, atol=1e-12)
        rates = np.array([angular_velocity(y.reshape(3, 3), t) for t, y in zip(times, solution.y.T, strict=True)])
        energies = 0.5 * np.einsum("ki,ki->k", rates, momentum + np.outer(times, TORQUE))
        return work_balance(times, energies, rates, TORQUE)

    def right(matrix: np.ndarray, t: float) -> np.ndarray:
        return matrix @ (matrix.T @ (momentum + t * TORQUE) / INERTIA)

    def notes(matrix: np.ndarray, t: float) -> np.ndarray:
        return matrix.T @ (matrix @ (momentum + t * TORQUE) / INERTIA)

    assert abs(balance(right)) < 1e-10
    assert abs(balance(notes)) > 0.1


def test_initial_angular_velocity_is_in_the_world_on_a_quaternion_of_any_length() -> None:
    quaternion = np.array([0.5, -0.7, 0.1, 0.9])
    with start(TUMBLE | {"initial_orientation": quaternion}) as body:
        np.testing.assert_allclose(body.get("angular_velocity"), TUMBLE["initial_angular_velocity"], atol=1e-15)
        np.testing.assert_allclose(body.get("orientation"), quaternion / np.linalg.norm(quaternion), atol=1e-15)


@pytest.mark.parametrize("frame", ["", "base_", "tip_"])
def test_velocity_and_acceleration_of_each_frame_are_the_slopes_of_its_motion(frame: str) -> None:
    h = 1e-4
    with start(TUMBLE | {"solver_step": h}) as body:
        for name, value in LOADS["at the frames, with slopes"].items():
            if not name.endswith("_rate"):
                body.set(name, value)
        positions, velocities, accelerations = [], [], []
        for k in range(3):
            positions.append(body.get(frame + "position"))
            velocities.append(body.get(frame + "velocity"))
            accelerations.append(body.get(frame + "acceleration"))
            body.step(k * h, h)
    # h^2 / 6 times a third derivative of size up to 100
    np.testing.assert_allclose((positions[2] - positions[0]) / (2 * h), velocities[1], atol=2e-7)
    np.testing.assert_allclose((velocities[2] - velocities[0]) / (2 * h), accelerations[1], atol=2e-7)


def test_frames_lie_where_the_attitude_puts_them() -> None:
    with start(TUMBLE) as body:
        body.step(0.0, 0.4)
        matrix = rotation(body.get("orientation"))
        for frame in ("base", "tip"):
            expected = body.get("position") + matrix @ TUMBLE[frame]
            np.testing.assert_allclose(body.get(frame + "_position"), expected, atol=1e-15)


def test_angular_acceleration_is_the_slope_of_the_angular_velocity() -> None:
    h = 1e-4
    with start(TUMBLE | {"solver_step": h}) as body:
        body.set("torque", TORQUE)
        rates, accelerations = [], []
        for k in range(3):
            rates.append(body.get("angular_velocity"))
            accelerations.append(body.get("angular_acceleration"))
            body.step(k * h, h)
    np.testing.assert_allclose((rates[2] - rates[0]) / (2 * h), accelerations[1], atol=1e-8)


@pytest.mark.parametrize("moment", range(3))
def test_principal_moment_above_the_sum_of_the_others_is_refused(moment: int) -> None:
    inertia = np.ones(3)
    inertia[moment] = 2.1
    with Slave("RigidBody") as body, pytest.raises(UnitError, match=rf"inertia\[{moment + 1}\]"):
        body.set("inertia", inertia)
        body.initialize(start=0.0)


def test_flat_body_is_accepted() -> None:
    inertia = [0.7, 0.1, 0.8]
    assert inertia[2] > inertia[0] + inertia[1]  # by rounding alone
    with start({"inertia": inertia}) as body:
        assert body.get("kinetic_energy") == 0.0
