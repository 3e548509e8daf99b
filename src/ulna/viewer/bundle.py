"""Bundles the script of view.html, main.js with three.js, into one file by esbuild.

    python bundle.py FILE

npm fetches what package-lock.json pins, into the folder of FILE. Where there is no npm, or no way to its registry, says
so and writes nothing: all else works without.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PINNED = ("package.json", "package-lock.json")
INSTALL = "ci --ignore-scripts --no-audit --no-fund --loglevel=error --fetch-retries=1".split()
BUNDLE = "--bundle --minify --format=iife --target=es2022 --legal-comments=none --log-level=warning".split()


def install(folder: Path) -> None:
    """Installs the pinned packages into a folder, unless it has them; raises CalledProcessError if npm cannot."""
    modules = folder / "node_modules"
    stamp = modules / "installed.json"
    lock = (HERE / "package-lock.json").read_bytes()
    if stamp.is_file() and stamp.read_bytes() == lock:
        return
    folder.mkdir(parents=True, exist_ok=True)
    for name in PINNED:
        shutil.copy(HERE / name, folder / name)
    subprocess.run([shutil.which("npm"), *INSTALL], cwd=folder, check=True)
    stamp.write_bytes(lock)


def bundle(out: Path) -> None:
    """Writes the bundle, under the licence of three.js; raises CalledProcessError if npm or esbuild fails."""
    install(out.parent)
    modules = out.parent / "node_modules"
    # esbuild looks for packages beside the importing file, then here
    command = ["node", modules / "esbuild" / "bin" / "esbuild", HERE / "main.js", *BUNDLE]
    environment = os.environ | {"NODE_PATH": str(modules)}
    script = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout
    licence = (modules / "three" / "LICENSE").read_text(encoding="utf-8").strip()
    out.write_bytes(f"/*! three.js\n{licence}\n*/\n".encode() + script)


def main() -> None:
    """The command; never fails a build, since only view.html is lost."""
    if not (shutil.which("npm") and shutil.which("node")):
        print("view.html needs npm and node, which were not found: built without it")
        return
    try:
        bundle(Path(sys.argv[1]).resolve())
    except subprocess.CalledProcessError as error:
        print(f"built without view.html: {error}")


if __name__ == "__main__":
    main()
