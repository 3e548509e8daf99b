"""Every instruction set gives one and the same skin, of rings and of an imported mesh; float32 against float64."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_arm_skin import FLOAT32_BOUND, METHODS
from test_arm_skin_imported import arm_mesh

from ulna.bench.skinning import ELBOW, Pose, normals, product, rest_mesh, skinned, turned
from ulna.charts.skin_kernel import LEVELS, Kernel, kernel, levels
from ulna.skin_mesh import write_mesh

VERTICES = 2048


def poses(count: int) -> list[Pose]:
    """Any turn of both bones, elbows some millimetres apart, all within 1 m of the origin."""
    random = np.random.default_rng(7)
    found = []
    for _ in range(count):
        upper, fore = (np.roll(q, 1) for q in Rotation.random(2, rng=random).as_quat())
        gap = random.uniform(-0.004, 0.004, 3)
        shoulder = random.uniform(-0.05, 0.05, 3)
        found.append(Pose(upper, shoulder, fore, turned(upper, ELBOW) + shoulder + gap))
    return found


@pytest.fixture(scope="module", params=["rings", "mesh"])
def resources(request, tmp_path_factory) -> Path | None:
    """Of an imported arm, or none."""
    if request.param == "rings":
        return None
    folder = tmp_path_factory.mktemp("resources")
    write_mesh(folder / "mesh.bin", arm_mesh(VERTICES))
    return folder


@pytest.fixture(scope="module", params=METHODS)
def method(request) -> str:
    return request.param


@pytest.mark.parametrize("twist_share", [0.0, 0.7])
def test_instruction_sets_give_the_same_bits(method: str, resources: Path | None, twist_share: float) -> None:
    """No sum is reordered, no product fused, no root or quotient estimated: all that this processor has."""
    for pose in poses(5):
        with kernel(method, pose, VERTICES, resources, twist_share) as skin:
            first = skin.deformed(LEVELS[0])
            assert np.abs(first).max() > 0.5
            for level in levels()[1:]:
                assert skin.deformed(level).tobytes() == first.tobytes(), level


def test_float32_is_within_its_bound_of_float64(method: str, resources: Path | None) -> None:
    points = rest_mesh(VERTICES)[0]
    # the reference has the centres of bands, a mesh those of triangles: test_arm_skin_imported has these exactly
    bound = 5e-6 if resources and method == "center_of_rotation" else FLOAT32_BOUND
    for pose in poses(20):
        expected = skinned(method, points, pose)
        with kernel(method, pose, VERTICES, resources) as skin:
            for level in levels():
                assert off(skin, level, expected) < bound


def off(skin: Kernel, level: str, expected: np.ndarray) -> float:
    return float(np.abs(skin.deformed(level)[0].T - expected).max())


def test_normals_of_an_unbent_arm_are_turned_alone(method: str, resources: Path | None) -> None:
    pose = poses(1)[0]
    normal = np.cross(*rest_mesh(VERTICES)[1])
    straight = Pose(pose.upper, pose.shoulder, pose.upper, turned(pose.upper, ELBOW) + pose.shoulder)
    with kernel(method, straight, VERTICES, resources) as skin:
        for level in levels():
            found = skin.deformed(level)[1].T
            # some roundings of float32 at 1
            assert np.abs(found - turned(pose.upper, normal)).max() < 5e-7


def test_the_driver_times_what_the_unit_computes(tmp_path: Path) -> None:
    pose = poses(1)[0]
    bent = Pose(pose.upper, pose.shoulder, product(pose.upper, np.array([0.8, 0.0, 0.6, 0.0])), pose.elbow)
    with kernel("hinge", bent, VERTICES) as skin:
        expected = normals("hinge", *rest_mesh(VERTICES), bent)
        assert np.abs(skin.deformed(levels()[-1])[1].T - expected).max() < 1e-5
        assert min(skin.seconds(levels()[-1], 1), skin.limit(levels()[-1], 14, 1)) > 0.0
    with pytest.raises(ValueError, match="refuses 33 vertices"), kernel("hinge", bent, 33):
        pass
