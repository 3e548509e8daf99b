"""Lifting: a unit's C, unchanged, compiled on symbols and read back as CasADi functions.

`equations.h` (with `solvers.c`, where there is one) is compiled as C++ with `real` a symbolic number and run
once; what it computes is then known as expressions. The sources are those that the FMU itself carries.
"""

import hashlib
import os
import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import casadi
from casadi import SX

from .needs import cpp_compiler

SNIPPETS = Path(__file__).parent / "lift"
LIBRARY = Path(casadi.__file__).parent
COUNTS = {"real": 1, "Vector": 3, "Quaternion": 4}
STRUCT = re.compile(r"typedef struct (?P<unit>\w+) \{(?P<fields>.*?)\n\} (?P=unit);", re.DOTALL)
FIELD = re.compile(r"^\s*(?P<type>real|Vector|Quaternion) (?P<name>\w+)(?:\[(?P<size>\d+)\])?;", re.MULTILINE)


class LiftError(RuntimeError):
    """The C could not be traced: the message holds the compiler's own."""


@dataclass(frozen=True)
class Header:
    """What a unit's generated `variables.h` says: `fields` are its numbers, C name to count of elements."""

    unit: str
    fields: dict[str, int]
    solvers: dict[str, int]
    """Entries of the enumeration Solver and their numbers."""

    @property
    def snake(self) -> str:
        """`RigidBody` -> `rigid_body`, the prefix of the unit's functions."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", self.unit).lower()


def read_header(path: Path) -> Header:
    """Reads a `variables.h`; raises LiftError if it is none."""
    text = path.read_text(encoding="utf-8")
    struct = STRUCT.search(text)
    if not struct:
        raise LiftError(f"{path}: no struct of values in it")
    fields = {f["name"]: COUNTS[f["type"]] * int(f["size"] or 1) for f in FIELD.finditer(struct["fields"])}
    kinds = re.search(r"typedef enum \w+SolverKind \{(.*?)\}", text, re.DOTALL)
    entries = re.findall(r"_SOLVER_(\w+) = (\d+)", kinds[1] if kinds else "")
    return Header(struct["unit"], fields, {entry.lower(): int(number) for entry, number in entries})


def groups_of(header: Header, equations: str) -> list[tuple[str, bool]]:
    """Functions of the whole struct in `equations.h`: name without the prefix, and whether they take a workspace."""
    pattern = rf"static inline void {header.snake}_(\w+)\({header.unit} \*\w+(, const void \*\w+)?\)"
    return [(name, bool(workspace)) for name, workspace in re.findall(pattern, equations)]


def program(header: Header, groups: list[tuple[str, bool]], snippet: Path) -> str:
    """The C++ program that traces a unit and saves its functions in the working directory."""
    unit = header.unit
    text = snippet.read_text(encoding="utf-8") if snippet.is_file() else ""
    lines = ['#include "lift.hpp"', "#define real Real", '#include "equations.h"', ""]
    lines += [f"static {unit} fields(Lift &lift)", "{", f"    {unit} values = {{}};"]
    lines += [f'    lift.input("{name}", REALS(values.{name}));' for name in header.fields]
    lines += ["    return values;", "}", "", f"static void save(Lift &lift, {unit} &values, const char *name)", "{"]
    lines += [f'    lift.changed("{name}", REALS(values.{name}));' for name in header.fields]
    lines += ["    lift.save(name);", "}", "", text, "int main()", "{"]
    for name, workspace in groups:
        call = f"{header.snake}_{name}(&values{', nullptr' if workspace else ''});"
        lines += [f'    {{ Lift lift; {unit} values = fields(lift); {call} save(lift, values, "{name}"); }}']
    if "lift_step(" in text:
        for entry, number in header.solvers.items():
            call = f"if (lift_step(lift, fields(lift), {number}))"
            lines += [f'    {{ Lift lift; {call} {{ lift.save("step_{entry}"); }} }}']
    if "lift_functions(" in text:
        lines += ["    lift_functions();"]
    return "\n".join([*lines, "}", ""])


def cache_folder() -> Path:
    """Where lifted functions are kept: `ulna/lift` in the user's cache folder."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ulna" / "lift"


def _included(sources: Path, text: str, found: dict[str, str]) -> dict[str, str]:
    """The files that a text includes, and those that they include: name to content."""
    for name in re.findall(r'^#include "([^"]+)"', text, re.MULTILINE):
        path = next((folder / name for folder in (sources, SNIPPETS) if (folder / name).is_file()), None)
        if path and name not in found:
            found[name] = path.read_text(encoding="utf-8")
            _included(sources, found[name], found)
    return found


def _digest(sources: Path, text: str) -> str:
    digest = hashlib.sha256(casadi.__version__.encode())
    for name, content in sorted({**_included(sources, text, {}), "": text}.items()):
        digest.update(f"{name}\0{content}\0".encode())
    return digest.hexdigest()[:32]


def _compiler() -> list[str]:
    # -w: the C is checked as C; here only its meaning matters
    return [cpp_compiler(), "-std=c++17", "-O0", "-w", f"-I{LIBRARY / 'include'}"]


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise LiftError(f"{Path(command[0]).name} failed:\n{(done.stderr or done.stdout)[-4000:]}")


def _compile_and_run(sources: Path, text: str, folder: Path, header: Path) -> None:
    (folder / "lift.cpp").write_text(text, encoding="utf-8")
    link = [f"-L{LIBRARY}", "-lcasadi", f"-Wl,-rpath,{LIBRARY}"]
    _run([*_compiler(), f"-I{header}", f"-I{SNIPPETS}", f"-I{sources}", "lift.cpp", "-o", "lift", *link], folder)
    _run(["./lift"], folder)
    (folder / "lift").unlink()


