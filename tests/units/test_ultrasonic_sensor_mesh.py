"""UltrasonicSensor with a mesh: what is summed with it, where it is not heard, what is refused; `automatic`."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from test_ultrasonic_sensor_echo import BLIND, PITCHED, forearm
from test_ultrasonic_sensor_surface import FINE, FOREARM, WAVELENGTH, facing, heard
from ultrasonic_sensor_read import default_device, ping
from ultrasonic_sensor_truth import Mesh, capsule_mesh, capsule_surface, joined, kirchhoff, plate_mesh, rigid_sphere

from ulna import Slave, UnitError
from ulna.charts.skin_kernel import levels
from ulna.checks.hunt import compile_sources
from ulna.generate.package import write_fmu
from ulna.paths import fmu

START, END = np.array([0.5, -0.1, -0.05]), np.array([0.55, 0.1, 0.08])
ARM = capsule_mesh(START, END, FOREARM, FINE * WAVELENGTH)
CAPSULE = {"capsule_1_start": START, "capsule_1_end": END, "capsule_1_radius": FOREARM}
WALL = {"plane_point": [1.0, 0.0, 0.0], "plane_normal": [-1.0, 0.0, 0.0]}
SURFACE = {"fidelity": "surface"} | ARM.inputs()


# What is summed


def test_the_mesh_stands_for_the_capsules():
    alone, both = ping(**SURFACE), ping(**SURFACE, **CAPSULE)
    assert both == alone
    specular = ping(**CAPSULE)
    # the same body: .35 mm and .25 dB are what `surface` is held to, `specular` to 1 mm
    assert alone["time_of_flight"] == pytest.approx(specular["time_of_flight"], abs=2 * 1.35e-3 / 343)
    assert alone["level"] == pytest.approx(specular["level"], abs=0.25)
    assert ping(**{"capsule_reflection": 0.5} | SURFACE)["level"] == pytest.approx(alone["level"] - 6.0206, abs=1e-4)
    assert not ping(**{"capsule_reflection": 0.0} | SURFACE)["valid"]


def test_an_echo_before_the_mesh_is_heard_as_without_it():
    near = {"sphere_center": [0.3, 0.0, 0.0], "sphere_radius": 0.05}
    assert ping(**SURFACE, **near) == ping(**near)


def test_a_mesh_before_a_wall_hides_it_not_and_is_heard_first():
    alone, both = ping(**SURFACE), ping(**SURFACE, **WALL)
    assert both["echo_width"] == alone["echo_width"]
    quiet = {"threshold": alone["level"] + 1.0}
    assert ping(**SURFACE | quiet, **WALL)["time_of_flight"] == pytest.approx(ping(**WALL)["time_of_flight"], rel=1e-14)


def test_a_mesh_behind_a_solid_wall_is_silent():
    near = WALL | {"plane_point": [0.3, 0.0, 0.0]}
    away = {"plane_normal": [-1.0, 0.0, 1.5], "threshold": -36.0}  # its own echo goes elsewhere
    assert not ping(**near | away)["valid"]
    assert not ping(**SURFACE | near | away)["valid"]


def test_mesh_and_ball_add_up_with_phase():
    """Mesh and sphere a quarter of a wavelength apart, and half of one, as the sum of their spectra says."""
    device = default_device()
    arm = kirchhoff(device, *capsule_surface(START, END, FOREARM))
    alone = ping(**SURFACE)
    levels = []
    for behind in np.array([0.0, 0.25, 0.5, 0.75]) * WAVELENGTH:
        way = 0.5 * alone["speed_of_sound"] * alone["time_of_flight"]
        center, radius = np.array([way + behind + 0.06, 0.0, 0.0]), 0.06
        ball = {"sphere_center": center, "sphere_radius": radius}
        spectrum = arm + rigid_sphere(device, center, radius)
        loudest = device.level(spectrum)
        levels.append(loudest)
        # a phase off by 1 / (2 k r) = .011 of a geometrical echo and by .02 of .03 mm in range, where the two cancel
        margin = 20 * np.log10(1 + 0.03 * 10 ** ((alone["level"] - loudest) / 20))
        assert ping(**SURFACE, **ball, threshold=loudest - margin)["valid"]
        assert not ping(**SURFACE, **ball, threshold=loudest + margin)["valid"]
    assert max(levels) - min(levels) > 6.0  # else phase is not shown


def test_a_ground_mirrors_the_mesh():
    """Both ears in one place: the way by the ground and its reverse are alike, 6 dB more than one of them."""
    center, radius = np.array([1.5, 0.0, 0.1]), 0.06
    floor = {"plane_point": [0, 0, -1.5], "plane_normal": [0, 0, 1.0], "multipath": True}
    common = floor | BLIND | PITCHED | {"baseline": 0.0, "threshold": -72.0}
    ball = ping(**common, sphere_center=center, sphere_radius=radius)
    seen = ping(**common, fidelity="surface", **capsule_mesh(center, center, radius, FINE * WAVELENGTH).inputs())
    assert seen["time_of_flight"] == pytest.approx(ball["time_of_flight"], abs=2 * 0.35e-3 / 343)
    # the ball's is that of one way
    assert seen["level"] == pytest.approx(ball["level"] + 6.02, abs=0.5)  # k r = 44 and 55 degrees between the ways


def test_a_deep_mesh_is_heard_part_by_part():
    """Plates 3 m apart are farther than the bins reach at once."""
    plates = [plate_mesh(np.array([x, 0.0, 0.0]), facing(np.array([x, 0, 0]), 0.1), 0.05) for x in (0.3, 3.3)]
    both = joined(*plates)
    for plate in plates:
        alone, level = heard(plate, threshold=-60.0)
        seen = heard(both, threshold=level - 3.0)[0]
        expected = heard(plate, threshold=level - 3.0)[0]
        if plate is plates[1]:
            seen = heard(both, threshold=level - 3.0, minimum_range=2.0)[0]
            expected = heard(plate, threshold=level - 3.0, minimum_range=2.0)[0]
        assert np.isfinite(alone)
        # to the rounding of some thousand bins
        assert seen == pytest.approx(expected, rel=1e-9)


def test_in_the_blind_zone_a_mesh_is_heard_when_the_comparator_opens():
    plate = plate_mesh(np.array([0.1, 0.0, 0.0]), facing(np.array([0.1, 0, 0]), 0.1), 0.05)
    open_early = heard(plate)[0]
    seen = ping(**plate.inputs(), fidelity="surface", minimum_range=0.12)
    edge = 2 * np.hypot(0.12, 0.013) / seen["speed_of_sound"]
    assert open_early < edge
    assert seen["echo_width"] == pytest.approx(edge, rel=1e-14)
    assert seen["distance"] == pytest.approx(0.1, abs=1.5e-3)  # from its peak, in bins of .73 mm


def test_unused_rows_and_a_mesh_that_faces_away_are_nothing():
    more = dict(ARM.inputs())
    count = len(ARM.vertices) + 500
    for name in ("surface_vertices", "surface_normals"):
        more[name] = np.pad(more[name], ((0, 0), (0, 500)))
    more["surface_normals"][0, -500:] = 1.0
    rows = np.zeros((2 * count, 3), np.int32)
    rows[250 : 250 + len(ARM.triangles)] = ARM.triangles
    more |= {"surface_vertex_count": count, "surface_triangles": rows.reshape(2, count, 3)}
    assert ping(**more, fidelity="surface") == ping(**SURFACE)
    inside_out = Mesh(ARM.vertices, -ARM.normals, ARM.triangles[:, ::-1])
    near = plate_mesh(np.array([0.5, 0.0, 0.0]), facing(np.array([0.5, 0, 0]), 0.1), 0.05)
    away = Mesh(near.vertices, -near.normals, near.triangles[:, ::-1])
    assert np.isfinite(heard(near)[0])
    assert not np.isfinite(heard(away)[0])
    assert heard(inside_out)[0] > heard(ARM)[0]  # its far side, seen from within


# Why long edges are cut


def rebuilt(folder: Path, file: str, old: str, new: str, optimization: str = "-O0") -> Path:
    """An FMU of the sensor with one text of a source file replaced."""
    shutil.unpack_archive(fmu("UltrasonicSensor"), folder / "all", "zip")
    source = folder / "all" / "sources" / file
    text = source.read_text()
    assert text.count(old) == 1
    source.write_text(text.replace(old, new))
    compile_sources("UltrasonicSensor", "3.0", folder / "all", optimization)
    path = folder / "UltrasonicSensor.fmu"
    files = {p.relative_to(folder / "all").as_posix(): p for p in (folder / "all").rglob("*") if p.is_file()}
    write_fmu(path, {name: p.read_bytes() for name, p in files.items()})
    return path


def heard_by(unit: Path | str, mesh: Mesh) -> list:
    """What it puts out after its first ping at a mesh."""
    return outputs_of(unit, mesh.inputs() | {"fidelity": "surface"})


def outputs_of(unit: Path | str, values: dict) -> list:
    """The same at anything."""
    with Slave(unit) as sensor:
        for name, value in (values | {"resolution": 0.0}).items():
            sensor.set(name, value)
        sensor.initialize(start=0.0)
        sensor.step(0.0, 0.0599)
        return [sensor.get(name) for name in ("valid", "echo_width", "time_of_flight", "level")]


@pytest.fixture(scope="module")
def uncut(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sensor with its limit on edges lifted."""
    folder = tmp_path_factory.mktemp("uncut")
    return rebuilt(folder, "surface.c", "#define LONGEST_PIECE 0.4 ", "#define LONGEST_PIECE 100.0 ")


