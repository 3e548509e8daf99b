"""The command `ulna`: run a scene, list what there is, look into an FMU."""

import ast
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from fmpy import read_model_description
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from .charts.command import chart
from .checks.command import check
from .coupling import CouplingError
from .description import read_description
from .gallery import Example, load, scenes
from .gltf import write_glb
from .masters import MASTERS
from .names import unknown
from .paths import fmu, names
from .plot import filmstrip, plot
from .report import summary
from .results import Results
from .scene import Scene
from .skin_automatic import JOINTS
from .skin_import import import_skin, import_unrigged
from .slave import UnitError
from .stability.command import stability
from .view import write_view

FAILED = 1
WRONG = 2
# What a wrong name, path or value raises.
MISTAKES = (KeyError, AttributeError, ValueError, TypeError, FileNotFoundError, ModuleNotFoundError)

Failure = UnitError | CouplingError

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
app.command()(check)
app.command()(chart)
app.command()(stability)
skin = typer.Typer(no_args_is_help=True, help="A skin of your own for ArmSkin.")
app.add_typer(skin, name="skin")
console = Console()
errors = Console(stderr=True)


@app.command()
def run(
    scene: Annotated[str, typer.Argument(help="Name of an example (see 'ulna list'), or path of a Python file.")],
    until: Annotated[float | None, typer.Option(help="End of the run, s.")] = None,
    step: Annotated[float | None, typer.Option(help="Step of the master, s.")] = None,
    master: Annotated[str | None, typer.Option(help=f"How units step together: {', '.join(MASTERS)}.")] = None,
    extrapolation: Annotated[int, typer.Option(help="Order, 0 or 1, in which inputs go on over a step.")] = 0,
    tolerance: Annotated[
        float | None, typer.Option(help="Error of an input, relative, by which the macro step is chosen.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="UNIT.PARAMETER=VALUE", help="Value of a parameter; repeatable."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder to write to; default: results/SCENE.")] = None,
) -> None:
    """Runs a scene; writes results.csv, plot.png, picture.png, arm.glb and view.html."""
    with _mistakes(scene):
        example = load(scene)
        master = master or example.master
        if master is not None and master not in MASTERS:
            raise KeyError(unknown("ulna", "master", master, MASTERS))
        built = example.build()
        if not isinstance(built, Scene):
            raise ValueError(f"scene() in {example.path} returns no Scene")
        for setting in settings or []:
            _apply(built, setting)
    with built:
        until, step = example.until if until is None else until, example.step if step is None else step
        with _mistakes(scene, (ValueError,)):
            results, failure = _simulate(
                built, until, step, master=master, extrapolation=extrapolation, tolerance=tolerance
            )
        folder = out or Path("results") / example.name
        written = _write(results, built, folder) if results else []
        if failure:
            _print_failure(failure, built)
        else:
            _print_summary(example, results)
    if written:
        console.print(f"{folder}: {', '.join(written)}", markup=False, highlight=False)
    if failure:
        raise typer.Exit(FAILED)


@app.command("list")
def list_all() -> None:
    """Lists the scenes and the units."""
    table = Table("scene", "what happens", title="ulna run SCENE", title_justify="left")
    for name in scenes():
        table.add_row(name, escape(load(name).about))
    console.print(table)
    table = Table("unit", "FMI", "what it is", title="ulna info UNIT", title_justify="left")
    versions = {version: names(version) for version in ("2.0", "3.0")}
    for name in sorted(set().union(*versions.values())):
        built = [version for version, units in versions.items() if name in units]
        about = read_model_description(str(fmu(name, built[-1])), validate=False).description or ""
        table.add_row(name, ", ".join(built), escape(about))
    console.print(table)


