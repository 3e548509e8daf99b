"""ArmSkin against closed forms, and against skinning written a second time in NumPy and SciPy.

Where a bound is not given a reason beside it: float32 rounds by 3e-8 m at 0.5 m, and the unit promises
1e-7 m in all; measures are computed in float64, so round-off alone stays below 1e-12.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import c_size_t, c_void_p

import numpy as np
import pytest
from arm_skin_truth import (
    ELBOW,
    FOREARM,
    GENERAL,
    HALF_WIDTH,
    RADIUS,
    SPOKES,
    UPPER_ARM,
    Array,
    about,
    bone_distance,
    rest_mesh,
    rings,
    six_volumes,
    skinned,
    smoothstep,
    wxyz,
)
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ulna import Slave, UnitError

METHODS = ("rigid", "linear_blend", "hinge", "dual_quaternion", "center_of_rotation", "compensated")
FLOAT32_BOUND = 1e-7
ROUND_OFF = 1e-12


@contextmanager
def arm(method: str, version: str = "3.0", **parameters: float) -> Iterator[Slave]:
    """An initialised ArmSkin in its rest pose, its twist in the blend zone."""
    with Slave("ArmSkin", version=version) as skin:
        skin.set("method", method)
        skin.set("twist_share", 0.0)
        for name, value in parameters.items():
            skin.set(name, value)
        skin.initialize(start=0.0)
        yield skin


def pose(skin: Slave, upper: Rotation, shoulder: Array, fore: Rotation, elbow: Array) -> None:
    """Sets the poses of both bones."""
    skin.set("upper_arm_position", shoulder)
    skin.set("upper_arm_orientation", wxyz(upper))
    skin.set("forearm_position", elbow)
    skin.set("forearm_orientation", wxyz(fore))


def bend(skin: Slave, axis: str, degrees: float) -> None:
    """Turns the forearm about the elbow, the upper arm at rest."""
    pose(skin, Rotation.identity(), np.zeros(3), about(axis, degrees), ELBOW)


def closed_triangles(skin: Slave) -> NDArray[np.int32]:
    """The triangles [2 n - 4, 3] of the closed skin, without the unused rows."""
    return skin.get("triangles").reshape(-1, 3)[:-4]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("vertex_count", [512, 2048, 6400])
def test_rest_pose_returns_the_mesh_to_the_bit(method: str, vertex_count: int) -> None:
    expected = (rest_mesh(vertex_count)[0].astype(np.float32) + ELBOW.astype(np.float32)).T
    with arm(method, vertex_count=vertex_count) as skin:
        vertices = skin.get("vertices")
    assert vertices.shape == (3, vertex_count) and vertices.dtype == np.float32
    # The same mesh as written here, but for one rounding of sin and cos in another library.
    assert np.abs(vertices - expected).max() <= np.spacing(np.float32(UPPER_ARM + FOREARM))
    with arm("rigid", vertex_count=vertex_count) as skin:
        assert vertices.tobytes() == skin.get("vertices").tobytes()
        skin.set("upper_arm_orientation", [-1, 0, 0, 0])
        assert np.array_equal(vertices, skin.get("vertices"))


def test_skin_is_closed_oriented_and_a_sphere() -> None:
    with arm("linear_blend") as skin:
        triangles, rows = closed_triangles(skin), skin.get("triangles")
    assert rows.shape == (2, 2048, 3) and not rows.reshape(-1, 3)[-4:].any()
    edges = {(a, b) for t in triangles.tolist() for a, b in zip(t, t[1:] + t[:1], strict=True)}
    assert len(edges) == 3 * len(triangles), "an edge is used twice in one direction"
    assert all((b, a) in edges for a, b in edges), "an edge has a triangle on one side only"
    assert len(set(triangles.ravel().tolist())) == 2048
    assert 2048 - len(edges) // 2 + len(triangles) == 2


@pytest.mark.parametrize("vertex_count", [512, 2048])
def test_volume_at_rest_is_that_of_the_frustums(vertex_count: int) -> None:
    x, r, _ = rings(vertex_count)
    polygon = SPOKES / 2 * np.sin(2 * np.pi / SPOKES)
    frustums = polygon / 3 * np.sum(np.diff(x) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2))
    with arm("linear_blend", vertex_count=vertex_count) as skin:
        points = skin.get("vertices").T.astype(float)
        volume = six_volumes(points, closed_triangles(skin)).sum() / 6
    # Vertices are off by 4e-8 m at most, all over a surface of 2 pi r L: 1e-6 of the volume in the worst case.
    assert volume == pytest.approx(frustums, rel=2e-6)
    # Positive: the triangles face outward. The polygons of 32 corners lack 0.65 % of the capsule, its ends the rest.
    capsule = np.pi * RADIUS**2 * (UPPER_ARM + FOREARM - 2 * RADIUS) + 4 / 3 * np.pi * RADIUS**3
    assert 0.97 * capsule < volume < capsule


def test_weights_are_smoothstep_and_a_jump_for_rigid() -> None:
    x = rest_mesh()[0][:, 0]
    with arm("dual_quaternion") as skin:
        assert np.abs(skin.get("weights") - smoothstep(x)).max() < 6e-8  # one rounding to float32
    with arm("rigid") as skin:
        assert np.array_equal(skin.get("weights"), (x >= -ROUND_OFF).astype(np.float32))


@pytest.mark.parametrize("method", METHODS)
def test_vertices_are_those_of_the_textbook(method: str) -> None:
    y, random = rest_mesh()[0], np.random.default_rng(1)
    poses = [
        GENERAL | {"fore": GENERAL["upper"] * turn} for turn in (about("y", 90), about("z", -150), about("x", 170))
    ]
    poses += [GENERAL | {"upper": Rotation.random(rng=random), "fore": Rotation.random(rng=random)} for _ in range(40)]
    with arm(method) as skin:
        for pieces in poses:
            pose(skin, **pieces)
            assert np.abs(skin.get("vertices").T - skinned(method, y, **pieces)).max() < FLOAT32_BOUND


@pytest.mark.parametrize("method", METHODS)
def test_common_motion_of_both_bones_carries_the_skin_rigidly(method: str) -> None:
    turn, shoulder = GENERAL["upper"], GENERAL["shoulder"]
    y, normals = rest_mesh()
    with arm(method) as skin:
        pose(skin, turn, shoulder, turn, turn.apply(ELBOW) + shoulder)
        assert np.abs(skin.get("vertices").T - turn.apply(y + ELBOW) - shoulder).max() < FLOAT32_BOUND
        assert np.abs(skin.get("normals").T - turn.apply(normals)).max() < 5e-7  # some roundings of float32 at 1
        assert skin.get("blend_volume_ratio") == pytest.approx(1, abs=ROUND_OFF)
        assert skin.get("minimum_section_ratio") == pytest.approx(1, abs=ROUND_OFF)
        assert abs(skin.get("elbow_gap")) < ROUND_OFF
        assert skin.get("fold_fraction") == 0


@pytest.mark.parametrize("method", METHODS[1:])
@pytest.mark.parametrize("turn", [about("y", 75), about("x", 120), Rotation.from_rotvec([0.6, 1.1, -0.2])])
def test_normals_are_those_of_the_deformed_surface(method: str, turn: Rotation) -> None:
    """Central differences of the textbook deformation along two tangents of the rest surface."""
    y, normals = rest_mesh()
    pieces = GENERAL | {"fore": GENERAL["upper"] * turn}
    helper = np.where(np.abs(normals[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 0.6, 0.8]])
    first = np.cross(normals, helper)
    reach = 1e-7
    slopes = [
        (skinned(method, y + reach * t, **pieces) - skinned(method, y - reach * t, **pieces)) / (2 * reach)
        for t in (first, np.cross(normals, first))
    ]
    expected = np.cross(*slopes)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    with arm(method) as skin:
        pose(skin, **pieces)
        # Differences: the weight's curvature jumps by 6 / (2 h)^2 at the zone's ends, times the reach: 1e-5;
        # elsewhere float32, and what the surface's compression (down to 0.2) multiplies.
        assert np.abs(skin.get("normals").T - expected).max() < 1e-5


def test_normals_of_rigid_turn_with_their_bone() -> None:
    y, normals = rest_mesh()
    expected = np.where(y[:, :1] >= -ROUND_OFF, GENERAL["fore"].apply(normals), GENERAL["upper"].apply(normals))
    with arm("rigid") as skin:
        pose(skin, **GENERAL)
        assert np.abs(skin.get("normals").T - expected).max() < 5e-7  # some roundings of float32 at 1


def test_normals_stay_finite_where_the_skin_collapses() -> None:
    with arm("linear_blend") as skin:
        skin.set("forearm_orientation", [0, 1, 0, 0])  # half a turn without rounding
        normals = skin.get("normals")
    assert np.isfinite(normals).all()
    assert (np.linalg.norm(normals, axis=0) == 0).sum() == SPOKES


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("degrees", [30, 90, 150])
@pytest.mark.parametrize("vertex_count", [2048, 8192, 32768])
def test_rigid_tears_by_twice_the_radius_times_the_sine_of_half_the_angle(
    axis: str, degrees: float, vertex_count: int
) -> None:
    gap = 2 * RADIUS * np.sin(np.radians(degrees) / 2)
    edge = HALF_WIDTH / (vertex_count // SPOKES // 4)
    with arm("rigid", vertex_count=vertex_count) as skin:
        bend(skin, axis, degrees)
        # Triangle inequality: an edge of length e whose ends part by g grows by g - e to g; e goes with 1 / n.
        assert gap - edge < skin.get("elbow_gap") < gap


CLOSED_VOLUME_LOSS = {"y": 9 / 70, "z": 9 / 70, "x": 9 / 35}


@pytest.mark.parametrize("axis", CLOSED_VOLUME_LOSS)
@pytest.mark.parametrize("degrees", [60, 90, 120, 150])
def test_linear_blend_loses_the_volume_of_the_closed_form(axis: str, degrees: float) -> None:
    loss = CLOSED_VOLUME_LOSS[axis] * (1 - np.cos(np.radians(degrees)))
    errors = []
    for vertex_count in (2048, 8192):
        with arm("linear_blend", vertex_count=vertex_count) as skin:
            bend(skin, axis, degrees)
            errors.append(abs(1 - skin.get("blend_volume_ratio") - loss))
    # Straight lines between n rings in the zone: second order, at most 1.5 / n^2 up to 150 degrees.
    assert errors[0] < 1.5 / (2048 // SPOKES // 2) ** 2
    assert errors[1] < errors[0] / 12


@pytest.mark.parametrize("degrees", [30, 90, 150, 175])
def test_linear_blend_shrinks_its_smallest_section_as_the_closed_form(degrees: float) -> None:
    shrink = np.cos(np.radians(degrees) / 2)
    with arm("linear_blend") as skin:
        bend(skin, "z", degrees)
        assert skin.get("minimum_section_ratio") == pytest.approx(shrink, abs=ROUND_OFF)
        bend(skin, "x", degrees)
        assert skin.get("minimum_section_ratio") == pytest.approx(shrink**2, abs=ROUND_OFF)
        x, y, z = skin.get("vertices")[:, skin.get("weights") == 0.5]
    assert len(x) == SPOKES
    assert np.hypot(y, z) == pytest.approx(RADIUS * shrink, abs=FLOAT32_BOUND)


def test_linear_blend_collapses_to_a_candy_wrapper_at_half_a_turn() -> None:
    with arm("linear_blend") as skin:
        bend(skin, "x", 180)
        assert skin.get("minimum_section_ratio") < ROUND_OFF
        _, y, z = skin.get("vertices")[:, skin.get("weights") == 0.5]
    assert np.hypot(y, z).max() < FLOAT32_BOUND


@pytest.mark.parametrize(("degrees", "bulge"), [(90, 1.146), (150, 1.192)])
def test_dual_quaternions_bulge_and_keep_volume_in_flexion(degrees: float, bulge: float) -> None:
    with arm("dual_quaternion", vertex_count=16384) as skin:
        bend(skin, "y", degrees)
        points = skin.get("vertices").T.astype(float)
        hand = ELBOW + about("y", degrees).apply([FOREARM, 0, 0])
        # Half of the last digit of the published number, and the same for the rings' distance.
        assert bone_distance(points, hand).max() / RADIUS == pytest.approx(bulge, abs=1e-3)
        assert abs(skin.get("blend_volume_ratio") - 1) < 1e-3
        assert skin.get("minimum_section_ratio") == pytest.approx(1, abs=ROUND_OFF)


def test_dual_quaternions_keep_radius_and_volume_in_twist() -> None:
    with arm("dual_quaternion", vertex_count=16384) as skin:
        bend(skin, "x", 175)
        _, y, z = skin.get("vertices")
        tube = np.abs(rest_mesh(16384)[0][:, 0]) <= HALF_WIDTH
        assert np.hypot(y, z)[tube] == pytest.approx(RADIUS, abs=FLOAT32_BOUND)
        assert abs(skin.get("blend_volume_ratio") - 1) < 1e-3


ONSETS = [
    ("linear_blend", 2 * np.degrees(np.arctan(2 * HALF_WIDTH / (3 * RADIUS)))),
    ("dual_quaternion", 4 * np.degrees(np.arctan(HALF_WIDTH / (3 * RADIUS)))),
]


@pytest.mark.parametrize(("method", "onset"), ONSETS)
@pytest.mark.parametrize("axis", ["y", "z"])
def test_inner_elbow_folds_at_the_angle_of_the_closed_form(method: str, onset: float, axis: str) -> None:
    with arm(method) as skin:
        for sign in (-1, 1):
            bend(skin, axis, sign * (onset - 3))
            assert skin.get("fold_fraction") == 0
            bend(skin, axis, sign * (onset + 3))
            assert skin.get("fold_fraction") > 0


@pytest.mark.parametrize("method", METHODS)
def test_gap_and_folds_are_those_counted_on_the_mesh(method: str) -> None:
    """Recounted on vertices of the textbook, over all triangles and not the zone's alone."""
    y = rest_mesh()[0]
    turn = about("y", 140) * about("x", 25)
    pieces = GENERAL | {"fore": GENERAL["upper"] * turn}
    v = skinned(method, y, **pieces)
    with arm(method) as skin:
        pose(skin, **pieces)
        triangles = closed_triangles(skin)
        fold_fraction, elbow_gap = skin.get("fold_fraction"), skin.get("elbow_gap")
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = np.round(y[edges][:, :, 0], 9)
    crossing = edges[(ends.min(axis=1) <= 0) & (ends.max(axis=1) >= 0) & (ends.min(axis=1) < ends.max(axis=1))]
    growth = [np.linalg.norm(p[crossing[:, 1]] - p[crossing[:, 0]], axis=1) for p in (v, y)]
    assert elbow_gap == pytest.approx(np.max(growth[0] - growth[1]), abs=ROUND_OFF)

    corners = y[triangles]
    span = [corners[:, :, 0].min(axis=1), corners[:, :, 0].max(axis=1)]
    near_zone = (span[0] > -HALF_WIDTH - 1e-9) & (span[1] < HALF_WIDTH + 1e-9)
    weight = [(x >= -ROUND_OFF).astype(float) if method == "rigid" else smoothstep(x) for x in span]
    p, q = np.array([1.0, 0, 0, 0]), wxyz(turn)
    mean = (weight[0] + weight[1])[:, None] / 2
    blended = (1 - mean) * p + mean * (-q if q[0] < 0 else q)
    rest_normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    carried = (GENERAL["upper"] * Rotation.from_quat(np.roll(blended, -1, axis=1))).apply(rest_normal)
    deformed = np.cross(v[triangles[:, 1]] - v[triangles[:, 0]], v[triangles[:, 2]] - v[triangles[:, 0]])
    inverted = np.einsum("ij,ij->i", deformed, carried) < 0
    assert inverted.sum() > 0 and not inverted[~near_zone].any()
    assert fold_fraction == pytest.approx(inverted.mean(), abs=ROUND_OFF)


