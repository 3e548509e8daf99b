"""ArmSkin: what a vertex costs with each method, how exact it is, and what the method does to the arm."""

from collections.abc import Callable

import numpy as np

from ..slave import Slave
from .measuring import choices, side_by_side, started
from .skinning import (
    ELBOW,
    FOREARM,
    RADIUS,
    Pose,
    about,
    bone_distance,
    normals,
    product,
    rest_mesh,
    skinned,
    turned,
)
from .tables import Table

VERTICES, MEASURED_VERTICES = 20_000, 2048
READS = 10
MEASURES = ("blend_volume_ratio", "minimum_section_ratio", "elbow_gap", "fold_fraction")
UPPER, SHOULDER = about([0.3, -0.5, 0.8], 57.0), np.array([0.05, -0.10, 0.02])
SKEW = Pose(
    UPPER,
    SHOULDER,
    product(UPPER, about([0.6, 1.1, -0.2], 72.0)),
    turned(UPPER, ELBOW) + SHOULDER + [0.004, 0.0, -0.003],
)
BENDS = {
    "flexion 90": about([0, 1, 0], 90.0),
    "flexion 150": about([0, 1, 0], 150.0),
    "twist 180": about([1, 0, 0], 180.0),
}


def posed(method: str, pose: Pose, vertex_count: int) -> Slave:
    """A skin in this pose."""
    return started(
        "ArmSkin",
        vertex_count=vertex_count,
        method=method,
        twist_share=0.0,
        upper_arm_position=pose.shoulder,
        upper_arm_orientation=pose.upper,
        forearm_position=pose.elbow,
        forearm_orientation=pose.fore,
    )


def repeated_read(skin: Slave, stream: str) -> Callable[[], None]:
    """A call that reads a stream READS times into the same memory."""
    port = skin.getter([stream])

    def read() -> None:
        for _ in range(READS):
            port()

    return read


def repeated_measures(skin: Slave) -> Callable[[], None]:
    """A call that sets the forearm anew and reads all measures, READS times."""
    setter, getter = skin.setter(["forearm_orientation"]), skin.getter(MEASURES)
    setter.values[:] = skin.get("forearm_orientation")

    def measure() -> None:
        for _ in range(READS):
            setter()
            getter()

    return measure


def speed_and_accuracy(methods: list[str], rounds: int) -> list[Table]:
    """Reads of positions, normals and measures in a pose without symmetry, and how far they are from the textbook."""
    skins = {method: posed(method, SKEW, VERTICES) for method in methods}
    small = {method: posed(method, SKEW, MEASURED_VERTICES) for method in methods}
    vertices = side_by_side({m: repeated_read(skin, "vertices") for m, skin in skins.items()}, rounds)
    normal = side_by_side({m: repeated_read(skin, "normals") for m, skin in skins.items()}, rounds)
    measures = side_by_side({m: repeated_measures(skin) for m, skin in small.items()}, rounds)
    points, tangents = rest_mesh(VERTICES)
    each = 1e9 / READS / VERTICES
    speed, accuracy = [], []
    for method, skin in skins.items():
        (position_time, position_ratio), (normal_time, normal_ratio) = vertices[method], normal[method]
        times = position_time * each, position_ratio, normal_time * each, normal_ratio
        speed.append((method, *times, measures[method][0] / READS * 1e6))
        position_off = np.abs(skin.get("vertices").T - skinned(method, points, SKEW)).max()
        normal_off = np.abs(skin.get("normals").T - normals(method, points, tangents, SKEW)).max()
        accuracy.append((method, float(position_off), float(normal_off)))
    return [
        Table(
            "ArmSkin: methods",
            f"Streams of {VERTICES} vertices; all measures of {MEASURED_VERTICES} vertices, a new pose each time.",
            ("method", "ns a position", "ratio", "ns a normal", "normal ratio", "us, all measures"),
            speed,
        ),
        Table(
            "ArmSkin: largest error of a coordinate",
            "In a pose without symmetry; reference: the textbook formulas in float64.",
            ("method", "position, m", "normal"),
            accuracy,
        ),
    ]


def speed(rounds: int) -> list[Table]:
    """Every instruction set and mesh of three sizes, of the smallest alone for a single round; other libraries."""
    from ..charts.skin_speed import SIZES, speeds, tables

    return tables(list(speeds(max(rounds // 10, 1), SIZES if rounds > 1 else SIZES[:1])))


def deformation(methods: list[str]) -> Table:
    """What each method does to the arm in flexion and twist."""
    rows = []
    for bend, turn in BENDS.items():
        pose = Pose(about([1, 0, 0], 0.0), np.zeros(3), turn, ELBOW)
        hand = ELBOW + turned(turn, np.array([FOREARM, 0.0, 0.0]))
        for method in methods:
            with posed(method, pose, MEASURED_VERTICES) as skin:
                farthest = bone_distance(skin.get("vertices").T.astype(float), hand).max()
                volume, section, gap, folded = (skin.get(name) for name in MEASURES)
            rows.append((f"{bend}: {method}", volume, section, 1e3 * gap, 100 * folded, float(farthest / RADIUS)))
    return Table(
        "ArmSkin: what a method does to the arm",
        f"The default arm, {MEASURED_VERTICES} vertices; angles in degrees, r = radius.",
        ("bend: method", "volume", "smallest section", "gap, mm", "folded, %", "bone distance, r"),
        rows,
    )


def bench(rounds: int) -> list[Table]:
    """Time and error of each method, and its deformation of the arm."""
    methods = choices("ArmSkin", "method")
    return [*speed_and_accuracy(methods, rounds), *speed(rounds), deformation(methods)]
