"""UltrasonicSensor: what a ping costs at each fidelity, how exact its distance is, and how far it hears."""

from collections.abc import Callable, Hashable, Iterable
from functools import partial

import numpy as np

from .measuring import choices, repeated_step, side_by_side, started
from .tables import Table

PERIOD, PINGS = 0.01, 4000  # s; echoes from REACH come back within the period
MOVING, APPROACH = 1000, 0.05  # pings, m/s: they come half a metre nearer
REACH, RADIUS = 0.5, 0.1  # m, from the sensor to the surface
ASIDE = np.radians(8.0)
ROLLED = {"orientation": [np.cos(np.radians(25.0)), np.sin(np.radians(25.0)), 0.0, 0.0]}
"""About its own axis, so that a target aside is nearer to one ear than to the other."""
DISTANCES = (0.02, 0.1, 1.0)  # m
EXACT = {"resolution": 0.0, "threshold": -150.0, "minimum_range": 0.0}
PING = 0.05  # s, longer than any flight
LONGEST = 3.999  # m, just within the default time-out
SKINS = (2048, 8192, 20_000)  # vertices
SKIN_PINGS, SKIN_PERIOD = 20, 0.06  # s


def direction(angle: float) -> np.ndarray:
    """Off the sensor's axis by `angle` (rad), across its baseline, so that both ears are equally far."""
    return np.array([np.cos(angle), 0.0, np.sin(angle)])


def plane(distance: float, angle: float = 0.0) -> dict:
    """A plane whose perpendicular from the sensor is `distance` long."""
    return {"plane_point": distance * direction(angle), "plane_normal": -direction(angle)}


def sphere(distance: float, angle: float = 0.0, radius: float = RADIUS) -> dict:
    """A sphere whose surface is `distance` away."""
    return {"sphere_center": (distance + radius) * direction(angle), "sphere_radius": radius}


def capsule(distance: float, angle: float = 0.0, radius: float = RADIUS) -> dict:
    """A capsule along the baseline, whose wall is `distance` away."""
    center, half = (distance + radius) * direction(angle), np.array([0.0, 0.5, 0.0])
    return {"capsule_1_start": center - half, "capsule_1_end": center + half, "capsule_1_radius": radius}


def box(distance: float, angle: float = 0.0) -> dict:
    """A cube whose face is turned to the sensor, `distance` away."""
    turn = {"box_orientation": [np.cos(angle / 2), 0.0, -np.sin(angle / 2), 0.0]}
    return turn | {"box_center": (distance + RADIUS) * direction(angle), "box_size": [2 * RADIUS] * 3}


TARGETS = {"plane": plane, "sphere": sphere, "capsule": capsule, "box": box}
SEVERAL = {**plane(REACH, ASIDE), **sphere(REACH - 0.1, -3 * ASIDE, 0.03), **capsule(REACH - 0.2, 5 * ASIDE, 0.03)}
TOGETHER = {**plane(REACH), **sphere(REACH, -4.5 * ASIDE, 0.03)}
CROWDED = {**plane(REACH, ASIDE), **sphere(REACH - 0.1, -ASIDE, 0.03), **capsule(REACH - 0.2, 3 * ASIDE, 0.03)}
BEHIND = {**plane(REACH, ASIDE), **sphere(REACH - 0.1, ASIDE), **capsule(REACH - 0.2, ASIDE)}


def heard(fidelity: str, read: str, values: dict) -> float:
    """An output after the first ping."""
    with started("UltrasonicSensor", fidelity=fidelity, **values) as sensor:
        sensor.step(0.0, PING)
        return sensor.get(read)


def mujoco_rays() -> dict[Hashable, Callable[[], None]]:
    """As many rays as pings in one call of MuJoCo, for each kind of target; nothing where it is not installed."""
    try:
        import mujoco
    except ModuleNotFoundError:
        return {}
    shapes = {"plane": 'plane" size="5 5 1', "sphere": 'sphere" size="0.1', "capsule": 'capsule" size="0.1 0.5'}
    shapes["box"] = 'box" size="0.1 0.1 0.1'
    calls = {}
    for target, shape in shapes.items():
        place = 'pos="0.5 0 0" euler="0 -90 0"' if target == "plane" else 'pos="0.6 0 0"'
        geom = f'<geom type="{shape}" {place}/>'
        model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geom}</worldbody></mujoco>")
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        rays, geoms = np.tile([1.0, 0.0, 0.0], PINGS), np.zeros(PINGS, np.int32)
        lengths = np.zeros(PINGS)
        arguments = (model, data, np.zeros(3), rays, None, True, -1, geoms, lengths, None, PINGS, 1e3)
        mujoco.mj_multiRay(*arguments)
        if abs(lengths[-1] - REACH) > 1e-9:
            raise ValueError(f"MuJoCo's ray to the {target} is {lengths[-1]} m long, not {REACH}")
        calls["MuJoCo mj_multiRay", target] = partial(mujoco.mj_multiRay, *arguments)
    return calls


