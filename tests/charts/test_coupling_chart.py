"""The chart of couplings: every way and master is on it, errors are what theory says, and what is said follows."""

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from ulna.charts import coupled
from ulna.charts.arms import planar_arm
from ulna.charts.chains import ChainCost
from ulna.charts.command import chart
from ulna.charts.coupled import QUICK, CoupledPoint, Failure, Truth, angles, trials
from ulna.charts.coupling_statements import PYTHON, coupling_statements
from ulna.charts.draw_coupling import best, recommended
from ulna.charts.ways import ONE_WAY, RIGID, STIFFNESSES, TWO_WAY, WAYS, compliant_name
from ulna.results import Results

app = typer.Typer()
app.command()(chart)
COMPLIANT = [compliant_name(stiffness) for stiffness in STIFFNESSES]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of a quick run of the command, and what it printed."""
    folder = tmp_path_factory.mktemp("chart")
    result = CliRunner().invoke(app, ["coupling", "--quick", "--out", str(folder)], env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    return folder, result.output


@pytest.fixture(scope="module")
def document(drawn: tuple[Path, str]) -> dict[str, Any]:
    return json.loads((drawn[0] / "coupling.json").read_text())


@pytest.fixture(scope="module")
def points(document: dict[str, Any]) -> list[CoupledPoint]:
    return [CoupledPoint(**point) for point in document["points"]]


def errors(points: list[CoupledPoint], way: str, master: str) -> dict[float, float]:
    """By macro step."""
    return {p.step: p.error for p in points if (p.way, p.master) == (way, master)}


def test_command_writes_pictures_points_and_statements(drawn: tuple[Path, str], document: dict[str, Any]) -> None:
    folder, output = drawn
    assert (folder / "coupling.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (folder / "coupling.svg").read_text()
    assert {"processor", "system", "casadi"} <= set(document["machine"])
    assert [cost["length"] for cost in document["chains"]] == list(QUICK.lengths)
    assert len(document["statements"]) == 8
    assert "chain of ten" in output and "coupling.json" in output


def test_every_way_and_master_has_points_or_says_why_not(document: dict[str, Any]) -> None:
    tried = {(item["way"], item["master"]) for item in document["points"] + document["failed"]}
    assert tried == {(way.name, stepping.name) for way in WAYS for stepping in way.steppings}
    assert {point["way"] for point in document["points"]} == {way.name for way in WAYS}
    assert all(len(failure["reason"]) > 10 for failure in document["failed"])
    assert all(point["seconds"] > 0.0 and 0.0 <= point["error"] <= math.pi for point in document["points"])


def test_rigid_joints_are_of_order_four_and_a_solved_loop_of_order_two(points: list[CoupledPoint]) -> None:
    for way, master, order in ((RIGID, "rigid", 4), (TWO_WAY, "newton", 2), (TWO_WAY, "iterated", 2)):
        found = errors(points, way, master)
        # the next term of the error moves the order by about the step times what the motion changes by, 10 1/s
        assert math.log(found[0.01] / found[0.0025], 4.0) == pytest.approx(order, abs=0.1)


def test_masters_that_solve_the_same_equations_err_the_same(points: list[CoupledPoint]) -> None:
    by_newton, by_iteration = (errors(points, TWO_WAY, master) for master in ("newton", "iterated"))
    for step in by_newton.keys() & by_iteration.keys():
        # both solve to 1e-10 of the inputs
        assert by_newton[step] == pytest.approx(by_iteration[step], rel=1e-5)


def test_an_open_loop_is_of_order_one_and_says_where_it_is_wrong(points: list[CoupledPoint]) -> None:
    found = errors(points, TWO_WAY, "gauss_seidel")
    assert math.log(found[0.0025] / found[0.000625], 4.0) == pytest.approx(1, abs=0.1)
    said = {p.step: p.wrong for p in points if (p.way, p.master) == (TWO_WAY, "gauss_seidel")}
    assert said[0.01]
    assert not any(p.wrong for p in points if (p.way, p.master) in ((TWO_WAY, "newton"), (RIGID, "rigid")))


def test_no_step_mends_what_is_not_fed_back(points: list[CoupledPoint]) -> None:
    assert min(p.error for p in points if p.way == ONE_WAY) > 1.0


def test_compliance_is_a_floor_that_falls_with_stiffness_for_all_masters_alike(points: list[CoupledPoint]) -> None:
    floors = []
    for way in COMPLIANT:
        own = [p.error for p in points if p.way == way]
        floors.append(min(own))
        # of every master at every step that gets to the end, within some percent
        assert len(own) >= 4
        assert max(own) < 1.05 * min(own)
    for soft, stiff in pairwise(floors):
        assert math.log10(soft / stiff) == pytest.approx(1, abs=0.1)


def test_steps_of_units_are_counted(points: list[CoupledPoint]) -> None:
    for p in points:
        units = 4 if p.way in COMPLIANT else 2
        # with lines, a unit that takes no slope makes two half steps; implicit masters repeat steps
        once = p.master in ("jacobi", "gauss_seidel")
        assert p.unit_steps == units * p.macro_steps if once else p.unit_steps >= units * p.macro_steps
    assert min(p.unit_steps / p.macro_steps for p in points if p.way == RIGID) > 2.0


def test_the_reference_has_no_error_and_a_turn_has_its_angle() -> None:
    truth = Truth(planar_arm())
    time = np.arange(501) * 0.01
    columns = {f"body_{k}.orientation": np.zeros((501, 4)) for k in range(2)}
    for k, column in enumerate(columns.values()):
        column[::50] = truth.orientations[:, k] * (-1.0) ** k
    results = Results(time, columns, {})
    assert truth.error(results) == 0.0
    half = 0.5e-6
    c, s = math.cos(half), math.sin(half)
    w, x, y, z = columns["body_1.orientation"][100]
    columns["body_1.orientation"][100] = [w * c - y * s, x * c + z * s, w * s + y * c, z * c - x * s]
    assert truth.error(results) == pytest.approx(1e-6, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 1.0, math.pi])
def test_angle_between_quaternions(angle: float) -> None:
    q, p = np.array([1.0, 0, 0, 0]), np.array([math.cos(angle / 2), 0, math.sin(angle / 2), 0])
    assert angles(p, q) == pytest.approx(angle, rel=1e-9) == angles(-p, q)


def test_counting_leaves_the_scene_as_it_was() -> None:
    way = next(way for way in WAYS if way.name == RIGID)
    with way.build(planar_arm()) as scene:
        _, first = coupled.counted(scene, way.steppings[0], 0.01, None, 0.1)
        _, again = coupled.counted(scene, way.steppings[0], 0.01, None, 0.1)
        assert first == again > 20
        assert all("step_call" not in vars(unit.slave) for unit in scene.units.values())


def test_a_run_that_breaks_off_is_a_failure_with_its_reason() -> None:
    arm = planar_arm()
    way = next(way for way in WAYS if way.name == COMPLIANT[0])
    few = coupled.CoupledEffort((0.02,), (), (), rounds=1, most=1e9, end=5.0, macro_rounds=1)
    with way.build(arm) as scene:
        found = list(trials(way, scene, Truth(arm), arm.end, few))
    explicit = [item for item in found if isinstance(item, Failure) and item.master == "gauss_seidel"]
    assert len(explicit) == 1 and explicit[0].step == 0.02 and "fmi3DoStep" in explicit[0].reason


def made(way: str, master: str, error: float, seconds: float, **values: Any) -> CoupledPoint:
    usual = {
        "step": 0.01,
        "tolerance": None,
        "unit_steps": 1.0,
        "macro_steps": 1.0,
        "wrong": False,
        "largest_gap": None,
    }
    return CoupledPoint(way=way, master=master, error=error, seconds=seconds, **(usual | values))


def test_what_said_that_it_is_wrong_is_never_recommended() -> None:
    cheap, wrong = made(TWO_WAY, "newton", 1e-2, 2.0), made(TWO_WAY, "jacobi", 1e-3, 1.0, wrong=True)
    lost, fine = made(ONE_WAY, "jacobi", 2.0, 0.1), made(RIGID, "rigid", 1e-5, 3.0)
    dear = made(TWO_WAY, "iterated", 1e-4, 9.0)
    everything = [fine, wrong, cheap, lost, dear]
    assert recommended(everything) == [cheap, fine]
    assert best(everything, 0.1) is cheap
    assert best(everything, 5e-3) is fine
    assert best(everything, 1e-6) is None


def test_statements_follow_from_numbers() -> None:
    rigid = [made(RIGID, "rigid", 16 * h**4, 1.0, step=h, largest_gap=1e-13) for h in (0.02, 0.01, 0.0025)]
    two_way = [made(TWO_WAY, "newton", h, 1.0, step=h) for h in (0.02, 0.0025)]  # of order 1, which is not enough
    floors = [made(way, "newton", 1e3 / k, 1.0) for way, k in zip(COMPLIANT, STIFFNESSES, strict=True)]
    costs = [ChainCost(1, 1e-4, 2.0), ChainCost(10, 1.1e-3, 2.0)]
    macro = {PYTHON: 7e-6, "the units in a loop of C, FMI 3": 1e-6, "Ecos, 1 a call, FMI 2": 5e-6}
    macro["the units in a loop of C, FMI 2"] = 2e-6
    one_way = [made(ONE_WAY, "jacobi", 2.0, 1.0)]
    found = coupling_statements([*rigid, *two_way, *floors, *one_way], costs, macro, 5.0)
    values = [(s.value, s.holds) for s in found]
    expected = [(4, True), (1e-13, True), (16e-8, True), (1, False), (2, True), (1, True), (11, False), (6, False)]
    for (value, holds), (wanted, good) in zip(values, expected, strict=True):
        assert value == pytest.approx(wanted, rel=1e-9) and holds == good
    assert "Ecos, 1 a call, FMI 2: 3" in found[-1].note


def test_without_the_reference_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def missing(_: str) -> None:
        raise ModuleNotFoundError("No module named 'casadi'", name="casadi")

    monkeypatch.setattr(coupled, "load_model", missing)
    result = CliRunner().invoke(app, ["coupling", "--quick", "--out", str(tmp_path)], env={"COLUMNS": "200"})
    assert result.exit_code == 2
    assert "casadi" in result.output and "ulna[peers]" in result.output
    assert not list(tmp_path.iterdir())
