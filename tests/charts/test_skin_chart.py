"""The chart of skins: it writes what it says, shapes are ordered as the closed forms demand, peers agree."""

import json
from math import cos, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from ulna.bench.arm_skin import SKEW, posed
from ulna.bench.skinning import rest_mesh, skinned
from ulna.charts.command import chart
from ulna.charts.skin_kernel import kernel, levels
from ulna.charts.skin_measuring import QUICK, Cost, Mesh, Shape, angles, bent, fold_fraction, normal_error, volume_ratio
from ulna.charts.skin_peers import peers, position_peers
from ulna.charts.skin_speed import Speed, imported_arm
from ulna.charts.skin_statements import sound_up_to
from ulna.charts.skin_strip import edges, seen
from ulna.skin_mesh import write_mesh

app = typer.Typer()
app.command()(chart)
METHODS = ("rigid", "linear_blend", "hinge", "dual_quaternion", "center_of_rotation", "compensated")
BLENDS = ("hinge", "dual_quaternion", "center_of_rotation", "compensated")
BANDS = QUICK.vertices // 32 // 4 * 2
RINGS_APART = 2.5 / BANDS**2
"""Of the volume: a band of chords turned by d lacks d^2/6; half a turn blended over n has a mean d^2 of 13.4/n^2."""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of a quick run of the command, and what it printed."""
    folder = tmp_path_factory.mktemp("chart")
    result = CliRunner().invoke(app, ["skin", "--quick", "--out", str(folder)], env={"COLUMNS": "200"})
    assert result.exit_code == 0, result.output
    return folder, result.output


@pytest.fixture(scope="module")
def document(drawn: tuple[Path, str]) -> dict[str, Any]:
    return json.loads((drawn[0] / "skin.json").read_text(), parse_constant=pytest.fail)


@pytest.fixture(scope="module")
def shapes(document: dict[str, Any]) -> dict[tuple[str, str, float], Shape]:
    return {(row["name"], row["bend"], row["angle"]): Shape(**row) for row in document["shapes"]}


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    with posed("rigid", bent("flexion", 0.0), QUICK.vertices) as skin:
        return Mesh(*rest_mesh(QUICK.vertices), skin.get("triangles").reshape(-1, 3)[:-4])


def test_command_writes_pictures_costs_shapes_and_statements(drawn: tuple[Path, str], document: dict[str, Any]) -> None:
    folder, output = drawn
    for name in ("skin.png", "skin_strip.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (folder / "skin.svg").read_text()
    costs = [Cost(**row) for row in document["costs"]]
    assert [cost.name for cost in costs if not cost.peer] == list(METHODS)
    assert all(cost.seconds > 0.0 for cost in costs)
    count = len(angles("flexion", QUICK)) + len(angles("twist", QUICK))
    assert len(document["shapes"]) == count * len(costs)
    assert "linear_blend" in output and "skin.json" in output
    # all but those of time, which a busy machine may miss
    assert all(s["holds"] for s in document["statements"] if not s["claim"].startswith("a vertex"))


@pytest.mark.parametrize(("bend", "lost", "power"), [("flexion", 9 / 70, 1), ("twist", 9 / 35, 2)])
def test_linear_blend_loses_the_volume_and_section_of_the_closed_forms(shapes, bend, lost, power) -> None:
    for angle in angles(bend, QUICK):
        own = shapes["linear_blend", bend, angle]
        assert own.volume_error == pytest.approx(-lost * (1 - cos(radians(angle))), abs=RINGS_APART)
        assert own.section == pytest.approx(cos(radians(angle / 2)) ** power, abs=1e-12)


def test_volume_and_bulge_are_ordered_as_the_methods_promise(shapes) -> None:
    for angle in (30.0, 60.0, 90.0, 120.0, 150.0):
        at = {name: shapes[name, "flexion", angle] for name in METHODS}
        assert all(abs(at[name].volume_error) < abs(at["linear_blend"].volume_error) for name in BLENDS)
        assert all(abs(at[name].volume_error) < RINGS_APART for name in ("hinge", "dual_quaternion", "compensated"))
        assert at["linear_blend"].bulge < at["compensated"].bulge < at["hinge"].bulge or angle == 30.0
        assert at["hinge"].bulge == pytest.approx(at["dual_quaternion"].bulge, abs=1e-6)
        assert at["center_of_rotation"].bulge < at["hinge"].bulge
    # the bulge of dual quaternions on a smooth cylinder is 1.146 and 1.192; rings come near it
    for angle, bulge in ((90.0, 1.146), (150.0, 1.192)):
        assert shapes["dual_quaternion", "flexion", angle].bulge == pytest.approx(bulge, abs=2e-3)


def test_twist_keeps_every_blend_of_turns(shapes) -> None:
    for name in BLENDS:
        own = shapes[name, "twist", 180.0]
        assert own.section == pytest.approx(1.0, abs=1e-12) and own.fold_fraction == 0.0
        assert own.bulge == pytest.approx(1.0, abs=1e-5)
    assert shapes["linear_blend", "twist", 180.0].section == pytest.approx(0.0, abs=1e-12)


def test_folds_begin_after_the_closed_forms_and_before_150_degrees(shapes) -> None:
    """From 90 degrees with the linear blend, from 106 with the turn about the pivot."""
    for name in ("linear_blend", "hinge"):
        folded = {angle: shapes[name, "flexion", angle].fold_fraction for angle in angles("flexion", QUICK)}
        assert all(folded[angle] == 0.0 for angle in (0.0, 30.0, 60.0, 90.0))
        assert all(folded[angle] > 0.0 for angle in (120.0, 150.0))
    assert shapes["linear_blend", "flexion", 120.0].fold_fraction > shapes["hinge", "flexion", 120.0].fold_fraction


def test_normals_of_the_unit_are_exact_and_those_of_the_peers_are_not(shapes) -> None:
    own = [s for s in shapes.values() if not s.peer and s.section > 1e-3]
    # float32 positions of a normal of unit length: 6e-8 rad, 4e-6 degrees, some tenfold in a narrow section
    assert max(s.normal_error for s in own) < 1e-4
    # turned normals of the linear blend: means of 3.9, 8.8 and 15.9 degrees at 30, 60 and 90, to the digits given
    for angle, error in ((30.0, 3.9), (60.0, 8.8), (90.0, 15.9)):
        assert shapes["NumPy, linear blend", "flexion", angle].normal_error == pytest.approx(error, abs=0.15)


def test_rigid_skin_is_torn_and_nothing_else_is(shapes) -> None:
    names = {name for name, *_ in shapes}
    sound = {name: sound_up_to(list(shapes.values()), name, "flexion") for name in names}
    assert sound["rigid"] == 0.0 and sound["compensated"] == max(sound.values()) == 90.0
    assert shapes["rigid", "flexion", 90.0].stretch > 15.0
    assert all(s.stretch < 3.0 for s in shapes.values() if s.method != "rigid")


def test_measures_of_the_mesh_are_those_of_the_unit(mesh: Mesh) -> None:
    """The unit's are in float64; the vertices are read in float32, 3e-8 m over 0.04 m and its square in area."""
    for method in METHODS:
        for bend, angle in (("flexion", 140.0), ("twist", 70.0)):
            pose = bent(bend, angle)
            with posed(method, pose, QUICK.vertices) as skin:
                vertices = skin.get("vertices").T
                assert volume_ratio(vertices, mesh) == pytest.approx(skin.get("blend_volume_ratio"), abs=5e-6)
                # a triangle or two may be within FLAT of standing on edge
                assert fold_fraction(vertices, mesh, pose) == pytest.approx(skin.get("fold_fraction"), abs=2.1 / 4092)


