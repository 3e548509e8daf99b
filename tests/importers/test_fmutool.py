"""fmu-manipulation-toolbox: its checks find nothing, and would find something; it compiles the sources."""

import logging
import zipfile
from pathlib import Path

import numpy as np
import pytest
from importer_cases import each_unit, each_version, needs, same_bits_expected

import ulna
from ulna import Slave


def complaints(fmu: Path, log: pytest.LogCaptureFixture) -> list[str]:
    """What the checkers of fmutool log as errors, as `fmutool -check` does."""
    operations = needs("fmu-manipulation-toolbox", "fmu_manipulation_toolbox.operations")
    checker = needs("fmu-manipulation-toolbox", "fmu_manipulation_toolbox.checker")
    checkers = [made() for made in checker.get_checkers()]
    assert len(checkers) >= 2
    log.clear()
    with operations.FMU(str(fmu)) as opened:
        for check in checkers:
            opened.apply_operation(check)
    return [record.getMessage() for record in log.records if record.levelno >= logging.ERROR]


@each_unit
@each_version
def test_the_checks_find_nothing(name, version, caplog):
    assert complaints(ulna.fmu(name, version), caplog) == []


@each_version
def test_the_checks_find_an_output_that_the_model_structure_forgets(version, caplog, tmp_path):
    broken = tmp_path / "RigidBody.fmu"
    with zipfile.ZipFile(ulna.fmu("RigidBody", version)) as good, zipfile.ZipFile(broken, "w") as bad:
        for file in good.namelist():
            lines = good.read(file).splitlines(keepends=True)
            if file == "modelDescription.xml":
                tag = b"<Unknown " if version == "2.0" else b"<Output "
                lines.remove(next(line for line in lines if line.lstrip().startswith(tag)))
            bad.writestr(file, b"".join(lines))
    assert any("is not listed" in complaint for complaint in complaints(broken, caplog))


@each_unit
@each_version
def test_compiles_the_sources_to_the_same_motion(name, version, tmp_path):
    operations = needs("fmu-manipulation-toolbox", "fmu_manipulation_toolbox.operations")
    compiler = needs("fmu-manipulation-toolbox", "fmu_manipulation_toolbox.compiler")
    bare = tmp_path / "bare" / f"{name}.fmu"
    bare.parent.mkdir()
    with zipfile.ZipFile(ulna.fmu(name, version)) as built, zipfile.ZipFile(bare, "w") as sources:
        for file in built.namelist():
            if not file.startswith("binaries/"):
                sources.writestr(file, built.read(file))
    with operations.FMU(str(bare)) as opened:
        opened.apply_operation(compiler.OperationCompileSources())
        opened.repack(str(tmp_path / f"{name}.fmu"))
    ends = []
    for fmu in (ulna.fmu(name, version), tmp_path / f"{name}.fmu"):
        with Slave(fmu, version=version) as unit:
            unit.initialize()
            for n in range(8):
                unit.step(n / 64, 1 / 64)
            outputs = [v.name for v in unit.description.variables.values() if v.causality == "output"]
            ends.append(np.concatenate([np.ravel(unit.get(output)).astype(float) for output in outputs]))
    if same_bits_expected():
        np.testing.assert_array_equal(ends[1], ends[0])
    else:
        np.testing.assert_allclose(ends[1], ends[0], rtol=1e-9, atol=1e-9)