def speed_and_accuracy(fidelities: list[str], rounds: int) -> list[Table]:
    """Many pings in one step, for each kind of target; the second table puts what they cost beside MuJoCo's rays."""
    calls = {}
    for fidelity in fidelities:
        for target, placed in TARGETS.items():
            sensor = started("UltrasonicSensor", fidelity=fidelity, period=PERIOD, **ROLLED, **placed(REACH, ASIDE))
            calls[fidelity, target] = repeated_step(sensor, PINGS * PERIOD)
    several = started("UltrasonicSensor", period=PERIOD, **ROLLED, **SEVERAL)
    behind = started("UltrasonicSensor", period=PERIOD, **ROLLED, **BEHIND)
    crowded = started("UltrasonicSensor", period=PERIOD, **ROLLED, **CROWDED)
    extra = {("specular", "first three, clear of each other"): repeated_step(several, PINGS * PERIOD)}
    extra["specular", "the same, partly in each other's light"] = repeated_step(crowded, PINGS * PERIOD)
    extra["specular", "the same, one behind the other"] = repeated_step(behind, PINGS * PERIOD)
    together = started("UltrasonicSensor", period=PERIOD, **TOGETHER)
    extra["specular", "plane and sphere, echoes that overlap"] = repeated_step(together, PINGS * PERIOD)
    nothing = started("UltrasonicSensor", period=PERIOD, maximum_range=1.0)
    extra["specular", "none"] = repeated_step(nothing, PINGS * PERIOD)
    moving = started("UltrasonicSensor", period=PERIOD, velocity=[APPROACH, 0.0, 0.0], **plane(2 * REACH, ASIDE))
    shifted = ("specular", "plane, the sensor moves")
    extra[shifted] = repeated_step(moving, MOVING * PERIOD)
    cost = side_by_side(calls | extra | mujoco_rays(), rounds)
    rows, beside = [], []
    cheapest = min(cost[name][0] for name in calls)
    for name, (seconds, _) in cost.items():
        fidelity, target = name
        ping = seconds / (MOVING if name == shifted else PINGS)
        figures = (f"{fidelity}: {target}", ping * 1e9, ping * PINGS / cheapest)
        if name not in calls:
            beside.append(figures)
            continue
        places = (TARGETS[target](REACH), ROLLED | TARGETS[target](REACH, ASIDE))
        errors = [abs(heard(fidelity, "distance", EXACT | place) - REACH) for place in places]
        rows.append((*figures, *errors))
    first = Table(
        "UltrasonicSensor: fidelities",
        f"One doStep of {PINGS} pings, target {REACH:g} m away and {np.degrees(ASIDE):g} degrees aside (a plane: "
        "tilted), nearer to one ear. Errors of the distance against the image source, straight ahead and there; it is "
        "that of a target equally far from both ears.",
        ("fidelity: target", "ns a ping", "ratio", "error ahead, m", "error aside, m"),
        rows,
    )
    note = (
        f"In the same run: three targets at a time, no target, a sensor that comes at {APPROACH:g} m/s, so that the "
        "carrier is shifted; rays along the axis, many in one call."
    )
    second = Table("UltrasonicSensor: beside", note, ("what", "ns a ping or ray", "ratio"), beside)
    return [first, second]


def skin(vertices: int) -> tuple[dict, int]:
    """The mesh of a straight arm across, REACH away, as the sensor takes it; how many triangles are lit."""
    radius = 0.045
    values = {"upper_arm_position": [REACH + radius, -0.45, 0.0], "forearm_position": [REACH + radius, -0.15, 0.0]}
    values |= {f"{bone}_orientation": [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)] for bone in ("upper_arm", "forearm")}
    values |= {"radius": radius, "vertex_count": vertices, "upper_arm_length": 0.3}
    with started("ArmSkin", **values) as arm:
        mesh = {name: arm.get(name) for name in ("vertices", "triangles", "normals")}
    corners = np.float64(mesh["vertices"].T)[mesh["triangles"].reshape(-1, 3)]
    inputs = {"surface_vertex_count": vertices} | {f"surface_{name}": value for name, value in mesh.items()}
    return inputs, lit_triangles(corners, np.zeros((1, 3)))


def lit_triangles(corners: np.ndarray, ears: Iterable[np.ndarray]) -> int:
    """How many triangles [m, 3, 3], m, counterclockwise from outside, all ears are outside of."""
    first, second, third = np.moveaxis(corners, 1, 0)
    normals = np.cross(second - first, third - first)
    return int(np.sum(np.all([np.sum(normals * (ear - first), axis=1) > 0 for ear in ears], axis=0)))