def test_without_cuts_a_coarse_mesh_gives_false_echoes(uncut):
    """Forearms in any attitude, edges of 2 wavelengths: most that nobody hears are then heard."""
    rng, silent, false = np.random.default_rng(11), 0, 0
    for _ in range(40):
        start, end = forearm(rng)[1]
        mesh = capsule_mesh(start, end, FOREARM, 2.0 * WAVELENGTH)
        if not heard_by("UltrasonicSensor", mesh)[0]:
            silent += 1
            false += heard_by(uncut, mesh)[0]
    assert silent > 10
    assert false > silent / 2


def test_instruction_sets_give_the_same_bits(tmp_path):
    """All that this processor has: the FMU itself takes the widest."""
    meshes = (ARM, capsule_mesh(START, END, FOREARM, 1.5 * WAVELENGTH))
    expected = [heard_by("UltrasonicSensor", mesh) for mesh in meshes]
    for level, name in enumerate(levels()[:-1]):
        narrow = rebuilt(
            tmp_path / name, "surface.c", "find_onsets[pass->instruction_set]", f"find_onsets[{level}]", "-O3"
        )
        assert [heard_by(narrow, mesh) for mesh in meshes] == expected, name


@pytest.mark.parametrize(("file", "table"), [("box.c", "hear_ends"), ("shading.c", "find_tails")])
def test_instruction_sets_give_a_box_and_shadows_the_same_bits(tmp_path, file, table):
    rng, boxes = np.random.default_rng(5), []
    for _ in range(40):
        place, turn, motion = rng.uniform([0.3, -0.2, -0.2], [1.0, 0.2, 0.2]), rng.normal(size=4), rng.normal(size=3)
        box = {"box_center": place, "box_size": rng.uniform(0.05, 0.3, 3)}
        box |= {"box_orientation": turn / np.linalg.norm(turn), "sphere_center": 0.4 * place, "sphere_radius": 0.02}
        boxes.append(box | {"threshold": -80.0, "velocity": motion})
    expected = [outputs_of("UltrasonicSensor", box) for box in boxes]
    assert sum(seen[0] for seen in expected) > 20
    for level, name in enumerate(levels()[:-1]):
        narrow = rebuilt(tmp_path / name, file, f"{table}[widest_instruction_set()]", f"{table}[{level}]", "-O3")
        assert [outputs_of(narrow, box) for box in boxes] == expected, name


