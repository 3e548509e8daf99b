"""What a vertex costs, in one run: each instruction set, rings and imported mesh, through FMI, and other libraries."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from ..bench.arm_skin import SKEW, posed
from ..bench.measuring import interleaved
from ..bench.skinning import HALF_WIDTH, rest_mesh, smoothstep
from ..bench.tables import Table
from ..skin_mesh import SkinMesh, write_mesh
from .skin_kernel import Kernel, kernel, levels
from .skin_peers import position_peers

SIZES = (2048, 20_000, 200_000)
METHODS = ("linear_blend", "hinge", "dual_quaternion", "center_of_rotation", "compensated")
LIMITS = {"written alone": 0, "7 numbers read": 7, "14 numbers read": 14}
"""Traffic without arithmetic: six numbers written a vertex, and what is read. 7: position, normal and weight, as any
skin of single vertices must; 14: what ours reads of an imported mesh, in two passes."""
OWN_LIMIT = {"rings": "written alone", "mesh": "14 numbers read"}
LEAST_SECONDS = 2e-3
"""Of one measurement."""


@dataclass(frozen=True)
class Speed:
    """What a vertex costs."""

    vertices: int
    name: str
    """Kind of mesh and method, a limit, "FMI", or a library."""
    level: str
    """Instruction set; of others the machine's own choice."""
    normals: bool
    """Whether they are in it, beside the positions."""
    seconds: float


def speeds(rounds: int, sizes: Sequence[int] = SIZES, say: Callable[[str], None] = lambda _: None) -> Iterator[Speed]:
    """Every mesh size, all of it interleaved; CPU time, one thread. Raises FileNotFoundError without a C compiler."""
    for count in sizes:
        say(f"{count} vertices")
        with ExitStack() as stack:
            runs = _runs(count, stack)
            calls = {key: _per_vertex(run, count) for key, run in runs.items()}
            for (name, level, normals), seconds in interleaved(calls, rounds).items():
                yield Speed(count, name, level, normals, seconds)


def imported_arm(vertex_count: int) -> SkinMesh:
    """The default arm as an imported mesh of four influences a vertex; half of its vertices bend."""
    points, tangents = rest_mesh(vertex_count)
    share = smoothstep(points)[:, 0]
    s = np.clip(0.5 + points[:, 0] / (2 * HALF_WIDTH), 0.0, 1.0)
    with posed("rigid", SKEW, vertex_count) as skin:
        triangles = skin.get("triangles").reshape(-1, 3)[:-4]
        lengths = {
            name: skin.get(name) for name in ("upper_arm_length", "forearm_length", "radius", "blend_half_width")
        }
    return SkinMesh(
        vertices=points,
        normals=np.cross(*tangents),
        gradients=(3 * s * (1 - s) / HALF_WIDTH)[:, None] * [1.0, 0.0, 0.0],
        weights=np.stack([0.75 * (1 - share), 0.25 * share, 0.25 * (1 - share), 0.75 * share], axis=1),
        joints=np.tile([0, 1, 2, 3], (vertex_count, 1)),
        forearm=np.array([False, True, False, True]),
        triangles=triangles,
        **lengths,
    )


Run = Callable[[int], float]
"""Seconds for a count of repetitions."""


def _runs(count: int, stack: ExitStack) -> dict[tuple[str, str, bool], Run]:
    """By name, instruction set, and whether normals are made."""
    folder = Path(stack.enter_context(TemporaryDirectory()))
    write_mesh(folder / "mesh.bin", imported_arm(count))
    resources = {"rings": None, "mesh": folder}
    skins: dict[str, Kernel] = {
        f"{kind}, {method}": stack.enter_context(kernel(method, SKEW, count, resources[kind]))
        for kind in resources
        for method in METHODS
    }
    first = next(iter(skins.values()))
    runs: dict[tuple[str, str, bool], Run] = {}
    for level in levels():
        for name, read in LIMITS.items():
            runs[name, level, True] = lambda n, level=level, read=read: first.limit(level, read, n)
        for name, skin in skins.items():
            for normals in (False, True):
                runs[name, level, normals] = lambda n, s=skin, level=level, on=normals: s.seconds(level, n, on)
    for method in ("linear_blend", "dual_quaternion"):
        ports = [stack.enter_context(posed(method, SKEW, count)).getter([name]) for name in ("vertices", "normals")]
        runs[f"FMI, {method}", levels()[-1], True] = _timed(lambda ports=ports: [port() for port in ports])
    for peer in position_peers(count, SKEW):
        runs[peer.name, "", peer.call()[1] is not None] = _timed(peer.call)
    return runs


def _timed(call: Callable[[], object]) -> Run:
    def run(count: int) -> float:
        start = process_time()
        for _ in range(count):
            call()
        return process_time() - start

    return run


def _per_vertex(run: Run, vertices: int) -> Callable[[], float]:
    """Seconds a vertex, of as many repetitions as LEAST_SECONDS take."""
    count = 1
    while run(count) < LEAST_SECONDS:
        count *= 2
    return lambda: run(count) / count / vertices


def tables(found: Sequence[Speed]) -> list[Table]:
    """Times and ratios."""
    by_key = nanoseconds(found)
    widest, own, theirs = levels()[-1], [], []
    for s in found:
        if s.level == widest and s.normals and not s.name.startswith("FMI"):
            limit = next((OWN_LIMIT[kind] for kind in OWN_LIMIT if s.name.startswith(f"{kind}, ")), s.name)
            row, limits = ([by_key[s.vertices, name, level, True] for level in levels()] for name in (s.name, limit))
            over = [a / b for a, b in zip(row, limits, strict=True)][1:]
            own.append((f"{s.vertices}: {s.name}", *row, *over))
        elif not s.level or s.name.startswith("FMI"):
            method = "dual_quaternion" if "dual" in s.name else "linear_blend"
            ours = by_key[s.vertices, f"rings, {method}", widest, s.normals]
            theirs.append((f"{s.vertices}: {s.name}", 1e9 * s.seconds, 1e9 * s.seconds / ours))
    return [
        Table(
            "ArmSkin: speed",
            "ns a vertex, position and normal, by instruction set; then the same over its own traffic without "
            "arithmetic: six numbers written of rings, 14 read besides of an imported mesh, half of which bends.",
            ("vertices: what", *levels(), *(f"/ {level}" for level in levels()[1:])),
            own,
        ),
        Table(
            "ArmSkin: beside others",
            "Positions alone on both sides, one thread; FMI (read into NumPy's memory) and MuJoCo with normals on both "
            f"sides. Ours: rings, the kernel by itself, {widest}.",
            ("vertices: who", "ns a vertex", "over ours"),
            theirs,
        ),
    ]


def nanoseconds(found: Sequence[Speed]) -> dict[tuple[int, str, str, bool], float]:
    """ns a vertex by vertices, name, instruction set, and whether normals are in it."""
    return {(s.vertices, s.name, s.level, s.normals): 1e9 * s.seconds for s in found}