def mujoco_rays_at_meshes(meshes: dict[int, dict]) -> dict[Hashable, Callable[[], None]]:
    """PINGS rays of MuJoCo in one call at each mesh; nothing where it is not installed."""
    try:
        import mujoco
    except ModuleNotFoundError:
        return {}
    calls = {}
    for vertices, mesh in meshes.items():
        rows = mesh["surface_triangles"].reshape(-1, 3)
        spec = mujoco.MjSpec()
        faces = rows[rows[:, 1] != rows[:, 2]]
        spec.add_mesh(name="arm", uservert=mesh["surface_vertices"].T.ravel(), userface=faces.ravel())
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="arm")
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        rays, geoms, lengths = np.tile([1.0, 0.0, 0.0], PINGS), np.zeros(PINGS, np.int32), np.zeros(PINGS)
        arguments = (model, data, np.zeros(3), rays, None, True, -1, geoms, lengths, None, PINGS, 1e3)
        mujoco.mj_multiRay(*arguments)
        if abs(lengths[-1] - REACH) > 1e-3:
            raise ValueError(f"MuJoCo's ray to the arm is {lengths[-1]} m long, not {REACH}")
        calls[vertices] = partial(mujoco.mj_multiRay, *arguments)
    return calls


def meshes(rounds: int) -> Table:
    """What a ping of `surface` at ArmSkin's mesh costs, and a ray of MuJoCo's at the same."""
    found = {vertices: skin(vertices) for vertices in SKINS}
    rays = mujoco_rays_at_meshes({vertices: mesh for vertices, (mesh, _) in found.items()})
    calls: dict[Hashable, Callable[[], None]] = {("ray", vertices): call for vertices, call in rays.items()}
    for vertices, (mesh, _) in found.items():
        sensor = started("UltrasonicSensor", **mesh, fidelity="surface", period=SKIN_PERIOD)
        calls["ping", vertices] = repeated_step(sensor, SKIN_PINGS * SKIN_PERIOD)
    cost = side_by_side(calls, rounds)
    rows = []
    for vertices, (_, lit) in found.items():
        ping = cost["ping", vertices][0] / SKIN_PINGS
        beside = [cost["ray", vertices][0] / PINGS * 1e9] if rays else []
        rows.append((f"{vertices} vertices", lit, ping * 1e6, ping / lit * 1e9, *beside))
    return Table(
        "UltrasonicSensor: surface",
        f"One doStep of {SKIN_PINGS} pings at ArmSkin's mesh, {REACH:g} m away"
        + ("; in the same run rays of MuJoCo along the axis at the same mesh." if rays else "."),
        ("mesh", "lit triangles", "us a ping", "ns a lit triangle", *(["ns a ray"] if rays else [])),
        rows,
    )


def moving_targets(fidelities: list[str]) -> Table:
    """Time of flight to a sphere that comes straight at the sensor."""
    speed = heard("specular", "speed_of_sound", {})
    rows = []
    for fidelity in fidelities:
        for approach in (0.0, 10.0, 50.0):
            errors = []
            for distance in DISTANCES:
                values = sphere(distance) | {"sphere_velocity": [-approach, 0.0, 0.0], "baseline": 0.0}
                # they meet after distance / (c + approach), and the way back is as long
                expected = 2 * distance / (speed + approach)
                errors.append(abs(heard(fidelity, "time_of_flight", EXACT | values) / expected - 1))
            rows.append((f"{fidelity}: {approach:g} m/s", *errors))
    return Table(
        "UltrasonicSensor: time of flight to a sphere that approaches",
        "Relative error against the closed form, by the distance at the emission; no baseline.",
        ("fidelity: approach", *(f"{distance:g} m" for distance in DISTANCES)),
        rows,
    )


def largest(audible: Callable[[float], bool], low: float, high: float) -> float:
    """The largest value that is audible, to a thousandth; `high` if that is."""
    if audible(high):
        return high
    while high - low > 1e-3 * low:
        middle = (low + high) / 2
        low, high = (middle, high) if audible(middle) else (low, middle)
    return low


def hearing() -> Table:
    """Up to where the default sensor hears, by bisection."""

    def is_heard(target: dict) -> bool:
        return bool(heard("specular", "valid", target))

    def reach(placed: Callable[[float], dict]) -> float:
        return largest(lambda distance: is_heard(placed(distance)), 0.1, LONGEST)

    def tilt(distance: float) -> float:
        return largest(lambda degrees: is_heard(plane(distance, np.radians(degrees))), 1.0, 89.0)

    rows = [
        ("wall, facing", reach(plane), "m"),
        ("wall at 1 m, tilted", tilt(1.0), "degrees"),
        ("wall at 3 m, tilted", tilt(3.0), "degrees"),
        *((f"ball, radius {radius:g} m", reach(partial(sphere, radius=radius)), "m") for radius in (0.05, 0.1, 0.2)),
        ("forearm across, radius 0.04 m", reach(partial(capsule, radius=0.04)), "m"),
        ("pole, radius 0.015 m", reach(partial(capsule, radius=0.015)), "m"),
    ]
    return Table(
        "UltrasonicSensor: what is heard",
        "specular, default threshold and air; from the sensor to the surface, or of the normal off the axis.",
        ("target", "up to", "unit"),
        rows,
    )


def bench(rounds: int) -> list[Table]:
    """Time and errors of each fidelity, and what the default sensor hears."""
    fidelities = [name for name in choices("UltrasonicSensor", "fidelity") if name != "surface"]  # which needs a mesh
    return [*speed_and_accuracy(fidelities, rounds), meshes(rounds), moving_targets(fidelities), hearing()]
