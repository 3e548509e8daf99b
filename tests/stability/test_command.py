"""`ulna stability rigid-body`: what it writes and says."""

import json
from xml.etree import ElementTree

import pytest
import typer
from typer.testing import CliRunner

from ulna.stability import command

SIGNATURE = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def app(monkeypatch, found) -> typer.Typer:
    """The command, with the measurements that all tests share."""
    monkeypatch.setattr(command, "measure", lambda quick: found)
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
    assert "rigid-body" in result.output
