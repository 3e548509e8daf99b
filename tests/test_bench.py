"""The benchmarks run, and their errors stand in the order that the READMEs claim; no time is asserted."""

import io
import math
import subprocess
import sys
from contextlib import ExitStack

import pytest
from rich.console import Console

from ulna import bench
from ulna.bench import masters
from ulna.bench.measuring import side_by_side
from ulna.bench.tables import text_of

MASTERS = "masters: a macro step of three units"


@pytest.fixture(scope="module")
def tables() -> dict[str, bench.Table]:
    return {table.title: table for table in bench.run(rounds=1)}


def by_name(table: bench.Table, column: str) -> dict[str, float]:
    return dict(zip(table.column(table.columns[0]), table.column(column), strict=True))


def test_every_subject_gives_finite_numbers(tables: dict[str, bench.Table]) -> None:
    assert {title.split(":")[0] for title in tables} == set(bench.SUBJECTS)
    for table in tables.values():
        assert all(len(row) == len(table.columns) for row in table.rows)
        assert all(math.isfinite(cell) for row in table.rows for cell in row if not isinstance(cell, str))


def test_ratios_are_to_the_cheapest(tables: dict[str, bench.Table]) -> None:
    bodies = "RigidBody: solvers", "HingedBody: solvers", "CompliantJoint: exchange"
    for title in (*bodies, "ArmSkin: methods", "UltrasonicSensor: fidelities", MASTERS):
        assert min(tables[title].column("ratio")) == 1.0


def test_errors_of_the_bodies_fall_from_explicit_euler_to_rk4(tables: dict[str, bench.Table]) -> None:
    ladders = {
        "RigidBody: energy": ("explicit_euler", "notes", "splitting", "rk4"),
        "HingedBody: errors of the angle, rad": ("explicit_euler", "semi_implicit_euler", "rk4"),
    }
    for title, ladder in ladders.items():
        for column in tables[title].columns[1:]:
            found = by_name(tables[title], column)
            errors = [found[solver] for solver in ladder]
            assert errors == sorted(errors, reverse=True)
            assert errors[-1] < 1e-4 * errors[0]


def test_attitude_of_rk4_is_of_order_four_and_that_of_the_notes_is_lost(tables: dict[str, bench.Table]) -> None:
    coarse, fine = (by_name(tables["RigidBody: solvers"], f"attitude, {step} s") for step in ("0.1", "0.01"))
    assert math.log10(coarse["rk4"] / fine["rk4"]) == pytest.approx(4, abs=0.3)
    assert fine["notes"] == fine["explicit_euler"] > 0.5


def test_stability_limits_of_the_default_muscle_are_those_of_its_fast_mode(tables: dict[str, bench.Table]) -> None:
    limits = by_name(tables["HingedBody: solvers"], "stable up to, ms")
    moment, stiffness, damping = 0.020226 + 1.561 * 0.17901**2, 25.0, 8.3
    decay = damping / (2 * moment) + math.sqrt((damping / (2 * moment)) ** 2 - stiffness / moment)
    # |1 - h decay| = 1, and 1 - z + z^2/2 - z^3/6 + z^4/24 = 1 at z = 2.785; the bisection ends at a thousandth
    assert limits["explicit_euler"] == pytest.approx(2000 / decay, rel=3e-3)
    assert limits["rk4"] == pytest.approx(2785 / decay, rel=3e-3)
    # a factor of -1 a step: 1 + sum + product = 0, sum 2 - h (d + h k) / J, product 1 - h d / J; a thousandth of 8
    h = limits["semi_implicit_euler"] / 1000
    assert 4 - 2 * h * damping / moment - h**2 * stiffness / moment == pytest.approx(0, abs=0.01)


def test_skin_is_that_of_the_textbook_to_float32(tables: dict[str, bench.Table]) -> None:
    table = tables["ArmSkin: largest error of a coordinate"]
    assert max(table.column("position, m")) < 1e-7  # what the unit promises within 1 m
    assert max(table.column("normal")) < 1e-6  # some roundings of float32 at 1, and compression


def test_each_method_shows_its_own_fault(tables: dict[str, bench.Table]) -> None:
    table = tables["ArmSkin: what a method does to the arm"]
    gap, section = by_name(table, "gap, mm"), by_name(table, "smallest section")
    assert gap["flexion 90: rigid"] > 10 * gap["flexion 90: linear_blend"]
    assert section["twist 180: linear_blend"] < 1e-12 < section["twist 180: dual_quaternion"]