# What is refused


def test_surface_needs_a_mesh():
    for version in ("2.0", "3.0"):
        with Slave("UltrasonicSensor", version=version) as sensor:
            sensor.set("fidelity", "surface")
            with pytest.raises(UnitError, match=r"fidelity = surface needs a mesh, but surface_tri.* has no"):
                sensor.initialize(start=0.0)


def test_an_edge_too_long_to_cut_is_named():
    plate = plate_mesh(np.array([1.0, 0.0, 0.0]), facing(np.array([1.0, 0, 0]), 1.2), 2.0)
    message = r"surface_triangles has an edge 1\.\d+ m long, of triangle \d+; allowed range: up to 1 m"
    with pytest.raises(UnitError, match=message):
        ping(**plate.inputs(), fidelity="surface")
    assert ping(**plate.inputs())["valid"] is False  # `specular` does not look at it


def test_a_normal_that_is_no_unit_vector_is_named():
    wrong = ARM.inputs()
    wrong["surface_normals"] = wrong["surface_normals"].copy()
    wrong["surface_normals"][:, 7] *= 2.0
    with pytest.raises(UnitError, match=r"surface_normals has a normal of length 2, of vertex 7; allowed range"):
        ping(**wrong, fidelity="surface")


# Automatic


def test_automatic_is_specular_without_a_mesh():
    for values in (CAPSULE, WALL, CAPSULE | WALL, {}):
        assert ping(**values, fidelity="automatic") == ping(**values)