@app.command()
def info(
    unit: Annotated[str, typer.Argument(metavar="FMU", help="Name of a unit, or path of an .fmu file.")],
    version: Annotated[str, typer.Option(help="FMI version of a unit given by name: 2.0 or 3.0.")] = "3.0",
) -> None:
    """Shows the variables of an FMU."""
    with _mistakes(unit):
        is_path = unit.endswith(".fmu") or "/" in unit
        description = read_description(unit if is_path else fmu(unit, version))
    table = Table(title=f"{description.name}, FMI {description.version}", title_justify="left")
    table.add_column("name", no_wrap=True, min_width=max(map(len, description.variables)))
    for heading in ("type, unit", "start", "description"):
        table.add_column(heading, overflow="fold")
    for causality in dict.fromkeys(variable.causality for variable in description.variables.values()):
        table.add_section()
        table.add_row(f"[bold]{causality}[/]")
        for variable in (v for v in description.variables.values() if v.causality == causality):
            sizes = "".join(f"[{size}]" for size in variable.dimensions)
            entries = {str(number): name for name, number in variable.entries}
            start = [entries.get(value, value) for value in variable.start]
            # one value for all elements is shown once
            start = start[:1] if len(set(start)) == 1 else start
            row = (variable.name, f"{variable.type}{sizes} {variable.unit}", " ".join(start), variable.description)
            table.add_row(*map(escape, row))
    console.print(table)


@app.command()
def bench(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Names of units, or masters; default: all.")
    ] = None,
) -> None:
    """Measures what each solver, method, fidelity and master costs, and how far it is off."""
    from . import bench as benchmarks

    with _mistakes("bench"):
        benchmarks.show(benchmarks.run(names or []))


@skin.command("import")
def skin_import(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A mesh: .glb; with auto weights .obj, .ply, .stl too.")],
    out: Annotated[Path, typer.Option(help="FMU to write.")],
    upper_arm: Annotated[
        str | None, typer.Option(help="Joint at the shoulder; default: what common rigs call it, left before right.")
    ] = None,
    forearm: Annotated[
        list[str] | None,
        typer.Option(help="Joint at the elbow; repeated: others that follow the forearm and are not below it."),
    ] = None,
    mesh: Annotated[str | None, typer.Option(help="The only mesh to take; default: all that both joints move.")] = None,
    only_arm: Annotated[
        bool,
        typer.Option("--only-arm", help="Of a whole figure, what the arm's joints hold; open at the shoulder."),
    ] = False,
    version: Annotated[str, typer.Option(help="FMI version: 2.0 or 3.0.")] = "3.0",
    weights: Annotated[str, typer.Option(help="file: the file's own; auto: bounded biharmonic weights.")] = "file",
    shoulder: Annotated[str | None, typer.Option(help="With auto: x,y,z in m, y up, or a node's name.")] = None,
    elbow: Annotated[str | None, typer.Option(help="The same.")] = None,
    wrist: Annotated[str | None, typer.Option(help="The same.")] = None,
    blend_half_width: Annotated[
        float | None, typer.Option(help="With auto: where the bones' hold ends, m from the elbow.")
    ] = None,
) -> None:
    """Makes an ArmSkin FMU of a mesh: what is below the forearm follows it, all else the upper arm."""
    places = (shoulder, elbow, wrist)
    with _mistakes(str(file)):
        if weights not in ("file", "auto"):
            raise ValueError(f"--weights {weights}; allowed: file, auto")
        automatic = weights == "auto"
        wrong = (upper_arm, *(forearm or ()), only_arm or None) if automatic else (*places, blend_half_width)
        if any(value is not None for value in wrong) or (automatic and None in places):
            raise ValueError(
                "--shoulder, --elbow and --wrist belong to --weights auto, which needs all three; --upper-arm, "
                "--forearm and --only-arm to --weights file"
            )
        if automatic:
            joints = [_place(place) for place in places]
            made = import_unrigged(file, out, joints, mesh=mesh, half_width=blend_half_width, version=version)
            bones = places
        else:
            how = {"upper_arm": upper_arm, "forearm": forearm or (), "mesh": mesh, "only_arm": only_arm}
            made, bones = import_skin(file, out, **how, version=version)
    table = Table(show_header=False, title=str(out), title_justify="left")
    table.add_row(", ".join(JOINTS if automatic else ("upper arm", "forearm")), escape("; ".join(bones)))
    table.add_row("vertices, triangles", f"{len(made.vertices)}, {len(made.triangles)}")
    for name in ("upper_arm_length", "forearm_length", "radius", "blend_half_width"):
        table.add_row(name, f"{getattr(made, name):.4g} m")
    console.print(table)