@contextmanager
def precompiled() -> Iterator[Path]:
    """A folder with lift.hpp and, where the compiler is GCC, its precompiled form: for lifting many units at a time."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        shutil.copy(SNIPPETS / "lift.hpp", folder)
        _run([*_compiler(), "-x", "c++-header", "lift.hpp", "-o", "lift.hpp.gch"], folder)
        yield folder


def traced(sources: Path, text: str, header_folder: Path) -> dict[str, casadi.Function]:
    """The functions that a program saves when it is compiled with a unit's sources and run; kept for the next time."""
    folder = cache_folder() / _digest(sources, text)
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent) as scratch:
            made = Path(scratch) / "made"
            made.mkdir()
            _compile_and_run(sources, text, made, header_folder)
            try:
                made.rename(folder)
            except OSError:  # another process was first
                if not folder.is_dir():
                    raise
    return {path.stem: casadi.Function.load(str(path)) for path in sorted(folder.glob("*.casadi"))}


def lift(sources: str | Path, header_folder: Path = SNIPPETS) -> "Lifted":
    """Traces the unit whose C files lie in `sources` (the folder of that name in an FMU).

    `header_folder` holds lift.hpp: see `precompiled`.

    Raises LiftError if the C cannot be traced, MissingNeedError if there is no C++ compiler.
    """
    sources = Path(sources).resolve()
    header = read_header(sources / "variables.h")
    groups = groups_of(header, (sources / "equations.h").read_text(encoding="utf-8"))
    functions = traced(sources, program(header, groups, SNIPPETS / f"{header.snake}.cpp"), header_folder)
    return Lifted(header, [name for name, _ in groups], functions)


def extract(fmu: str | Path, folder: str | Path) -> Path:
    """Extracts an FMU's `sources` into `folder` and returns their path; raises LiftError if it carries none."""
    with zipfile.ZipFile(fmu) as archive:
        names = [name for name in archive.namelist() if name.startswith("sources/") and not name.endswith("/")]
        if "sources/equations.h" not in names:
            raise LiftError(f"{fmu}: it carries no sources/equations.h to lift")
        archive.extractall(folder, names)
    return Path(folder) / "sources"


class Lifted:
    """A unit's C as CasADi functions."""

    def __init__(self, header: Header, groups: list[str], functions: dict[str, casadi.Function]):
        """`functions`: the unit's `groups`, `initialize` among them, `step_SOLVER`, and single functions of the C."""
        self.header = header
        self.groups = groups
        self.functions = functions
        self._place = {key: (name, i) for name, f in functions.items() for key, i in self._results(name, f)}

    def _results(self, name: str, function: casadi.Function) -> Iterator[tuple[str, int]]:
        if name.startswith("step_"):
            return
        for i, output in enumerate(name.removeprefix("to_") for name in function.name_out()):
            if name == "initialize":
                yield f"initial({output})", i
            elif name in self.groups:
                yield (f"der({output.removeprefix('der_')})" if output.startswith("der_") else output), i
            else:
                yield (name if output == "value" else f"{name}.{output}"), i

    @property
    def names(self) -> list[str]:
        """What can be computed: outputs, `der(STATE)`, `initial(NAME)` and the functions' own results."""
        return list(self._place)

    @property
    def results_of(self) -> dict[str, list[str]]:
        """Names of the results of each function, steps aside."""
        owners: dict[str, list[str]] = {}
        for name, (function, _) in self._place.items():
            owners.setdefault(function, []).append(name)
        return owners

    @property
    def states(self) -> list[str]:
        """Names of the continuous states."""
        return [name[4:-1] for name in self._place if name.startswith("der(")]

    @property
    def solvers(self) -> list[str]:
        """Names of the solvers whose step could be traced."""
        return [name.removeprefix("step_") for name in self.functions if name.startswith("step_")]

    def symbols(self) -> dict[str, SX]:
        """A fresh symbol, a column, for every input of every function."""
        sizes = {f.name_in(i): f.size1_in(i) for f in self.functions.values() for i in range(f.n_in())}
        return {name: SX.sym(name, size) for name, size in sizes.items()}

    def _call(self, function: casadi.Function, values: Mapping[str, SX]) -> list[SX]:
        arguments = []
        for i, name in enumerate(function.name_in()):
            value = SX(values[name]) if name in values else SX.sym(name, function.size1_in(i))
            arguments.append(value)
        results = function.call(arguments, True, False)
        return [casadi.densify(result) for result in results]

    def equations(self, values: Mapping[str, SX]) -> "Results":
        """All that the C computes from `values`, by name; names that `values` lacks become free symbols."""
        return Results(self, values)

    def step(self, solver: str, values: Mapping[str, SX], h: SX) -> dict[str, SX]:
        """The states after one internal step of size `h` (s) by a solver."""
        function = self.functions[f"step_{solver}"]
        results = self._call(function, {**values, "h": h})
        return {name.removeprefix("to_"): r for name, r in zip(function.name_out(), results, strict=True)}


class Results(Mapping):
    """What the C computes from some values: each of its functions is called when one of its results is read."""

    def __init__(self, lifted: Lifted, values: Mapping[str, SX]):
        """`values`: by name, columns."""
        self._lifted = lifted
        self._values = dict(values)
        self._done: dict[str, list[SX]] = {}

    def __getitem__(self, name: str) -> SX:
        """The expression of that name, a column; raises KeyError if the C has none."""
        function, place = self._lifted._place[name]
        if function not in self._done:
            self._done[function] = self._lifted._call(self._lifted.functions[function], self._values)
        return self._done[function][place]

    def __iter__(self) -> Iterator[str]:
        """Their names."""
        return iter(self._lifted._place)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._lifted._place)
