"""What the build calls: `python -m ulna.generate sources|package ...`."""

import argparse
from pathlib import Path

from .declaration import load
from .package import content, generated_sources, platform_folder, token, write_fmu


def main() -> None:
    """Writes the generated C of a unit (`sources`), or zips its FMU with the compiled binary (`package`)."""
    parser = argparse.ArgumentParser(prog="python -m ulna.generate", description=__doc__)
    parser.add_argument("action", choices=("sources", "package"))
    parser.add_argument("unit", type=Path, help="folder of the unit, with its unit.toml")
    parser.add_argument("--version", type=int, choices=(2, 3), required=True, help="version of FMI")
    parser.add_argument("--core", type=Path, required=True, help="folder of the C files of the FMI interface")
    parser.add_argument("--license", type=Path, required=True)
    parser.add_argument("--release", required=True, help="version of Ulna")
    parser.add_argument("--binary", type=Path, help="shared library to pack")
    parser.add_argument("--out", type=Path, required=True, help="folder (sources) or FMU (package)")
    arguments = parser.parse_args()
    unit = load(arguments.unit / "unit.toml")
    if arguments.action == "package":
        files = content(unit, arguments.core, arguments.version, arguments.release, arguments.license)
        library = f"binaries/{platform_folder(arguments.version)}/{unit.name}{arguments.binary.suffix}"
        write_fmu(arguments.out, files | {library: arguments.binary.read_bytes()})
        return
    arguments.out.mkdir(parents=True, exist_ok=True)
    mark = token(unit, arguments.core, arguments.version)
    for name, text in generated_sources(unit, arguments.version, mark).items():
        (arguments.out / name).write_text(text, encoding="utf-8")


main()
