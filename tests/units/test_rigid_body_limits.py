"""RigidBody says once that an internal step is beyond its solver's limit; solvers that choose their steps never do."""

import pytest

from ulna import Slave

RATE = 10.0  # rad/s


def warnings(solver: str, turn: float) -> int:
    """Lines about the limit in the log after two steps, the body turning by `turn` rad in each internal one."""
    step = turn / RATE
    with Slave("RigidBody") as body:
        for name, value in {"solver": solver, "solver_step": step, "gravity": [0, 0, 0]}.items():
            body.set(name, value)
        body.set("initial_angular_velocity", [0, 0, RATE])
        body.initialize()
        body.step(0.0, step)
        body.step(step, step)
        return sum("beyond the limit" in message for _, _, message in body.messages.latest)


@pytest.mark.parametrize(
    ("solver", "limit"),
    # 1 % of energy in one of Euler's steps; the limit of rk4 on a harmonic motion; half a turn
    [("explicit_euler", 0.14), ("notes", 0.14), ("rk4", 2.83), ("splitting", 3.14)],
)
def test_a_step_beyond_the_limit_of_a_solver_is_said_once(solver: str, limit: float) -> None:
    assert warnings(solver, 1.1 * limit) == 1
    assert warnings(solver, 0.9 * limit) == 0


@pytest.mark.parametrize("solver", ["taylor", "exact", "automatic"])
def test_a_solver_that_chooses_its_steps_has_no_limit(solver: str) -> None:
    assert warnings(solver, 100.0) == 0


def test_states_whose_sum_is_beyond_all_numbers_are_no_error() -> None:
    place = [1.7e308, 1.7e308, -1e308]
    with Slave("RigidBody") as body:
        for name, value in {"initial_position": place, "gravity": [0, 0, 0]}.items():
            body.set(name, value)
        body.initialize()
        body.step(0.0, 1.0)
        assert list(body.get("position")) == place
