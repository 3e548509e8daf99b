"""The chart of the sensor: it writes what it says, its truths are sound, its figures are those of known readings."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from ulna.charts import sensor_truths
from ulna.charts.command import chart
from ulna.charts.sensor_measuring import QUICK, Accuracy, agreement, fidelities, percentile, ping, posed, takes
from ulna.charts.sensor_peers import Rays, rays
from ulna.charts.sensor_statements import agreement as agreement_statements
from ulna.charts.sensor_truths import TRUTHS, WALL, capsule_at, device, plane_at, sphere_at, towards

app = typer.Typer()
app.command()(chart)
AHEAD = np.array([1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of a quick run of the command, and what it printed."""
    folder = tmp_path_factory.mktemp("chart")
    result = CliRunner().invoke(app, ["sensor", "--quick", "--out", str(folder)], env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    return folder, result.output


@pytest.fixture(scope="module")
def document(drawn: tuple[Path, str]) -> dict[str, Any]:
    return json.loads((drawn[0] / "sensor.json").read_text(), parse_constant=pytest.fail)


@pytest.fixture(scope="module")
def rows(document: dict[str, Any]) -> dict[tuple[str, str], dict]:
    return {(row["name"], row["truth"]): row for row in document["accuracies"]}


def test_command_writes_pictures_every_fidelity_and_statements(drawn, document) -> None:
    folder, output = drawn
    assert (folder / "sensor.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (folder / "sensor.svg").read_text()
    measured = {(cost["name"], cost["truth"]) for cost in document["costs"]}
    assert {(name, truth) for name in ("ray", "cone", "specular") for truth in TRUTHS} <= measured
    assert all(cost["seconds"] > 0.0 for cost in document["costs"])
    assert {name for name, _ in measured} - {Rays.NAME} == set(fidelities())
    assert "specular" in output and "sensor.json" in output
    # all but those of time, which a busy machine may miss, and of the forearm's tail, which so few poses do not show
    told = [s for s in document["statements"] if "ns a" not in s["claim"] and "forearm" not in s["claim"]]
    assert len(told) >= 4
    assert all(statement["holds"] for statement in told)


def test_closed_forms_agree_with_wave_theory_and_rays_do_not(rows) -> None:
    for truth in TRUTHS:
        own = rows["specular", truth]
        assert own["poses"] == QUICK.poses
        assert own["detection"] >= 0.95
        # a hundredth of a wavelength of 8.6 mm, the least that a phase of a percent can mean
        assert own["median"] < 0.1e-3
        for name in ("ray", "cone"):
            # the threshold walk alone is a millimetre at 5 cm and five at 1 m
            assert rows[name, truth]["median"] > 1e-3
            assert rows[name, truth]["detection"] < own["detection"]
    # levels of the plane: both know the beam at the carrier; what it does over the burst is a second order
    assert rows["specular", "plane"]["level_percentile_95"] < 0.05
    assert not rows["specular", f"sphere, {WALL}"]["level_errors"]


def test_mujoco_sees_what_the_ray_sees(rows) -> None:
    """Of its rays' errors and detections; where it is installed."""
    for (name, truth), row in rows.items():
        if name == Rays.NAME and WALL not in truth:
            # nearer than the blind zone's end by half a baseline or not: a pose or two
            assert row["detection"] == pytest.approx(rows["ray", truth]["detection"], abs=2.1 / QUICK.poses)


def test_rays_of_the_peer_are_those_of_geometry() -> None:
    tilted = towards(20.0, 1.0)
    cases = (
        (plane_at(0.8, tilted), 0.8 / tilted[0]),
        (sphere_at(0.5, AHEAD, 0.1), 0.5),
        (sphere_at(0.5, towards(40.0, 0.0), 0.1), np.inf),
        (capsule_at(np.array([1.0, -0.2, 0.0]), np.array([1.0, 0.2, 0.0]), 0.04), 0.96),
    )
    for pose, length in cases:
        peer = rays(pose)
        assert peer is None or peer.length() == pytest.approx(length, rel=1e-12)


def test_walls_stand_behind_and_beside_their_targets() -> None:
    """A wall's way to its mirror point passes the target at a distance, so that it is not in the shade."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        pose = TRUTHS[f"sphere, {WALL}"](rng)
        center, radius = pose.inputs["sphere_center"], pose.inputs["sphere_radius"]
        wall = pose.inputs["plane_point"]
        along = np.clip(np.dot(center, wall) / np.dot(wall, wall), 0, 1)
        assert np.linalg.norm(center - along * wall) > radius + 0.1
        normal = pose.inputs["plane_normal"]
        assert np.dot(center - wall, normal) > radius


def test_agreement_of_known_readings() -> None:
    """Two right, one 2 mm late, one missed, one false, one silent in both."""
    true = np.array([(1e-3, -10.0), (2e-3, -20.0), (3e-3, -30.0), (4e-3, -30.0), (np.inf, -90.0), (np.inf, -90.0)])
    read = np.array(
        [(1e-3, -10.0), (2e-3, -20.5), (3e-3 + 4e-3 / 340, -30.0), (np.inf, -200.0), (1e-3, 0.0), (np.inf, -200.0)]
    )
    row = agreement("specular", "sphere", read, true, 340.0)
    assert row.detection == pytest.approx(4 / 6)
    assert row.silent == 1
    assert row.errors == pytest.approx([0.0, 0.0, 2e-3], abs=1e-15)
    assert row.level_errors == pytest.approx([0.0, 0.0, 0.5])
    before_a_wall = agreement("specular", f"sphere, {WALL}", read + [[1e-3, 0.0]] * 6, true, 340.0)
    assert before_a_wall.detection == 0.0, "17 cm off is another echo"
    assert np.isnan(percentile([], 95))


def test_statements_fail_where_a_fidelity_does() -> None:
    for error, holds in ((0.2e-3, True), (2e-3, False)):
        made = [
            Accuracy("specular", t, False, 10, 0.9 + 0.1 * holds, 0, [error] * 10, []) for t in ("sphere", "forearm")
        ]
        assert [statement.holds for statement in agreement_statements(made)] == [holds] * 4


def test_a_pose_is_heard_as_its_closed_form_says() -> None:
    ears = device()
    width, level = ping("ray", plane_at(1.0, AHEAD))
    way = 2.0 * np.hypot(1.0, ears.baseline / 2)
    assert width == pytest.approx(way / ears.speed, rel=1e-12)
    assert level == pytest.approx(20.0 * np.log10(2.0 / way) - way * ears.absorption, abs=1e-12)
    assert ping("ray", sphere_at(1.0, towards(40.0, 0.0), 0.1))[0] == np.inf


def test_without_scipy_the_chart_says_what_brings_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError("No module named 'scipy'", name="scipy")

    monkeypatch.setattr(sensor_truths, "load_model", missing)
    result = CliRunner().invoke(app, ["sensor", "--quick", "--out", str(tmp_path)], env={"COLUMNS": "200"})
    assert result.exit_code == 2
    assert "need scipy: pip install 'ulna[peers]'" in result.output


def test_surface_gets_the_mesh_in_place_of_the_body_and_automatic_beside_a_capsule() -> None:
    forearm = capsule_at(np.array([1.0, -0.1, 0.0]), np.array([1.0, 0.1, 0.0]), 0.04)
    ball = sphere_at(1.0, AHEAD, 0.1)
    for fidelity, pose, meshed, bodied in (
        ("specular", forearm, False, True),
        ("surface", forearm, True, False),
        ("automatic", forearm, True, True),
        ("surface", ball, True, False),
        ("automatic", ball, False, True),
    ):
        with posed(fidelity, pose) as sensor:
            assert (sensor.get("surface_vertex_count") > 100) == meshed
            assert (sensor.get("capsule_1_radius") + sensor.get("sphere_radius") > 0.0) == bodied
    assert not takes("surface", plane_at(1.0, AHEAD)) and takes("automatic", plane_at(1.0, AHEAD))
