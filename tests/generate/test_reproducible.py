"""A build is reproducible: the same sources give the same bytes, wherever and whenever; other sources another token."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from generated import CHECKOUT, CORE, FOLDERS, LICENSE, declaration, each_unit, each_version, files

import ulna
from ulna.generate.declaration import load
from ulna.generate.package import content, core_files, token, unit_files


def build(checkout: Path, name: str, out: Path) -> dict[str, bytes]:
    """Both FMUs of a unit, compiled by CMake from the sources in `checkout`."""
    settings = [f"-DULNA_UNITS={name}", f"-DPython3_EXECUTABLE={sys.executable}"]
    configure = ["cmake", "--preset", "release", "-S", checkout, "-B", out, *settings]
    subprocess.run(configure, cwd=checkout, check=True, capture_output=True)
    subprocess.run(["cmake", "--build", out], check=True, capture_output=True)
    return {path.parent.name: path.read_bytes() for path in sorted(out.glob(f"fmus/*/{name}.fmu"))}


@pytest.fixture(scope="module")
def second_checkout(tmp_path_factory):
    """A copy of what a build needs, in a folder of another name and length, with other times."""
    folder = tmp_path_factory.mktemp("a_checkout_with_quite_another_name")
    for item in ("CMakeLists.txt", "CMakePresets.json", "LICENSE"):
        shutil.copyfile(CHECKOUT / item, folder / item)
    for item in ("fmus", "src"):
        shutil.copytree(CHECKOUT / item, folder / item, copy_function=shutil.copyfile)
    return folder


def test_two_builds_in_different_folders_give_the_same_bytes(second_checkout, tmp_path):
    name = "UltrasonicSensor"
    first = build(CHECKOUT, name, tmp_path / "first")
    assert set(first) == {"2.0", "3.0"}
    assert build(second_checkout, name, second_checkout / "build") == first


@each_unit
@each_version
def test_no_file_tells_when_or_where_it_was_made(name, version):
    with zipfile.ZipFile(ulna.fmu(name, f"{version}.0")) as archive:
        infos = archive.infolist()
        assert {info.date_time for info in infos} == {(1980, 1, 1, 0, 0, 0)}
        assert {info.external_attr for info in infos} == {0o644 << 16}
        assert [info.filename for info in infos] == sorted(info.filename for info in infos)
        for info in infos:
            assert str(CHECKOUT).encode() not in archive.read(info), info.filename


@each_unit
@each_version
def test_the_built_fmu_holds_the_sources_of_this_checkout(name, version):
    with zipfile.ZipFile(ulna.fmu(name, f"{version}.0")) as archive:
        held = {file: archive.read(file) for file in archive.namelist() if file.startswith("sources/")}
    expected = {file: text for file, text in files(name, version).items() if file.startswith("sources/")}
    assert held == expected


@each_version
@pytest.mark.parametrize("name", ["RigidBody"])
def test_the_token_changes_with_every_source_and_with_nothing_else(name, version, tmp_path):
    folder, core = tmp_path / "unit", tmp_path / "core"
    shutil.copytree(FOLDERS[name], folder)
    shutil.copytree(CORE, core)
    original = token(declaration(name), CORE, version)
    assert token(load(folder / "unit.toml"), core, version) == original
    (folder / "README.md").write_text("Another text.")
    assert token(load(folder / "unit.toml"), core, version) == original
    sources = [folder / "unit.toml", *unit_files(load(folder / "unit.toml")), *core_files(core, version)]
    tokens = {original}
    for path in sources:
        text = path.read_text()
        path.write_text(text + "\n")
        tokens.add(token(load(folder / "unit.toml"), core, version))
        path.write_text(text)
    assert len(tokens) == 1 + len(sources)


def test_every_unit_and_version_has_its_own_token():
    tokens = {token(declaration(name), CORE, version) for name in FOLDERS for version in (2, 3)}
    assert len(tokens) == 2 * len(FOLDERS)


@each_unit
@each_version
def test_generating_twice_gives_the_same_text(name, version):
    assert content(load(FOLDERS[name] / "unit.toml"), CORE, version, "1.2.3", LICENSE) == files(name, version)