def _place(text: str) -> str | list[float]:
    """Numbers x,y,z, or else a name."""
    try:
        return [float(word) for word in text.split(",")]
    except ValueError:
        return text


def main() -> None:
    """The entry point of the command."""
    app()


@contextmanager
def _mistakes(what: str, kinds: tuple[type[Exception], ...] = MISTAKES) -> Iterator[None]:
    """Turns a wrong name or value into a message and exit code 2; says where, if it is in the scene file.

    A unit that fails before the run gives its message and exit code 1.
    """
    try:
        yield
    except UnitError as error:
        errors.print(str(error), markup=False, highlight=False)
        raise typer.Exit(FAILED) from None
    except kinds as error:
        message = error.args[0] if isinstance(error, KeyError) and error.args else str(error)
        frames = traceback.extract_tb(error.__traceback__)
        lines = [
            frame.lineno for frame in frames if what.endswith(".py") and Path(frame.filename).name == Path(what).name
        ]
        where = f"{what}, line {lines[-1]}: " if lines else ""
        errors.print(f"{where}{message}", markup=False, highlight=False)
        raise typer.Exit(WRONG) from None


def _apply(scene: Scene, setting: str) -> None:
    """Sets what "unit.parameter=value" says; values as in Python, entries of enumerations as words."""
    name, equals, text = setting.partition("=")
    unit, dot, parameter = name.strip().partition(".")
    if not (equals and dot and text.strip()):
        raise ValueError(f"--set {setting}: write it as unit.parameter=value")
    try:
        scene[unit].set(parameter, _value(text.strip()))
    except UnitError as error:
        raise ValueError(f"--set {setting}: {error.message}") from None


def _value(text: str) -> Any:
    try:
        return ast.literal_eval({"true": "True", "false": "False"}.get(text, text))
    except (ValueError, SyntaxError):
        return text


def _simulate(scene: Scene, until: float, step: float, **how: Any) -> tuple[Results | None, Failure | None]:
    """What was recorded, and the failure that ended the run."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(scene.name, total=until)
        try:
            return scene.run(until, step, progress=lambda time: progress.update(task, completed=time), **how), None
        except (UnitError, CouplingError) as error:
            return error.results, error


def _write(results: Results, scene: Scene, folder: Path) -> list[str]:
    """Writes the files of a run and returns their names; what lacks a recording, or its maker, is said."""
    writers = {
        "results.csv": results.to_csv,
        "plot.png": lambda path: plot(results, path, scene),
        "picture.png": lambda path: filmstrip(results, scene, path),
        "arm.glb": lambda path: write_glb(path, results, scene),
        "view.html": lambda path: write_view(path, results, scene),
    }
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, write in writers.items():
        try:
            write(folder / name)
            written.append(name)
        except (KeyError, FileNotFoundError) as error:
            errors.print(f"no {name}: {error.args[0]}", markup=False, highlight=False)
    return written


def _print_failure(error: Failure, scene: Scene) -> None:
    if isinstance(error, CouplingError):
        errors.print(f"[bold red]the units cannot be stepped[/]: {escape(str(error))}", highlight=False)
        return
    title = f"[bold red]{escape(error.unit)} failed[/] at t = {error.time:.9g} s: {error.call} returned {error.status}"
    errors.print(title, highlight=False)
    for status, category, message in scene[error.unit].slave.messages.latest:
        errors.print(f"  {status} {category}: {message}", markup=False, highlight=False)


def _print_summary(example: Example, results: Results) -> None:
    table = Table(show_header=False, title=f"{example.name}, {results.summary['master']}", title_justify="left")
    for what, value in summary(results):
        table.add_row(escape(what), escape(value))
    console.print(table)
    for loop in results.summary.get("loops", []):
        console.print(f"loop: {loop}", markup=False, highlight=False)
    if "ended_by" in results.summary:
        console.print(f"ended by {results.summary['ended_by']}", markup=False)


if __name__ == "__main__":
    sys.exit(main())
