"""The command `ulna`: what it writes, what it says, and how it ends."""

import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from ulna import Results, cli, gallery
from ulna.paths import fmu

FAILING = '''"""A skin whose forearm loses its orientation."""

import numpy as np

from ulna import Scene

UNTIL = 1.0
STEP = 0.01


def scene():
    failing = Scene("failing")
    arm = failing.add("ArmSkin", "arm")
    failing.signal(arm.forearm_orientation, lambda time: np.array([float(time < 0.495), 0.0, 0.0, 0.0]))
    return failing
'''


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """So that no line is broken."""
    monkeypatch.setattr(cli.console, "width", 200)
    monkeypatch.setattr(cli.errors, "width", 200)


def ulna(*arguments):
    return CliRunner().invoke(cli.app, [str(argument) for argument in arguments])


@pytest.mark.parametrize("name", ["follow", "tumble", "wave"])
def test_run_writes_table_pictures_and_arm(tmp_path, name):
    done = ulna("run", name, "--until", 0.2, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    written = {path.name for path in (tmp_path / "out").iterdir()}
    # without npm there is no page, as test_view tells
    assert written - {"view.html"} == {"results.csv", "plot.png", "picture.png", "arm.glb"}
    assert len(Results.from_csv(tmp_path / "out" / "results.csv")) == 201
    assert "real-time factor" in done.output
    assert "energy" in done.output


def test_run_tells_energies_gaps_and_pings(tmp_path):
    done = ulna("run", "follow", "--step", 0.01, "--out", tmp_path)
    results = Results.from_csv(tmp_path / "results.csv")
    pings = np.diff(results["sensor.sequence"], prepend=0) > 0
    echoes = np.count_nonzero(results["sensor.valid"] & pings)
    assert f"{results['sensor.sequence'][-1]}, of which {echoes} heard an echo" in done.output
    assert f"{1e3 * results['arm.elbow_gap'].max():.2f} mm" in done.output
    for what in ("ball: energy", "forearm: energy", "arm: elbow gap", "arm: volume", "sensor: pings", "loop: "):
        assert what in done.output
    # one every 60 ms from 0 s on, each finished within 9 ms
    assert results["sensor.sequence"][-1] == 167


def test_set_until_and_step_reach_the_run(tmp_path):
    settings = ["--set", "box.initial_velocity=1,2,3", "--set", "box.solver=notes", "--set", "box.mass=2"]
    done = ulna("run", "tumble", "--until", 0.5, "--step", 0.25, *settings, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    results = Results.from_csv(tmp_path / "results.csv")
    np.testing.assert_array_equal(results.time, [0.0, 0.25, 0.5])
    np.testing.assert_allclose(results["box.position"][-1], [0.5, 1.0, 1.5])
    example = gallery.load("tumble")
    with example.build() as scene:
        for name, value in (("initial_velocity", [1, 2, 3]), ("solver", "notes"), ("mass", 2.0)):
            scene["box"].set(name, value)
        expected = scene.run(0.5, 0.25)
    np.testing.assert_array_equal(results["box.orientation"], expected["box.orientation"])


def test_master_reaches_the_run(tmp_path):
    done = ulna("run", "wave", "--until", 0.1, "--master", "jacobi", "--out", tmp_path)
    assert "wave, jacobi" in done.output


def test_tolerance_and_extrapolation_reach_the_run(tmp_path):
    chosen = ulna("run", "swing", "--until", "0.2", "--step", "0.05", "--tolerance", "1e-3", "--out", tmp_path / "a")
    assert "macro steps" in chosen.output and "joints" in chosen.output
    held = ulna("run", "wave", "--until", "0.2", "--master", "jacobi", "--out", tmp_path / "b")
    lines = ulna("run", "wave", "--until", "0.2", "--master", "jacobi", "--extrapolation", "1", "--out", tmp_path / "c")
    assert "coupling: error of an input" in held.output
    assert held.output != lines.output
    refused = ulna("run", "swing", "--tolerance", "2", "--out", tmp_path / "d")
    assert refused.exit_code == 2
    assert "tolerance = 2.0; allowed range: between 0 and 1" in refused.output


def test_a_file_is_a_scene(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(
        '"""One body."""\nfrom ulna import Scene\nUNTIL = 0.01\n\n\ndef scene():\n    mine = Scene("mine")\n'
    )
    path.write_text(path.read_text() + '    mine.add("RigidBody", "body")\n    return mine\n')
    done = ulna("run", path, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    np.testing.assert_allclose(Results.from_csv(tmp_path / "out" / "results.csv").time[-1], 0.01)


@pytest.mark.parametrize(
    ("arguments", "right"),
    [
        (["run", "folow"], "follow"),
        (["run", "tumble", "--set", "bx.mass=1"], "box"),
        (["run", "tumble", "--set", "box.mas=1"], "mass"),
        (["run", "tumble", "--set", "box.solver=rk5"], "rk4"),
        (["run", "tumble", "--set", "box"], "unit.parameter=value"),
        (["run", "tumble", "--set", "box.inertia=1"], "shape"),
        (["run", "tumble", "--set", "box.mass=-1"], "1e-12"),
        (["run", "tumble", "--set", "box.position=0,0,0"], "only parameters and inputs"),
        (["run", "tumble", "--master", "jacoby"], "jacobi"),
        (["run", "tumble", "--step", "0"], "steps of 0.0 s"),
        (["run", "nothing.py"], "nothing.py"),
        (["info", "RigdBody"], "RigidBody"),
        (["info", "nothing.fmu"], "nothing.fmu"),
        (["rum"], "run"),
    ],
)
def test_a_wrong_name_or_value_gets_the_right_one_and_exit_code_2(arguments, right):
    done = ulna(*arguments)
    assert done.exit_code == 2
    assert right in done.output
    assert "Traceback" not in done.output


def test_a_mistake_in_a_scene_file_is_shown_with_its_line(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text('from ulna import Scene\n\n\ndef scene():\n    return Scene("mine").add("RigidBody", "1")\n')
    done = ulna("run", path)
    assert done.exit_code == 2
    assert f"{path}, line 5: '1' cannot name a unit" in done.output


def test_a_scene_function_must_return_a_scene(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def scene():\n    pass\n")
    done = ulna("run", path)
    assert done.exit_code == 2
    assert "returns no Scene" in done.output


def test_a_failing_unit_is_named_with_time_and_log_and_the_rows_before_are_written(tmp_path):
    path = tmp_path / "failing.py"
    path.write_text(FAILING)
    done = ulna("run", path, "--out", tmp_path / "out")
    assert done.exit_code == 1
    assert "arm failed at t = 0.49 s" in done.output
    assert "forearm_orientation has norm 0" in done.output
    assert "Traceback" not in done.output
    np.testing.assert_allclose(Results.from_csv(tmp_path / "out" / "results.csv").time[-1], 0.49)


def test_a_unit_that_refuses_its_scene_is_told_without_a_traceback(tmp_path):
    path = tmp_path / "refused.py"
    path.write_text('from ulna import Scene\n\n\ndef scene():\n    Scene("mine").add("RigidBody", "body", mass=-1.0)\n')
    done = ulna("run", path)
    assert done.exit_code == 1
    assert "mass = -1 kg" in done.output


def test_list_shows_all_scenes_and_units():
    done = ulna("list")
    assert done.exit_code == 0
    units = ("RigidBody", "HingedBody", "CompliantJoint", "ArmSkin", "UltrasonicSensor")
    for name in ("follow", "tumble", "wave", *units, "2.0, 3.0"):
        assert name in done.output


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_info_shows_every_variable_by_name_and_by_path(version):
    by_name = ulna("info", "RigidBody", "--version", version)
    by_path = ulna("info", fmu("RigidBody", version))
    assert by_name.exit_code == 0
    assert by_name.output == by_path.output
    for text in ("initial_angular_velocity", "kg.m2", "automatic", "Potential energy of the weight", f"FMI {version}"):
        assert text in by_name.output


def test_the_command_runs_as_a_module():
    done = subprocess.run([sys.executable, "-m", "ulna.cli", "list"], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "follow" in done.stdout
