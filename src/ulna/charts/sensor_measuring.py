"""What the chart of the sensor measures: cost of a ping, and its agreement with wave theory, for each fidelity."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from timeit import repeat
from typing import Any

import numpy as np

from ..bench.measuring import choices, repeated_step, side_by_side, started
from ..bench.ultrasonic_sensor import ASIDE, PERIOD, PINGS, REACH, ROLLED, SEVERAL, TARGETS, lit_triangles
from .sensor_peers import Rays, rays
from .sensor_truths import FOREARM_LENGTH, FOREARM_RADIUS, TRUTHS, WALL, Pose, capsule_at, device

SEED = 7
FLIGHT = 0.05  # s, longer than any
RESTING = 0.06  # s, between pings
SAME = 0.03  # m: before a wall, what reads farther off is another echo
LONG_ENOUGH = 4e-4  # s, of a call that is timed: far below the slices of 2 ms that a busy system gives to others


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    poses: int
    """Of each target."""
    timed: int
    """Of those, how many are timed."""
    rounds: int


FULL, QUICK = Effort(400, 8, 15), Effort(40, 2, 5)


@dataclass(frozen=True)
class Accuracy:
    """How a fidelity, or a peer, agrees with wave theory over the poses of a target."""

    name: str
    truth: str
    peer: bool
    poses: int
    detection: float
    """Share of the poses at which both hear or neither does; before a wall, both within SAME."""
    silent: int
    """Poses at which neither hears."""
    errors: list[float]
    """m, |c/2 times (echo width - truth's)|, ascending, of the poses at which both hear."""
    level_errors: list[float]
    """dB, |level - truth's loudest|, ascending, of the same; none of a peer, nor before a wall, which is louder."""


@dataclass(frozen=True)
class Cost:
    """What a ping costs, all of it included."""

    name: str
    truth: str
    peer: bool
    seconds: float


@dataclass(frozen=True)
class Surface:
    """What a ping at a mesh costs."""

    vertices: int
    lit: int
    """Triangles that both ears see, each a point of the integral."""
    seconds: float


def percentile(values: list[float], share: float) -> float:
    """Of errors; not a number where there are none."""
    return float(np.percentile(values, share)) if values else float("nan")


def fidelities() -> list[str]:
    """In the order in which the unit declares them."""
    return choices("UltrasonicSensor", "fidelity")


def takes(fidelity: str, pose: Pose) -> bool:
    """Whether the pose can be put before it: no mesh is endless."""
    return fidelity != "surface" or pose.mesh is not None


def posed(fidelity: str, pose: Pose, **settings: Any) -> Any:
    """A sensor before a pose, initialized; nothing is rounded. `surface` gets a mesh, `automatic` beside a capsule."""
    values = pose.inputs
    if pose.mesh and fidelity == "surface":
        values = pose.mesh().inputs() | pose.behind
    elif pose.mesh and fidelity == "automatic" and "capsule_1_radius" in pose.inputs:
        values = pose.mesh().inputs() | pose.inputs
    return started("UltrasonicSensor", **values, fidelity=fidelity, resolution=0.0, **settings)


def ping(fidelity: str, pose: Pose) -> tuple[float, float]:
    """Echo width in s, infinite without an echo, and level in dB, of the first ping."""
    with posed(fidelity, pose) as sensor:
        sensor.step(0.0, FLIGHT)
        return sensor.get("echo_width") if sensor.get("valid") else np.inf, sensor.get("level")


def drawn(truth: str, count: int) -> list[Pose]:
    """The poses of a truth, the same in each run."""
    rng = np.random.default_rng(SEED)
    return [TRUTHS[truth](rng) for _ in range(count)]


def accuracies(effort: Effort, say: Callable[[str], None] = lambda _: None) -> Iterator[Accuracy]:
    """Every fidelity, and MuJoCo's ray where installed, on every truth."""
    ears = device()
    for truth in TRUTHS:
        poses = drawn(truth, effort.poses)
        say(f"{truth}: wave theory")
        spectra = [pose.spectrum(ears) for pose in poses]
        true = np.array([(ears.heard(spectrum), ears.level(spectrum)) for spectrum in spectra])
        for fidelity in (name for name in fidelities() if takes(name, poses[0])):
            say(f"{truth}: {fidelity}")
            yield agreement(fidelity, truth, np.array([ping(fidelity, pose) for pose in poses]), true, ears.speed)
        widths = [2 * np.hypot(peer.length(), ears.baseline / 2) / ears.speed for peer in map(rays, poses) if peer]
        if widths:
            read = np.array([(width if width <= ears.maximum_time else np.inf, np.nan) for width in widths])
            yield agreement(Rays.NAME, truth, read, true, ears.speed)


def agreement(name: str, truth: str, read: np.ndarray, true: np.ndarray, speed: float) -> Accuracy:
    """Of times [n] in s, infinite without an echo, and levels [n] in dB, as columns of `read` and `true`."""
    hears, there = np.isfinite(read[:, 0]), np.isfinite(true[:, 0])
    off = np.abs(read[hears & there] - true[hears & there]) * [speed / 2, 1.0]
    agreed = np.mean(hears == there) if WALL not in truth else np.sum(off[:, 0] < SAME) / len(read)
    silent = int(np.sum(~hears & ~there))
    errors, levels = (np.sort(column).tolist() for column in off.T)
    peer = name == Rays.NAME
    levels = [] if peer or WALL in truth else levels
    return Accuracy(name, truth, peer, len(read), float(agreed), silent, errors, levels)


def costs(effort: Effort) -> tuple[list[Cost], dict[str, float], Surface | None]:
    """Seconds of a ping, mean over poses of medians of interleaved runs; of simple targets, and of nothing; of a mesh.

    Each call is many pings in one step of the unit, and many of MuJoCo's rays in one call.
    """
    calls: dict[tuple, Callable[[], Any]] = {}
    counts: dict[tuple, int] = {}
    for truth in TRUTHS:
        for number, pose in enumerate(drawn(truth, effort.timed)):
            for fidelity in (name for name in fidelities() if takes(name, pose)):
                key = fidelity, truth, number
                counts[key], calls[key] = many_pings(partial(posed, fidelity, pose, period=RESTING), RESTING)
            peer = rays(pose)
            if peer:
                counts[Rays.NAME, truth, number], calls[Rays.NAME, truth, number] = PINGS, peer.many(PINGS)
    bare = {"nothing": {"maximum_range": 1.0}, "three": ROLLED | SEVERAL}
    bare |= {target: ROLLED | place(REACH, ASIDE) for target, place in TARGETS.items()}
    for name, values in bare.items():
        make = partial(started, "UltrasonicSensor", period=PERIOD, **values)
        counts[name,], calls[name,] = many_pings(make, PERIOD)
    skin = facing_arm() if "surface" in fidelities() else None
    if skin:
        make = partial(posed, "surface", facing_pose(), period=RESTING)
        counts["mesh",], calls["mesh",] = many_pings(make, RESTING)
    found = {key: seconds / counts[key] for key, (seconds, _) in side_by_side(calls, effort.rounds).items()}
    names = [*fidelities(), *({Rays.NAME} & {key[0] for key in found})]
    rows = [
        Cost(name, truth, name == Rays.NAME, float(np.mean([found[name, truth, n] for n in range(effort.timed)])))
        for name in names
        for truth in TRUTHS
        if (name, truth, 0) in found
    ]
    return rows, {name: found[name,] for name in bare}, skin and replace(skin, seconds=found["mesh",])


def facing_pose() -> Pose:
    """A forearm across."""
    half = np.array([0.0, FOREARM_LENGTH / 2, 0.0])
    center = np.array([REACH + FOREARM_RADIUS, 0.0, 0.0])
    return capsule_at(center - half, center + half, FOREARM_RADIUS)


def facing_arm() -> Surface:
    """Its mesh, not timed."""
    mesh = facing_pose().mesh()
    return Surface(len(mesh.vertices), lit_triangles(mesh.vertices[mesh.triangles], device().ears), 0.0)


def many_pings(make: Callable[[], Any], period: float) -> tuple[int, Callable[[], None]]:
    """So many pings that they take LONG_ENOUGH or, by powers of 8, more; and the call that takes them in one step."""
    count, call = 4, repeated_step(make(), 4 * period)
    while count < PINGS and min(repeat(call, number=1, repeat=3)) < LONG_ENOUGH:
        count *= 8
        call = repeated_step(make(), count * period)
    return count, call
