"""What the sensor's fidelities are held to, from one run."""

from collections.abc import Iterator, Mapping, Sequence

from ..bench.ultrasonic_sensor import TARGETS
from .sensor_measuring import Accuracy, Cost, Surface, percentile
from .sensor_peers import Rays
from .statements import Statement

RANGE = {("specular", "sphere"): 0.3, ("specular", "forearm"): 1.0}
"""mm: what the 95th percentile of the range error is held to, by fidelity and truth."""
DETECTION = {("specular", "sphere"): 0.995, ("specular", "forearm"): 0.99}
SURFACE_RANGE, SURFACE_LEVEL = 0.35, 0.25
"""mm, dB: 95th percentiles of `surface`."""
LOST = 0.8
"""Detection agreement that rays and cones, which know no beam and no threshold, do not reach on spheres."""
PER_PRIMITIVE, PER_POINT = 150.0, 35.0
"""ns"""
PARTS = {"box": "; nine echoes: mirror point, edges and corners of a face"}
"""What a target is in more than one part."""


def sensor_statements(
    accuracies: Sequence[Accuracy], costs: Sequence[Cost], bare: Mapping[str, float], surface: Surface | None
) -> list[Statement]:
    """All that accuracies, costs, the cost of simple targets and of a mesh say."""
    return [*agreement(accuracies), *of_meshes(accuracies), *failures(accuracies), *speed(costs, bare, surface)]


def agreement(accuracies: Sequence[Accuracy]) -> Iterator[Statement]:
    """Of the closed forms with wave theory."""
    own = {(row.name, row.truth): row for row in accuracies}
    for key, bound in RANGE.items():
        row = own[key]
        note = f"median {1e3 * percentile(row.errors, 50):.2g} mm, {len(row.errors)} of {row.poses} poses heard"
        claim = f"{key[0]}, {key[1]}: 95th percentile of the range error, mm"
        yield Statement(claim, 1e3 * percentile(row.errors, 95), bound, True, note)
        yield Statement(f"{key[0]}, {key[1]}: detection agreement", row.detection, DETECTION[key], False)


def of_meshes(accuracies: Sequence[Accuracy]) -> Iterator[Statement]:
    """Of `surface` with the truths of round bodies."""
    for row in accuracies:
        if row.name == "surface" and row.truth in ("sphere", "forearm"):
            claim = f"surface, {row.truth}: 95th percentile of the "
            yield Statement(f"{claim}range error, mm", 1e3 * percentile(row.errors, 95), SURFACE_RANGE, True)
            yield Statement(f"{claim}level's error, dB", percentile(row.level_errors, 95), SURFACE_LEVEL, True)


def failures(accuracies: Sequence[Accuracy]) -> Iterator[Statement]:
    """What is lost without a beam and a threshold."""
    for row in accuracies:
        if row.name in ("ray", "cone") and row.truth == "sphere":
            note = "known to fail: it has no beam and no threshold"
            yield Statement(f"{row.name}, sphere: detection agreement", row.detection, LOST, True, note)


def speed(costs: Sequence[Cost], bare: Mapping[str, float], surface: Surface | None) -> Iterator[Statement]:
    """Of primitives, of points of a mesh, and of MuJoCo's ray."""
    rays = [cost.seconds for cost in costs if cost.name == Rays.NAME]
    beside = f"; MuJoCo's ray {1e9 * min(rays):.0f} to {1e9 * max(rays):.0f} ns" if rays else ""
    each = 1e9 * (bare["three"] - bare["nothing"]) / 3
    note = f"beside {1e9 * bare['nothing']:.0f} ns of a ping at nothing{beside}"
    claim = "specular, plane, sphere and capsule, clear of each other: ns a primitive"
    yield Statement(claim, each, PER_PRIMITIVE, True, note)
    for target in TARGETS:
        note = f"all of a ping: {1e9 * bare[target]:.0f} ns{PARTS.get(target, '')}"
        lone = 1e9 * (bare[target] - bare["nothing"])
        claim = f"specular, a lone {target} aside: ns a ping beside an empty one"
        yield Statement(claim, lone, PER_PRIMITIVE, True, note)
    if surface:
        point = 1e9 * (surface.seconds - bare["nothing"]) / surface.lit
        note = f"{surface.lit} triangles of {surface.vertices} vertices, {1e6 * surface.seconds:.0f} us a ping"
        yield Statement("surface: ns a lit point (triangle)", point, PER_POINT, True, note)
