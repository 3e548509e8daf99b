"""`ulna stability`: what it writes and says."""

import json
from xml.etree import ElementTree

import pytest
import typer
from typer.testing import CliRunner

from ulna.stability import command

SIGNATURE = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def app(monkeypatch, found, coupled, skins, sensed) -> typer.Typer:
    """The command, with the measurements that all tests share."""
    subjects = {"rigid-body": found, "coupling": coupled, "skin": skins, "sensor": sensed}
    for subject, rows in subjects.items():
        made = command.MAPS[subject]._replace(measure=lambda quick, rows=rows: rows)
        monkeypatch.setitem(command.MAPS, subject, made)
    app = typer.Typer()
    app.command()(command.stability)
    return app


def test_it_writes_the_map_and_every_point(app, found, tmp_path):
    result = CliRunner().invoke(app, ["rigid-body", "--quick", "--out", str(tmp_path / "new")])
    assert result.exit_code == 0, result.output
    files = {path.suffix: path for path in (tmp_path / "new").iterdir()}
    assert set(files) == {".svg", ".png", ".json"}
    assert files[".png"].read_bytes().startswith(SIGNATURE)
    assert ElementTree.parse(files[".svg"]).getroot().tag.endswith("svg")
    points = json.loads(files[".json"].read_text(), parse_constant=pytest.fail)
    assert set(points) == set(found)
    for topic in ("tumbling", "springs", "held", "spins", "norms", "moments"):
        assert len(points[topic]) == len(found[topic])
    limits = {row["solver"]: row["energy"] for row in points["tumbling"]}
    assert limits["exact"] is None, "no limit, which JSON cannot write as a number"
    assert limits["rk4"] == pytest.approx(0.36, rel=0.1)
    for solver in limits:
        assert solver.split("_")[0] in result.output


def test_another_subject_is_refused_with_what_there_is(app):
    result = CliRunner().invoke(app, ["teapot"])
    assert result.exit_code == 2
    assert all(subject in result.output for subject in ("rigid-body", "coupling", "skin", "sensor"))


def test_the_map_of_couplings_is_written_with_every_cell(app, coupled, tmp_path):
    result = CliRunner().invoke(app, ["coupling", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    files = {path.suffix: path for path in tmp_path.iterdir()}
    assert {path.stem for path in files.values()} == {"coupling_stability"}
    assert files[".png"].read_bytes().startswith(SIGNATURE)
    assert ElementTree.parse(files[".svg"]).getroot().tag.endswith("svg")
    points = json.loads(files[".json"].read_text(), parse_constant=pytest.fail)
    assert {topic: len(rows) for topic, rows in points.items()} == {topic: len(rows) for topic, rows in coupled.items()}
    for cell in points["cells"]:
        assert cell["H"] * (cell["k"] * (1 / 0.8 + 1 / 0.35)) ** 0.5 == pytest.approx(cell["z"])
    for said in ("accurate", "did not settle", "newton", "mass ratio"):
        assert said in result.output


def test_the_map_of_skins_is_written_with_every_cell(app, skins, tmp_path):
    result = CliRunner().invoke(app, ["skin", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    files = {path.suffix: path for path in tmp_path.iterdir()}
    assert {path.stem for path in files.values()} == {"skin_stability"}
    assert files[".png"].read_bytes().startswith(SIGNATURE)
    assert ElementTree.parse(files[".svg"]).getroot().tag.endswith("svg")
    points = json.loads(files[".json"].read_text(), parse_constant=pytest.fail)
    assert {topic: len(rows) for topic, rows in points.items()} == {topic: len(rows) for topic, rows in skins.items()}
    never = [row for row in points["folds"] if row["measured"] is None]
    assert {row["method"] for row in never} == {"hinge", "dual_quaternion"}
    assert "compensated" in result.output and "none" in result.output


def test_the_map_of_the_sensor_is_written_with_every_cell(app, sensed, tmp_path):
    result = CliRunner().invoke(app, ["sensor", "--quick", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    files = {path.suffix: path for path in tmp_path.iterdir()}
    assert {path.stem for path in files.values()} == {"sensor_stability"}
    assert files[".png"].read_bytes().startswith(SIGNATURE)
    assert ElementTree.parse(files[".svg"]).getroot().tag.endswith("svg")
    points = json.loads(files[".json"].read_text(), parse_constant=pytest.fail)
    assert {topic: len(rows) for topic, rows in points.items()} == {topic: len(rows) for topic, rows in sensed.items()}
    for said in ("specular", "plane", "false echo"):
        assert said in result.output