def test_automatic_takes_the_mesh_where_no_capsule_stands_for_it():
    assert ping(**ARM.inputs(), fidelity="automatic") == ping(**SURFACE)


@pytest.mark.parametrize(("gap", "surface"), [(0.019, True), (0.021, False)])
def test_automatic_takes_the_mesh_where_two_echoes_are_close(gap, surface):
    specular = ping(**CAPSULE)
    half = specular["speed_of_sound"] * specular["time_of_flight"] / 2
    aside = np.radians(25.0)  # beside the arm, which does not shade it
    center = (half + gap + 0.05) * np.array([np.cos(aside), 0.0, np.sin(aside)])
    ball = {"sphere_center": center, "sphere_radius": 0.05}
    seen = ping(**ARM.inputs(), **CAPSULE, **ball, fidelity="automatic")
    assert seen == ping(**ARM.inputs(), **CAPSULE, **ball, fidelity="surface" if surface else "specular")


# With ArmSkin


@pytest.mark.parametrize("vertices", [2048, 8192])
def test_the_skin_of_an_arm_is_heard_where_its_capsules_are(vertices):
    """A straight arm across the beam: skin and capsules are one cylinder there."""
    across = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]  # bones along +y
    shoulder = np.array([0.5, -0.45, 0.0])
    with Slave("ArmSkin") as skin:
        skin.set("vertex_count", vertices)
        for bone in ("upper_arm", "forearm"):
            skin.set(f"{bone}_orientation", across)
        elbow = shoulder + np.array([0.0, skin.get("upper_arm_length"), 0.0])
        skin.set("upper_arm_position", shoulder)
        skin.set("forearm_position", elbow)
        skin.initialize(start=0.0)
        mesh = {name: skin.get(name) for name in ("vertices", "normals", "triangles")}
        names = [f"capsule_{n}_{part}" for n in (1, 2) for part in ("start", "end", "radius")]
        capsules = {name: skin.get(name) for name in names}
    inputs = {"surface_vertex_count": vertices} | {f"surface_{name}": values for name, values in mesh.items()}
    seen, specular = ping(**inputs, fidelity="surface"), ping(**capsules)
    assert seen["valid"]
    assert seen["distance"] == pytest.approx(specular["distance"], abs=1.35e-3)
    assert seen["level"] == pytest.approx(specular["level"], abs=0.5)