def test_peers_skin_the_same_points(mesh: Mesh) -> None:
    found = {peer.name: peer for peer in peers(QUICK.vertices, SKEW)}
    assert "NumPy, linear blend" in found
    for peer in found.values():
        # a few float32 roundings at up to 0.8 m
        assert np.abs(peer.call()[0] - skinned(peer.method, mesh.points, SKEW)).max() < 5e-7, peer.name


def test_peers_that_are_timed_skin_the_same_points(mesh: Mesh) -> None:
    """Positions alone, but for MuJoCo, and as the method beside which they are timed."""
    found = {peer.name: peer for peer in position_peers(QUICK.vertices, SKEW)}
    for peer in found.values():
        places, outward = peer.call()
        assert np.abs(places - skinned(peer.method, mesh.points, SKEW)).max() < 5e-7, peer.name
        assert (outward is not None) == peer.name.startswith("MuJoCo")


def test_speeds_have_every_instruction_set_and_statements(document: dict[str, Any]) -> None:
    found = [Speed(**row) for row in document["speeds"]]
    assert all(s.seconds > 0.0 for s in found)
    assert {s.vertices for s in found} == set(QUICK.sizes)
    named = {(s.name, s.level) for s in found if s.normals}
    for kind in ("rings", "mesh"):
        assert {(f"{kind}, {method}", level) for method in BLENDS for level in levels()} <= named
    claims = [s["claim"] for s in document["statements"] if s["claim"].startswith("a vertex")]
    assert len(claims) >= 5 + 2 * (len(levels()) - 1) and any("hinge" in claim for claim in claims)


def test_arm_of_the_speeds_is_the_procedural_one(tmp_path: Path) -> None:
    write_mesh(tmp_path / "mesh.bin", imported_arm(QUICK.vertices))
    level = levels()[-1]
    with kernel("hinge", SKEW, QUICK.vertices) as rings, kernel("hinge", SKEW, QUICK.vertices, tmp_path) as mesh:
        # float32 at .8 m, twice; normals in skin that shrinks to a fifth
        assert np.abs(rings.deformed(level)[0] - mesh.deformed(level)[0]).max() < 2e-7
        assert np.abs(rings.deformed(level)[1] - mesh.deformed(level)[1]).max() < 5e-6


def test_normals_off_by_a_known_turn_are_seen(mesh: Mesh) -> None:
    """Turned about the bone by one degree, at rest."""
    y, z = mesh.points[:, 1:].T
    turn = np.radians(1.0)
    outward = np.stack([0 * y, np.cos(turn) * y - np.sin(turn) * z, np.sin(turn) * y + np.cos(turn) * z], axis=1) / 0.04
    assert normal_error("linear_blend", mesh, bent("flexion", 0.0), outward) == pytest.approx(1.0, rel=1e-6)


def test_strip_leaves_the_tear_open() -> None:
    whole, torn = (len(seen(method, "flexion", 90.0)[0]) for method in ("compensated", "rigid"))
    assert whole == 2 * 4096 - 4 and 16 <= whole - torn <= 128, "within the two bands at the elbow"
    assert edges(np.eye(3)[None]) == pytest.approx(np.full((1, 3), 2**0.5))
