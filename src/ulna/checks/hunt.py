"""Hunting mutants: each is built, judged, and must be found by a check; and each check must find one."""

import os
import subprocess
import tempfile
import zipfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path

import fmpy

from ..generate.package import platform_folder, write_fmu
from ..paths import fmu
from .as_built import unit_as_built
from .built_steps import steps_as_built
from .claims import Row, of_equations, of_steps
from .judge import VERSIONS, units
from .lift import SNIPPETS, extract, lift, precompiled, read_header
from .mutants import Mutant, all_mutants
from .needs import c_compiler
from .solvers import cases_of, of_solvers
from .textbook import load_model

STEP_FILES = ("solvers.c", "splitting.c")
PATH_FILES = ("geometric.c", "moser_veselov_series.h", "taylor.c", "adaptive.c", "exact.c", "elliptic.c")
SKIN_FILES = ("motion.h", "rings.h", "vertices.h")
UNIT_FILES = ("vector.h", "equations.h", "paths.h", *SKIN_FILES, *STEP_FILES, *PATH_FILES)
"""What is traced, the PATH_FILES along a path only; the rest of an FMU's C is judged as built."""


@dataclass(frozen=True)
class Kill:
    """A mutant, and the claims that failed for it."""

    mutant: Mutant
    claims: tuple[str, ...]


def hunt(names: Iterable[str] | None = None) -> tuple[list[Kill], dict[str, list[str]]]:
    """Judges every mutant of some units (default: all), several at a time.

    Returns what was found, and by unit the claims that found no mutant. Raises ValueError for a mutant whose text
    is not in the file once, as after a change of the file.
    """
    names = list(names or units())
    mutants = [mutant for mutant in all_mutants() if mutant.unit in names]
    with precompiled() as header, ProcessPoolExecutor(os.cpu_count()) as pool:
        judged = list(pool.map(judge_mutant, mutants, repeat(header)))
    idle = {}
    for name in names:
        rows = [row for mutant, found in zip(mutants, judged, strict=True) if mutant.unit == name for row in found]
        failed = {row.claim for row in rows if not row.holds}
        idle[name] = [claim for claim in dict.fromkeys(row.claim for row in rows) if claim not in failed]
    kills = [
        Kill(mutant, tuple(row.claim for row in rows if not row.holds))
        for mutant, rows in zip(mutants, judged, strict=True)
    ]
    return kills, idle


def judge_mutant(mutant: Mutant, header: Path = SNIPPETS) -> list[Row]:
    """The claims about a mutant: of its traced equations or steps, or of its FMUs rebuilt."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        if mutant.undeclared or mutant.file not in UNIT_FILES:
            versions = [version for version in VERSIONS if f"sources/{mutant.file}" in _files(mutant.unit, version)]
            return [row for version in versions for row in _as_built(mutant, version, folder / version)]
        return list(_traced(mutant, mutated(mutant, VERSIONS[0], folder) / "sources", header))


def _traced(mutant: Mutant, sources: Path, header: Path) -> Iterator[Row]:
    model = load_model(read_header(sources / "variables.h").snake)
    if mutant.file not in PATH_FILES:
        claims = of_steps if mutant.file in STEP_FILES else of_equations
        yield from claims(mutant.unit, lift(sources, header), model)
    if mutant.file in STEP_FILES + PATH_FILES:
        yield from of_solvers(mutant.unit, model, cases_of(sources, model, header))


def _files(unit: str, version: str) -> list[str]:
    with zipfile.ZipFile(fmu(unit, version)) as archive:
        return archive.namelist()


def mutated(mutant: Mutant, version: str, folder: Path) -> Path:
    """Extracts a unit's FMU and changes it; returns the folder. Raises ValueError if the text is not there once."""
    with zipfile.ZipFile(fmu(mutant.unit, version)) as archive:
        archive.extractall(folder)
    path = folder / "sources" / mutant.file
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if text.count(mutant.text) != 1:
        raise ValueError(f"{mutant.unit}, {mutant.about}: {text.count(mutant.text)} places in {mutant.file}, not one")
    path.write_text(text.replace(mutant.text, mutant.replacement), encoding="utf-8")
    return folder


def _as_built(mutant: Mutant, version: str, folder: Path) -> Iterator[Row]:
    """The mutant's FMU against the sound C, or where only the declaration is out of date, against its own."""
    whole = mutated(mutant, version, folder / "mutant")
    compile_sources(mutant.unit, version, whole)
    path = folder / f"{mutant.unit}.fmu"
    write_fmu(path, {p.relative_to(whole).as_posix(): p.read_bytes() for p in whole.rglob("*") if p.is_file()})
    sources = extract(path if mutant.undeclared else fmu(mutant.unit, version), folder / "lifted")
    lifted = lift(sources)
    model = load_model(lifted.header.snake)
    yield from unit_as_built(mutant.unit, path, lifted, model)
    yield from steps_as_built(mutant.unit, path, cases_of(sources, model))


def compile_sources(unit: str, version: str, folder: Path, optimization: str = "-O0") -> None:
    """Compiles an extracted FMU's sources in place of its binary; raises RuntimeError with the compiler's message."""
    sources = folder / "sources"
    binary = next((folder / "binaries" / platform_folder(int(version[0]))).glob(f"{unit}.*"))
    headers = Path(fmpy.__file__).parent / "c-code"
    files = [name for name in ("fmu.c", "complex.c") if (sources / name).is_file()]
    command = [c_compiler(), "-std=c11", optimization, "-w", "-shared", "-fPIC", "-ffp-contract=off", f"-I{headers}"]
    command += [f"-DFMI{version[0]}_OVERRIDE_FUNCTION_PREFIX=", f"-I{sources}", *files, "-o", str(binary), "-lm"]
    done = subprocess.run(command, cwd=sources, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{unit}: the mutant does not compile:\n{done.stderr[-2000:]}")
