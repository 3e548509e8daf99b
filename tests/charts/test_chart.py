"""The chart: every solver is on it, counts and errors are right, and peers are timed as a C program runs them."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ulna.bench.measuring import choices
from ulna.charts import measure, peers
from ulna.charts.driver import compiled
from ulna.charts.measure import COMMUNICATION, STEP, TOLERANCE, Candidate, Counter, Effort, Runner, timed
from ulna.charts.problems import Problem, problems
from ulna.charts.statements import Statement

ALL = {problem.name: problem for problem in problems()}
FEW = Effort(per_decade=1, finest=1e-2, rounds=1, longest=0.02, stride=5)


@pytest.fixture(scope="module")
def points() -> list[measure.Point]:
    return [
        point
        for problem in ALL.values()
        for point in timed([*measure.unit_candidates(problem, FEW)], problem.end, FEW.rounds)
    ]


def test_every_solver_of_the_units_is_on_the_chart(points: list[measure.Point]) -> None:
    for problem in ALL.values():
        found = {point.solver for point in points if point.problem == problem.name}
        assert found == set(choices(problem.unit, "solver"))


def test_points_are_finite_and_cost_something(points: list[measure.Point]) -> None:
    assert all(math.isfinite(point.error) and point.seconds > 0.0 for point in points)


@pytest.mark.parametrize("problem", ALL.values(), ids=ALL)
def test_equations_of_the_reference_are_those_of_the_unit(problem: Problem) -> None:
    runner = Runner(problem)
    coarse, fine = (problem.error(runner.end(runner.start("rk4", solver_step=h))) for h in (1e-3, 5e-4))
    # order four, where roundings of 1e5 steps do not hide it; the next term of the error adds 0.06 at this step
    assert fine < 3e-11 or math.log2(coarse / fine) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(
    ("name", "solver", "each"),
    [
        ("free_asymmetric", "explicit_euler", 1),
        ("free_asymmetric", "rk4", 4),
        ("asymmetric_top", "notes", 1),
        ("asymmetric_top", "rk4", 4),
        ("driven_hinge", "semi_implicit_euler", 1),
        ("driven_hinge", "rk4", 4),
    ],
)
def test_right_hand_sides_of_a_step_are_those_of_the_method(name: str, solver: str, each: int) -> None:
    problem = ALL[name]
    assert Counter(problem)(solver, STEP, 0.01) == pytest.approx(each * problem.end / 0.01)


@pytest.mark.parametrize("name", ["free_asymmetric", "asymmetric_top", "driven_hinge"])
def test_series_of_a_finer_tolerance_have_more_coefficients(name: str) -> None:
    counter = Counter(ALL[name])
    assert 0 < counter("taylor", TOLERANCE, 1e-4) < counter("taylor", TOLERANCE, 1e-12)


def test_what_is_not_counted_is_no_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    counter = Counter(ALL["driven_hinge"])
    monkeypatch.setattr(counter, "_counted", type("Counted", (), {"value": property(lambda _: 0.0, lambda *_: None)})())
    assert counter("rk4", STEP, 0.01) is None


def test_candidates_are_timed_in_turn_and_the_median_counts() -> None:
    order, seconds = [], {"a": iter([1.0, 9.0, 2.0]), "b": iter([3.0, 3.0, 3.0])}

    def candidate(name: str) -> Candidate:
        def run() -> float:
            order.append(name)
            return next(seconds[name])

        return Candidate("any", name, STEP, 0.1, 1e-3, 4.0, run)

    first, second = timed([candidate("a"), candidate("b")], end=2.0, rounds=3)
    assert "".join(order) == "ababab"
    assert (first.seconds, second.seconds, first.evaluations) == (1.0, 1.5, 2.0)


def test_a_step_that_fails_is_no_time() -> None:
    runner = Runner(ALL["driven_hinge"])
    state = runner.start("rk4", solver_step=1e-9)
    assert runner.seconds(state, 1, 1) < 0.0  # 1e10 internal steps are refused


def test_what_rules_a_solver_is_found() -> None:
    free, top = Runner(ALL["dzhanibekov"]), Runner(ALL["asymmetric_top"])
    assert measure.parameter_of(free, "rk4") == STEP
    assert measure.parameter_of(free, "taylor") == TOLERANCE
    assert measure.parameter_of(free, "exact") == COMMUNICATION
    assert measure.parameter_of(top, "taylor") == TOLERANCE


def test_closed_form_does_not_depend_on_the_communication_step() -> None:
    problem = ALL["dzhanibekov"]
    runner = Runner(problem)
    state = runner.start("exact")
    assert max(problem.error(runner.end(state, count)) for count in (1, 10, 1000)) < 1e-12


def test_mujoco_is_timed_without_the_profiler_that_its_python_package_installs() -> None:
    pytest.importorskip("mujoco", reason="install it with: pip install mujoco")
    run = peers.MujocoRun(ALL["driven_hinge"], "RK4", 0.01)
    before, seen = run.profiler.value, []
    loop = run._driver
    run._driver = type(
        "Watched", (), {"time_advances": lambda _, *a: (seen.append(run.profiler.value), loop.time_advances(*a))[1]}
    )()
    run()
    assert before is not None  # if MuJoCo stops installing it, nothing need be turned off
    assert seen == [None]
    assert run.profiler.value == before


@pytest.mark.parametrize("problem", ALL.values(), ids=ALL)
def test_mujoco_moves_the_same_body(problem: Problem) -> None:
    pytest.importorskip("mujoco", reason="install it with: pip install mujoco")
    run = peers.MujocoRun(problem, "RK4", 0.01)
    run()
    assert problem.error(run.place()) < 1e-4  # of order four in h w = 0.12, and 1e-5 for the unit's rk4


@pytest.mark.parametrize("name", ["dzhanibekov", "asymmetric_top", "driven_hinge"])
def test_peers_that_integrate_the_equations_come_to_the_reference(name: str) -> None:
    [*found] = [c for make in (peers.scipy_candidates, peers.cvode_candidates) for c in make(ALL[name], FEW)]
    for solver, bound in (("dop853", 1e-7), ("cvode", 1e-3)):
        errors = [candidate.error for candidate in found if candidate.solver == solver]
        assert min(errors) < bound and errors[-1] < errors[0]
        assert all(candidate.evaluations > 0 for candidate in found)


def test_driver_sums_nothing_but_the_calls() -> None:
    bare = compiled("driver").time_advances
    assert bare(None, None, None, 0) < 1e-3  # no call is made where none is asked for


def test_statement_holds_on_the_right_side_of_its_bound() -> None:
    assert Statement("", 1.2, 1.3, True).holds and not Statement("", 1.4, 1.3, True).holds
    assert Statement("", 31.0, 30.0, False).holds and not Statement("", float("nan"), 30.0, False).holds


def test_command_writes_pictures_and_every_point(
    points: list[measure.Point], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import typer

    from ulna.charts import rigid_body
    from ulna.charts.command import chart

    monkeypatch.setattr(rigid_body, "measured", lambda problem, _: [p for p in points if p.problem == problem.name])
    monkeypatch.setattr(rigid_body, "statements", lambda *_: [Statement("a claim", 1.0, 2.0, True)])
    app = typer.Typer()
    app.command()(chart)
    result = CliRunner().invoke(app, ["rigid-body", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "a claim" in result.output and "holds" in result.output
    for name in ("rigid_body", "rigid_body_evaluations"):
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "<svg" in (tmp_path / f"{name}.svg").read_text()
    document = json.loads((tmp_path / "rigid_body.json").read_text())
    assert {"processor", "system", "compiler"} <= set(document["machine"])
    assert len(document["points"]) == len(points)
    fields = {"problem", "solver", "parameter", "value", "error", "seconds", "evaluations"}
    assert all(set(point) == fields for point in document["points"])
    assert np.isfinite([point["seconds"] for point in document["points"]]).all()


def test_unknown_chart_is_told_the_nearest() -> None:
    import typer

    from ulna.charts.command import chart

    app = typer.Typer()
    app.command()(chart)
    result = CliRunner().invoke(app, ["rigid-bdy"])
    assert result.exit_code == 2 and "rigid-body" in result.output
