"""The sources that an FMU ships become a library by Clang for other systems and processors, without a warning."""

import subprocess
import sys
from pathlib import Path

import pytest
from importer_cases import HEADERS, each_unit, each_version, extract, needs

TARGETS = {"x86_64-windows-gnu": (), "x86_64-macos": (), "aarch64-macos": (), "aarch64-linux-gnu": ("-lm",)}
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")  # as CMakeLists.txt


@pytest.mark.parametrize("target", TARGETS)
@each_version
@each_unit
def test_clang_compiles_the_sources_without_a_warning(name, version, target, tmp_path):
    needs("ziglang", "ziglang")
    sources = extract(name, version, tmp_path) / "sources"
    files = [path for path in ("fmu.c", "complex.c") if (sources / path).is_file()]
    library = Path(tmp_path, name)
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-std=c11", "-O0", "-shared", "-fPIC"]
    command += ["-ffp-contract=off", *WARNINGS, f"-DFMI{version[0]}_OVERRIDE_FUNCTION_PREFIX="]
    command += [f"-I{HEADERS}", *files, "-o", str(library), *TARGETS[target]]
    done = subprocess.run(command, cwd=sources, capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr
    assert library.stat().st_size > 0
