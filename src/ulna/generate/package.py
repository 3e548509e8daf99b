"""The files inside an FMU, and the FMU itself: the same input gives the same bytes."""

import hashlib
import html
import platform
import uuid
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

from . import c_source, model_description
from .declaration import Declaration
from .model_description import scalar_name, to_string

LONG_AGO = (1980, 1, 1, 0, 0, 0)
TERMINAL_FILE = {2: "extra/org.ulna/terminalsAndIcons.xml", 3: "terminalsAndIcons/terminalsAndIcons.xml"}


def unit_files(unit: Declaration) -> list[Path]:
    """The unit's own C files."""
    return [unit.folder / name for name in ("equations.h", *unit.sources)]


def core_files(core: Path, version: int) -> list[Path]:
    """The C files of the FMI interface that an FMU carries."""
    return [core / name for name in (*c_source.HEADERS, *c_source.CORE, *c_source.INTERFACE[version])]


def token(unit: Declaration, core: Path, version: int) -> str:
    """The instantiation token: it changes when the declaration, any source, or what is generated from them does."""
    digest = hashlib.sha256()
    for path in [unit.folder / "unit.toml", *unit_files(unit), *core_files(core, version)]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    for name, text in generated_sources(unit, version, "").items():
        digest.update(name.encode() + b"\0" + text.encode() + b"\0")
    return "{" + str(uuid.UUID(bytes=digest.digest()[:16])) + "}"


def build_description(unit: Declaration) -> str:
    """`buildDescription.xml`: what to compile, for importers that find no binary for their platform."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=unit.name)
    files = ET.SubElement(configuration, "SourceFileSet", language="C11")
    for name in model_description.sources(unit):
        ET.SubElement(files, "SourceFile", name=name)
    # a shared library exports the plain names; who links several units into one program leaves this out
    ET.SubElement(files, "PreprocessorDefinition", name="FMI3_OVERRIDE_FUNCTION_PREFIX", value="")
    return to_string(root)


def terminals(unit: Declaration, version: int) -> str:
    """`terminalsAndIcons.xml`: a frame, a wrench with it, as one connection; members match by name."""
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion=f"{version}.0")
    parent = ET.SubElement(root, "Terminals")
    for name, description in unit.terminals.items():
        terminal = ET.SubElement(parent, "Terminal", name=name, matchingRule="bus", description=description)
        for v in unit.variables:
            for member in (t.split(".")[1] for t in v.terminal if t.split(".")[0] == name and version in v.fmi):
                for element in range(v.count if version == 2 else 1):
                    suffix = f"[{element + 1}]" if v.size and version == 2 else ""
                    variable = scalar_name(v, element) if version == 2 else v.name
                    ET.SubElement(
                        terminal,
                        "TerminalMemberVariable",
                        variableName=variable,
                        memberName=member + suffix,
                        variableKind="signal",
                    )
    return to_string(root)


def documentation(unit: Declaration) -> str:
    """`documentation/index.html`: the table of variables and the unit's README."""
    rows = []
    for v in unit.variables:
        if v.visible:
            limits = " to ".join("" if x is None else f"{x:g}" for x in (v.min, v.max))
            cells = (v.name, v.causality, " x ".join(map(str, v.size)), v.unit, limits.strip(), v.description)
            rows.append("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>")
    head = "".join(f"<th>{name}</th>" for name in ("name", "causality", "size", "unit", "range", "description"))
    readme = (unit.folder / "README.md").read_text(encoding="utf-8")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{unit.name}</title></head>\n<body>\n'
        f"<h1>{unit.name}</h1>\n<p>{html.escape(unit.description)}</p>\n"
        f"<table>\n<tr>{head}</tr>\n" + "\n".join(rows) + "\n</table>\n"
        f"<pre>\n{html.escape(readme)}</pre>\n</body>\n</html>\n"
    )


def generated_sources(unit: Declaration, version: int, mark: str) -> dict[str, str]:
    """The C files that are not in the repository."""
    files = {
        "variables.h": c_source.variables_header(unit),
        "table.h": c_source.table(unit),
        "fmu.c": c_source.unit_source(unit, version, mark),
    }
    if unit.directional_derivatives:
        files["complex.c"] = c_source.directional_source(unit)
    return files


def content(unit: Declaration, core: Path, version: int, release: str, license_file: Path) -> dict[str, bytes]:
    """All files of the FMU but its binary, by their paths inside it."""
    mark = token(unit, core, version)
    describe = {2: model_description.fmi2, 3: model_description.fmi3}[version]
    files = {
        "modelDescription.xml": describe(unit, mark, release),
        "documentation/index.html": documentation(unit),
        TERMINAL_FILE[version]: terminals(unit, version),
    }
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(unit)
    for name, text in generated_sources(unit, version, mark).items():
        files[f"sources/{name}"] = text
    raw = {name: text.encode() for name, text in files.items()}
    raw["documentation/licenses/license.txt"] = license_file.read_bytes()
    for path in [*unit_files(unit), *core_files(core, version)]:
        raw[f"sources/{path.name}"] = path.read_bytes()
    return raw


def platform_folder(version: int) -> str:
    """The folder below `binaries/` for the machine that runs this."""
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "darwin"}[platform.system()]
    if version == 2:
        return {"linux": "linux64", "windows": "win64", "darwin": "darwin64"}[system]
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    return f"{machine}-{system}"


def write_fmu(path: Path, files: dict[str, bytes]) -> None:
    """A zip with sorted names and fixed times."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name, LONG_AGO)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, files[name])
