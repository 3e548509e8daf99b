"""What the skins are held to, from one run."""

from collections.abc import Iterator, Sequence
from itertools import takewhile
from math import cos, radians

from ..bench.skinning import SPOKES
from .skin_kernel import levels
from .skin_measuring import Shape
from .skin_speed import Speed, nanoseconds
from .statements import Statement

LOST = {"flexion": 9 / 70, "twist": 9 / 35}
"""Of the zone's volume by the linear blend, times 1 - cos theta: closed forms for the smoothstep weights."""
VOLUME, BULGE, STRETCH = 0.05, 1.1, 4.0
"""From which a shape is not sound; nor is one with a fold. No smooth method stretches an edge more than 2.6 times."""
NEARLY_A_LINE = 1e-3
"""Of a section: normals of what is smaller hang on the last digits of the positions."""


def sound_up_to(shapes: Sequence[Shape], name: str, bend: str) -> float:
    """Degrees up to which all measured angles have volume, bulge and stretch within bounds, and no fold."""
    own = sorted((s for s in shapes if (s.name, s.bend) == (name, bend)), key=lambda s: s.angle)
    return max((s.angle for s in takewhile(is_sound, own)), default=0.0)


def is_sound(shape: Shape) -> bool:
    """Whether nothing is lost, bulged, torn or folded."""
    kept = abs(shape.volume_error) < VOLUME and shape.bulge < BULGE
    return kept and shape.stretch < STRETCH and shape.fold_fraction == 0.0


def skin_statements(found: Sequence[Speed], shapes: Sequence[Shape], vertices: int) -> list[Statement]:
    """All that speeds, and shapes of meshes of so many vertices, say."""
    return [*closed_forms(shapes, vertices), *normals(shapes), *ordering(shapes), *speed(found)]


def closed_forms(shapes: Sequence[Shape], vertices: int) -> Iterator[Statement]:
    """Volume and section of the linear blend."""
    bands = vertices // SPOKES // 4 * 2
    own = [s for s in shapes if s.name == "linear_blend"]
    for bend, lost in LOST.items():
        off = max(abs(s.volume_error + lost * (1 - cos(radians(s.angle)))) for s in own if s.bend == bend)
        claim = f"linear_blend, {bend}: volume loss to {'9/70' if bend == 'flexion' else '9/35'} (1 - cos)"
        yield Statement(claim, off, 1.5 / bands**2, True, f"{bands} bands of rings in the zone")
    for bend, power in (("flexion", 1), ("twist", 2)):
        off = max(abs(s.section - cos(radians(s.angle / 2)) ** power) for s in own if s.bend == bend)
        yield Statement(f"linear_blend, {bend}: least section to cos{'²' * (power - 1)}(angle/2)", off, 1e-12, True)


def normals(shapes: Sequence[Shape]) -> Iterator[Statement]:
    """Of our own methods, all of them, and of those who only turn the rest's."""
    own = [s for s in shapes if not s.peer and s.section > NEARLY_A_LINE]
    worst = max(own, key=lambda s: s.normal_error)
    note = f"{worst.name} at {worst.angle:g} degrees of {worst.bend}"
    yield Statement("normals, every method: mean error in the zone, degrees", worst.normal_error, 1e-3, True, note)
    usual = max(s.normal_error for s in shapes if s.peer and s.bend == "flexion" and s.normal_error is not None)
    yield Statement("normals turned, not deformed, as in the peers: the same, degrees", usual, 10.0, False)


def ordering(shapes: Sequence[Shape]) -> Iterator[Statement]:
    """What `compensated` is for, at the largest flexion and at 90 degrees."""
    flexion = {(s.name, s.angle): s for s in shapes if s.bend == "flexion"}
    for angle in (90.0, 150.0):
        ours, hinge = flexion["compensated", angle], flexion["hinge", angle]
        yield Statement(f"compensated, flexion {angle:g}: volume error", abs(ours.volume_error), 0.003, True)
        claim = f"compensated, flexion {angle:g}: bulge over radius, to that of hinge"
        yield Statement(claim, (ours.bulge - 1) / (hinge.bulge - 1), 0.7, True, f"{ours.bulge:.3f}, {hinge.bulge:.3f}")


PEER_BOUNDS = {"UsdSkel, linear blend": 8.0, "UsdSkel, dual quaternion": 15.0}
READ_SIZE = 20_000
"""Vertices of a read through FMI beside the kernel by itself."""


def speed(found: Sequence[Speed]) -> Iterator[Statement]:
    """Of the largest mesh over the traffic of memory, of methods over each other, of a read, and of UsdSkel."""
    times = nanoseconds(found)
    sizes = sorted({s.vertices for s in found})
    most, widest = sizes[-1], levels()[-1]

    def held(claim: str, pair: tuple[float, float], bound: float, most: bool = True) -> Statement:
        note = "{:.3g} and {:.3g} ns".format(*pair)
        return Statement(f"a vertex of {claim}", pair[0] / pair[1], bound, most, note)

    for kind, limit, bounds in (("rings", "7 numbers read", (1.8, 1.2)), ("mesh", "14 numbers read", (2.5, 2.5))):
        for level, bound in zip(levels()[1:], bounds, strict=False):
            pair = times[most, f"{kind}, linear_blend", level, True], times[most, limit, level, True]
            yield held(f"linear_blend, {kind}, {level}, {most}: over a loop of {limit}, 6 written", pair, bound)
    for method, bound, kinds in (("dual_quaternion", 1.6, ("rings", "mesh")), ("hinge", 0.5, ("rings", "mesh"))):
        for kind in kinds:
            pair = tuple(times[most, f"{kind}, {name}", widest, True] for name in (method, "linear_blend"))
            yield held(f"{method}, {kind}, {widest}, {most}: over linear_blend", pair, bound)
    if READ_SIZE in sizes:
        pair = tuple(times[READ_SIZE, f"{who}, linear_blend", widest, True] for who in ("FMI", "rings"))
        yield held(f"linear_blend read through FMI, {READ_SIZE}: over the kernel by itself", pair, 1.5)
    for peer, bound in PEER_BOUNDS.items():
        method = "dual_quaternion" if "dual" in peer else "linear_blend"
        pairs = [
            (times[count, peer, "", False], times[count, f"rings, {method}", widest, False])
            for count in sizes
            if (count, peer, "", False) in times
        ]
        if pairs:
            least = min(pairs, key=lambda pair: pair[0] / pair[1])
            yield held(f"{peer}, positions alone, any size: over {method}", least, bound, most=False)
