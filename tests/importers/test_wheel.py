"""Both ways to build without make: pip, which carries the FMUs in the wheel, and CMake alone."""

import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest
from importer_cases import CHECKOUT, UNITS, VERSIONS

NOT_SOURCES = shutil.ignore_patterns("build", ".*_cache", ".git", ".venv", "results", "__pycache__", "node_modules")


@pytest.fixture
def checkout(tmp_path):
    """A copy of the repository in which nothing has been built."""
    return Path(shutil.copytree(CHECKOUT, tmp_path / "checkout", ignore=NOT_SOURCES))


@pytest.fixture
def bare_python(tmp_path):
    """A Python with pip that has no other package."""
    venv.create(tmp_path / "venv", with_pip=True)
    return tmp_path / "venv" / "bin" / "python"


def run(*command: str | Path, cwd: Path) -> str:
    """What the command prints; where the tests' own Python finds its packages is kept from it."""
    environment = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(list(map(str, command)), cwd=cwd, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_all_units_are_built_by_default():
    text = (CHECKOUT / "CMakeLists.txt").read_text()
    (listed,) = re.findall(r"set\(ULNA_UNITS ([\w ]+?) CACHE", text)
    assert set(listed.split()) == set(UNITS)


def test_the_wheel_carries_fmus_that_are_found_from_anywhere(checkout, tmp_path):
    """One unit of all, for time's sake; the rest of them goes the same way."""
    wheels = tmp_path / "wheels"
    one = "--config-settings=cmake.define.ULNA_UNITS=RigidBody"
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", one, "--wheel-dir", wheels, ".", cwd=checkout)
    (wheel,) = wheels.glob("ulna-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        carried = {name for name in archive.namelist() if name.endswith(".fmu")}
        if shutil.which("npm"):
            assert {f"ulna/viewer/{name}" for name in ("bundle.js", "page.html", "page.css")} <= set(archive.namelist())
        archive.extractall(tmp_path / "installed")
    assert carried == {f"ulna/fmus/{version}/RigidBody.fmu" for version in VERSIONS}
    shutil.rmtree(checkout)
    code = f"import sys; sys.path.insert(0, {str(tmp_path / 'installed')!r}); import ulna; print(ulna.fmu('RigidBody'))"
    path = Path(run(sys.executable, "-I", "-S", "-c", code, cwd=tmp_path).strip())
    assert path == tmp_path / "installed" / "ulna" / "fmus" / "3.0" / "RigidBody.fmu"
    assert path.is_file()


def test_cmake_alone_builds_with_a_python_that_has_no_package(checkout, bare_python):
    run("cmake", "--preset", "release", f"-DPython3_EXECUTABLE={bare_python}", "-DULNA_UNITS=RigidBody", cwd=checkout)
    run("cmake", "--build", "--preset", "release", cwd=checkout)
    assert {path.parent.name for path in checkout.glob("build/fmus/*/RigidBody.fmu")} == set(VERSIONS)
