"""The judge's verdicts: every claim about the units holds, and a wrong model or FMU is found."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import typer
from mpmath import mpf
from typer.testing import CliRunner

from ulna import fmu
from ulna.checks.arithmetic import Digits
from ulna.checks.as_built import excess
from ulna.checks.built import Built, RefusedError
from ulna.checks.command import check
from ulna.checks.judge import judge_fmu, judge_unit

sys.path.append(str(Path(__file__).parents[1]))

from toy_fmu import toy

EXAMPLE = Path(__file__).parents[2] / "examples" / "check_my_fmu" / "pendulum.py"
UNITS = ("RigidBody", "HingedBody", "CompliantJoint", "ArmSkin", "UltrasonicSensor")

TOY_MODEL = """
def equations(values):
    return {"y": FACTOR * values["u"]}
"""

app = typer.Typer()
app.command()(check)


def command(*arguments):
    return CliRunner().invoke(app, list(map(str, arguments)))


def failed(rows):
    return [f"{row.claim}: {row.bound}" for row in rows if not row.holds]


@pytest.mark.parametrize("unit", UNITS)
def test_every_claim_about_a_unit_holds(unit):
    rows = list(judge_unit(unit))
    assert rows and not failed(rows)


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_example_model_fits_the_hinged_body(version):
    rows = list(judge_fmu(fmu("HingedBody", version), EXAMPLE))
    assert len(rows) >= 4 and not failed(rows)


def test_a_wrong_sign_in_a_model_fails_its_identity_its_values_and_its_derivatives(tmp_path):
    path = tmp_path / "wrong.py"
    path.write_text(EXAMPLE.read_text().replace("- z * ca.sin(angle)", "+ z * ca.sin(angle)"))
    assert len(failed(judge_fmu(fmu("HingedBody"), path))) == 4
    assert command(fmu("HingedBody"), "--model", path).exit_code == 1


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize(("factor", "holds"), [("1.0", True), ("1.001", False)])
def test_a_strangers_fmu_is_judged_by_a_model_of_three_lines(tmp_path, version, factor, holds):
    path = tmp_path / "model.py"
    path.write_text(TOY_MODEL.replace("FACTOR", factor))
    assert bool(failed(judge_fmu(toy(version), path))) != holds


def test_a_model_of_what_the_fmu_does_not_have_fails_with_the_name(tmp_path):
    path = tmp_path / "model.py"
    path.write_text("def equations(values):\n    return {'wings': values['u']}\n")
    assert any("wings" in claim for claim in failed(judge_fmu(toy(), path)))


def test_json_holds_every_claim_with_its_verdict():
    done = command("ArmSkin", "--json")
    content = json.loads(done.stdout)
    assert done.exit_code == 0 and content["holds"] is True
    assert {"unit", "claim", "how", "bound", "holds"} == set(content["claims"][0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ArmSkn"], "did you mean 'ArmSkin'"),
        (["./my.fmu"], "--model my_model.py"),
        ([fmu("ArmSkin"), "--model", "nowhere.py"], "no model file"),
        ([fmu("ArmSkin"), "--model", __file__], "no function equations"),
    ],
)
def test_a_wrong_call_is_answered_with_the_right_one(arguments, message):
    done = command(*arguments)
    assert done.exit_code == 2
    assert message in done.output


def test_a_value_that_the_fmu_refuses_is_reported_in_its_own_words():
    with Built(fmu("RigidBody")) as built, pytest.raises(RefusedError, match="mass"):
        built.initialize({"mass": np.array([-1.0])})


def test_states_that_no_initialization_reaches_are_set_through_model_exchange():
    long = np.array([1.2, 0.0, 0.9, 0.0])
    with Built(fmu("RigidBody")) as built:
        built.initialize({})
        built.move({"orientation": long})
        assert built.read("orientation").tolist() == long.tolist()


def test_excess_counts_in_roundings_of_the_terms():
    # 1 + 1 - 1: exact, and one rounding of 2 and one of 1 allowed, and that of the result
    expected = [Digits(mpf(1), 1.0, 3.0)]
    assert excess([1.0], expected) == 0.0
    assert excess([1.0 + 4 * 2**-53], expected) == pytest.approx(1.0)
    assert excess([np.nan], expected) == np.inf