def test_specular_is_exact_where_a_ray_is_not(tables: dict[str, bench.Table]) -> None:
    aside = by_name(tables["UltrasonicSensor: fidelities"], "error aside, m")
    moving = by_name(tables["UltrasonicSensor: time of flight to a sphere that approaches"], "0.1 m")
    # by the image source a plane nearer to one ear is read as sqrt(d^2 - (b s / 2)^2), s along the baseline
    ears = 0.026 * math.sin(math.radians(8.0)) * math.sin(math.radians(50.0))
    short = 0.5 - math.sqrt(0.25 - ears**2 / 4)
    for target, bent in (
        ("plane", 0.0),
        ("sphere", 1e-3),
        ("capsule", 1e-3),
        ("box", 0.0),
    ):  # round bodies a little less
        assert aside[f"specular: {target}"] == pytest.approx(short, rel=bent, abs=1e-14)  # round-off of 0.5 m
        assert aside[f"ray: {target}"] > 1e-3
    # a ray takes the ball to stand still: off by v / c
    assert moving["specular: 10 m/s"] < 1e-14 < 10 / 345 < moving["ray: 10 m/s"]


def test_masters_and_loops_of_every_version_are_side_by_side(tables: dict[str, bench.Table]) -> None:
    rows = set(tables[MASTERS].column("who steps them"))
    ours = [masters.master_name(master, order) for master, order in masters.EXPLICIT]
    for what in (masters.LOOP, masters.GETTERS, *ours):
        assert {masters.name_of(what, version) for version in masters.VERSIONS} <= rows
    over = by_name(tables[MASTERS], "over the units")
    assert [over[masters.name_of(masters.LOOP, version)] for version in masters.VERSIONS] == [0.0, 0.0]


@pytest.mark.parametrize("version", masters.VERSIONS)
@pytest.mark.parametrize("way", ["in_c", "by_fmpy"])
def test_loops_that_are_timed_do_what_gauss_seidel_does_to_the_bit(version: str, way: str) -> None:
    with masters.chain(version) as scene:
        rows = scene.run(2 * masters.COUNT * masters.STEP, masters.STEP)["third.angle"]
    loop = masters.Loop(version)
    run = getattr(loop, way)()
    for row in (masters.COUNT, 2 * masters.COUNT):
        assert run() > 0.0
        assert loop.angle() == rows[row] != rows[0]
    loop.close()


def test_ecos_does_what_jacobi_does_to_the_bit() -> None:
    with ExitStack() as stack:
        simulation = masters.ecos_simulation(stack)
        if simulation is None:
            pytest.skip("install it with: pip install ecospy tbb")
        assert masters.by_ecos(simulation, masters.COUNT)() > 0.0
        found = simulation.get_real("third::angle")
    with masters.chain("2.0") as scene:
        rows = scene.run(masters.COUNT * masters.STEP, masters.STEP, master="jacobi")["third.angle"]
    assert found == rows[-1] != rows[0]


def test_a_unit_that_fails_in_the_loop_of_c_is_no_time() -> None:
    loop = masters.Loop("3.0")
    loop.row = 1  # not where the units are
    with pytest.raises(RuntimeError, match="fails in the loop of C"):
        loop.in_c()()
    loop.close()


def test_candidates_take_turns() -> None:
    order = []
    result = side_by_side({name: lambda name=name: order.append(name) for name in "ab"}, rounds=3)
    assert "".join(order) == "abababab"
    assert min(ratio for _, ratio in result.values()) == 1.0


def test_tables_fit_into_eighty_columns(tables: dict[str, bench.Table]) -> None:
    console = Console(width=80, record=True, file=io.StringIO())
    bench.show(list(tables.values()), console)
    text = console.export_text()
    assert "…" not in text
    assert "dual_quaternion" in text


@pytest.mark.parametrize(
    ("number", "text"),
    [(0.0, "0"), (1.0, "1"), (69.23, "69.2"), (1512.0, "1.5e3"), (3.04e-12, "3.0e-12"), (0.0041, "4.1e-3")],
)
def test_numbers_are_short(number: float, text: str) -> None:
    assert text_of(number) == text


def test_wrong_unit_is_told_the_nearest() -> None:
    result = subprocess.run(
        [sys.executable, "-m", "ulna.bench", "RigidBdy"], capture_output=True, text=True, check=False
    )
    assert result.returncode == 1
    assert "RigidBody" in result.stderr and "Traceback" not in result.stderr


def test_without_scipy_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.integrate", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'ulna\[test\]'"):
        bench.run(["HingedBody"], rounds=1)
