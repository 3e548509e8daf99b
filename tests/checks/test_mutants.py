"""Broken units are found out. `ulna check --mutants` does this for all; here for one unit and the notes' errors."""

import dataclasses
import zipfile

import pytest

from ulna import fmu
from ulna.checks.hunt import hunt, judge_mutant
from ulna.checks.judge import units
from ulna.checks.mutants import all_mutants

NOTES = (
    "R^T I R",
    "integral of m |r|",
    "the notes' x = v/t",
    "old velocity in place of new",
    "no 1/2 in the quaternion's rate",
    "torque in the world taken for one in the body",
)


def failed(mutant):
    return [row.claim for row in judge_mutant(mutant) if not row.holds]


@pytest.mark.parametrize("about", NOTES)
def test_each_error_of_the_notes_is_found(about):
    mutant = next(mutant for mutant in all_mutants() if about in mutant.about)
    assert failed(mutant)


def test_in_the_sensor_every_mutant_dies_and_every_claim_finds_one():
    kills, idle = hunt(["UltrasonicSensor"])
    assert len(kills) > 20
    assert [kill.mutant.about for kill in kills if not kill.claims] == []
    assert idle == {"UltrasonicSensor": []}


def test_every_mutant_changes_one_place_of_the_files_that_ship():
    for mutant in all_mutants():
        with zipfile.ZipFile(fmu(mutant.unit)) as archive:
            text = archive.read(f"sources/{mutant.file}").decode()
        assert text.count(mutant.text) == 1, mutant.about
        assert mutant.text != mutant.replacement


def test_the_table_covers_all_units_and_the_fmi_layer():
    mutants = all_mutants()
    assert {mutant.unit for mutant in mutants} == set(units())
    assert {"life_cycle.c", "complex_step.h", "sensitivity_adjoint.c"} <= {mutant.file for mutant in mutants}


def test_a_change_that_changes_nothing_lives():
    mutant = all_mutants()[0]
    assert failed(dataclasses.replace(mutant, replacement=f"({mutant.text})")) == []


def test_a_mutant_whose_line_is_gone_is_refused_by_name():
    mutant = dataclasses.replace(all_mutants()[0], text="no such line")
    with pytest.raises(ValueError, match="0 places"):
        judge_mutant(mutant)