def test_shorter_way_round_jumps_by_the_diameter_at_half_a_turn() -> None:
    """Known limit: the sign of the relative quaternion is chosen afresh for each pose."""
    with arm("dual_quaternion") as skin:
        middle = skin.get("weights") == 0.5
        places = []
        for degrees in (179.99, 180.01):
            bend(skin, "x", degrees)
            places.append(skin.get("vertices")[:, middle].astype(float))
        bend(skin, "x", 360)
        assert np.isfinite(skin.get("vertices")).all()
    # The two sides differ by 0.01 degrees of turn at r, 7e-6 m, beside the jump.
    assert np.linalg.norm(places[1] - places[0], axis=0) == pytest.approx(2 * RADIUS, abs=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_derivatives_of_the_measures_are_their_differences(method: str) -> None:
    inputs = ("upper_arm_position", "upper_arm_orientation", "forearm_position", "forearm_orientation")
    values = (GENERAL["shoulder"], wxyz(GENERAL["upper"]), GENERAL["elbow"], wxyz(GENERAL["fore"]))
    directions = np.split(np.random.default_rng(2).normal(size=14), [3, 7, 10])
    measures = ("blend_volume_ratio", "minimum_section_ratio", "elbow_gap")
    reach = 1e-6

    def measured(skin: Slave, distance: float) -> Array:
        for name, value, direction in zip(inputs, values, directions, strict=True):
            skin.set(name, value + distance * direction)
        return np.array([skin.get(name) for name in measures])

    with arm(method) as skin:
        difference = (measured(skin, reach) - measured(skin, -reach)) / (2 * reach)
        measured(skin, 0.0)
        references = [[skin.variable(name).references[0] for name in names] for names in (measures, inputs)]
        unknowns, knowns = (np.array(r, dtype=np.uint32) for r in references)
        seed, sensitivity = np.concatenate(directions), np.empty(3)
        arrays = [(a.ctypes.data_as(c_void_p), c_size_t(a.size)) for a in (unknowns, knowns, seed, sensitivity)]
        call = skin.function("fmi3GetDirectionalDerivative")
        assert call(c_void_p(skin.component), *(argument for pair in arrays for argument in pair)) == 0
    # Differences: third derivatives of some 10 / m2 times 1e-12, and round-off of 1e-16 / 1e-6.
    assert sensitivity == pytest.approx(difference, abs=1e-8)


def test_opposite_quaternions_give_the_same_skin() -> None:
    with arm("dual_quaternion") as skin:
        pose(skin, **GENERAL)
        vertices, volume = skin.get("vertices"), skin.get("blend_volume_ratio")
        skin.set("forearm_orientation", -wxyz(GENERAL["fore"]))
        assert np.array_equal(skin.get("vertices"), vertices)
        assert skin.get("blend_volume_ratio") == volume


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_capsules_cover_the_arm(version: str) -> None:
    with arm("rigid", version=version) as skin:
        pose(skin, **GENERAL)
        ends = [skin.get(f"capsule_{i}_{end}") for i in (1, 2) for end in ("start", "end")]
        assert skin.get("capsule_1_radius") == skin.get("capsule_2_radius") == RADIUS
    upper, fore = GENERAL["upper"], GENERAL["fore"]
    expected = [
        upper.apply([RADIUS, 0, 0]) + GENERAL["shoulder"],
        upper.apply(ELBOW) + GENERAL["shoulder"],
        GENERAL["elbow"],
        fore.apply([FOREARM - RADIUS, 0, 0]) + GENERAL["elbow"],
    ]
    assert np.abs(np.array(ends) - expected).max() < ROUND_OFF
    rest = rest_mesh()[0]
    beyond = rest[:, 0] - np.clip(rest[:, 0], RADIUS - UPPER_ARM, FOREARM - RADIUS)
    assert np.sqrt(beyond**2 + rest[:, 1] ** 2 + rest[:, 2] ** 2) == pytest.approx(RADIUS, abs=ROUND_OFF)


def test_both_versions_of_the_interface_measure_alike() -> None:
    measured = []
    for version in ("2.0", "3.0"):
        with arm("linear_blend", version=version) as skin:
            pose(skin, **GENERAL)
            names = ("blend_volume_ratio", "minimum_section_ratio", "elbow_gap", "fold_fraction")
            measured.append([skin.get(name) for name in names])
    assert measured[0] == measured[1]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"vertex_count": 1000}, "vertex_count = 1000 .*992 and 1024"),
        ({"vertex_count": 480}, "vertex_count"),
        ({"radius": 0.30}, "radius = 0.3 m .*allowed range"),
        ({"blend_half_width": 0.26}, "blend_half_width = 0.26 m .*0.26 m"),
        ({"forearm_length": 0.09}, "blend_half_width = 0.06 m .*0.05 m"),
        ({"upper_arm_length": -1.0}, "upper_arm_length"),
    ],
)
def test_impossible_arms_are_refused_with_the_allowed_range(parameters: dict[str, float], message: str) -> None:
    with pytest.raises(UnitError, match=message), arm("linear_blend", **parameters):
        pass
