"""FMPy: validates, simulates and compiles every unit."""

import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu
from importer_cases import (
    HEADERS,
    UNITS,
    each_kind,
    each_unit,
    each_version,
    extract,
    library,
    motion,
    needs,
    same_bits_expected,
)

import ulna

EXCHANGED = [name for name, raw in UNITS.items() if "model-exchange" in raw["kinds"]]


def outputs(rows: np.ndarray) -> np.ndarray:
    """All columns of a result of FMPy, flat for each row, as numbers."""
    return np.column_stack([np.asarray(rows[name], float).reshape(len(rows), -1) for name in rows.dtype.names])


def simulate(fmu: Path, name: str, version: str, kind: str = "CoSimulation", **options) -> np.ndarray:
    settings = {"stop_time": 0.5, "output_interval": 0.01, "relative_tolerance": 1e-9} | options
    return outputs(fmpy.simulate_fmu(str(fmu), fmi_type=kind, start_values=motion(name, version), **settings))


@each_unit
@each_version
def test_validation_finds_nothing(name, version):
    assert validate_fmu(str(ulna.fmu(name, version))) == []


@each_kind
@each_version
def test_simulates_to_the_stop_time(name, version, kind):
    rows = simulate(ulna.fmu(name, version), name, version, kind)
    assert rows[0, 0] == 0.0
    assert rows[-1, 0] == pytest.approx(0.5, abs=1e-12)
    assert np.isfinite(rows).all()
    assert np.ptp(rows[:, 1:], axis=0).any() or name not in EXCHANGED


@pytest.mark.parametrize("name", EXCHANGED)
@each_version
def test_model_exchange_agrees_with_co_simulation(name, version):
    """CVode holds the error of each step of its own to the tolerance; it takes less than a thousand, and these motions
    do not grow errors. The unit's own rk4 at 1 ms is more exact than that."""
    fmu = ulna.fmu(name, version)
    states = [v.derivative.name for v in fmpy.read_model_description(fmu).modelVariables if v.derivative]
    stepped = simulate(fmu, name, version, output=states)
    scale = np.maximum(1.0, np.abs(stepped).max(axis=0))
    errors = []
    for tolerance in (1e-5, 1e-9):
        options = {"output": states, "relative_tolerance": tolerance}
        errors.append(np.max(np.abs(simulate(fmu, name, version, "ModelExchange", **options) - stepped) / scale))
        assert errors[-1] < 1e3 * tolerance
    assert errors[1] < 1e-2 * errors[0]


@pytest.mark.parametrize("name", [name for name, raw in UNITS.items() if raw.get("events")])
@pytest.mark.parametrize("early", [False, True])
def test_fmpy_handles_the_events_itself_with_the_same_result(name, early):
    """It records the row before and the row after each event. A run without event mode has the former, as the unit then
    handles what is due in the step that follows; at the start, where FMPy has the latter only, nothing is compared."""
    fmu = ulna.fmu(name, "3.0")
    rows = defaultdict(list)
    for row in simulate(fmu, name, "3.0", use_event_mode=True, early_return_allowed=early):
        rows[round(row[0], 9)].append(row[1:])
    for row in simulate(fmu, name, "3.0")[1:]:
        np.testing.assert_allclose(rows[round(row[0], 9)][0], row[1:], rtol=1e-9)


def without_binaries(name: str, version: str, folder: Path) -> Path:
    extract(name, version, folder)
    shutil.rmtree(folder / "binaries")
    return folder


def assert_same_motion(folder: Path, name: str, version: str) -> None:
    """The same bits where no compiler may fuse a multiply and an add; else round-off, grown over the steps."""
    compiled, built = simulate(folder, name, version), simulate(ulna.fmu(name, version), name, version)
    if same_bits_expected():
        np.testing.assert_array_equal(compiled, built)
    else:
        np.testing.assert_allclose(compiled, built, rtol=1e-9, atol=1e-9)


@each_unit
@each_version
def test_sources_compile_with_fmpy_and_run(name, version, tmp_path):
    folder = without_binaries(name, version, tmp_path / "fmu")
    build_platform_binary(folder)
    assert_same_motion(folder, name, version)


@each_unit
def test_sources_compile_with_fmi_bd2cmake_and_run(name, tmp_path):
    needs("fmi-bd2cmake", "fmi_bd2cmake")
    folder = without_binaries(name, "3.0", tmp_path / "fmu")
    for command in (
        [sys.executable, "-m", "fmi_bd2cmake.cli"],
        ["cmake", "-B", "build", f"-DFMI_HEADERS_DIR={HEADERS}", "."],
        ["cmake", "--build", "build"],
        ["cmake", "--install", "build"],
    ):
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
    assert library(folder, name).is_file()
    assert_same_motion(folder, name, "3.0")


@each_unit
@each_version
def test_sources_compile_without_a_warning(name, version, tmp_path):
    folder = without_binaries(name, version, tmp_path / "fmu")
    warnings = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror", "-std=c11", "-fsyntax-only"]
    for source in sorted({"fmu.c", "complex.c"} & {path.name for path in (folder / "sources").iterdir()}):
        subprocess.run(["cc", *warnings, f"-I{HEADERS}", str(folder / "sources" / source)], check=True)
