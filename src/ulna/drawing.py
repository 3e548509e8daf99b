"""What a scene looks like: the shape and the motion of each unit, for the glTF file and the pictures."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .connections import End
from .results import Results
from .scene import Scene, SceneUnit
from .slave import Slave

Color = tuple[float, float, float]

WHITE: Color = (0.93, 0.92, 0.89)
ORANGE: Color = (0.91, 0.43, 0.16)
BLUE: Color = (0.16, 0.38, 0.62)
SILVER: Color = (0.70, 0.72, 0.75)
GREEN: Color = (0.05, 0.30, 0.20)


@dataclass(frozen=True)
class Shape:
    """A closed triangle mesh, counterclockwise from outside: all arrays float32 but `triangles`, (m, 3) int32.

    `vertices` (n, 3), m; `normals` (n, 3), unit; `colors` (n, 3), linear, 0 to 1.
    """

    vertices: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    colors: np.ndarray

    def turned(self, direction: np.ndarray) -> "Shape":
        """The same shape with its x axis turned to a direction."""
        axis = direction / np.linalg.norm(direction)
        side = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
        side /= np.linalg.norm(side)
        turn = np.float32([axis, side, np.cross(axis, side)])
        return replace(self, vertices=self.vertices @ turn, normals=self.normals @ turn)

    def moved(self, offset: tuple[float, float, float]) -> "Shape":
        """The same shape elsewhere."""
        return replace(self, vertices=self.vertices + np.float32(offset))


@dataclass(frozen=True)
class Part:
    """A rigid thing in the picture: `position` (n, 3), m, and `orientation` (n, 4), w x y z, at the recorded times."""

    name: str
    shape: Shape
    position: np.ndarray
    orientation: np.ndarray


# Values of a run


def series(results: Results, scene: Scene, name: str) -> np.ndarray:
    """The values of "unit.variable" at all times, shape (n, *shape of the variable).

    The recorded column; for an input that was not recorded, what drives it, or the constant that it was set to.
    Raises KeyError if its source was not recorded.
    """
    if name in results:
        return results[name]
    unit, variable = name.split(".")
    end = scene[unit][variable]
    for connection in scene.connections:
        if connection.target == end:
            return connection.factor * results[connection.source.name] + connection.offset
    for signal in scene.signals:
        if signal.target == end:
            return np.array([signal.function(time) for time in results.time.tolist()])
    if end.variable.causality != "input":
        return results[name]
    return np.broadcast_to(scene[unit].slave.get(variable), (len(results), *end.shape))


def source_of(scene: Scene, target: End) -> SceneUnit | None:
    """The unit whose output drives an input."""
    return next((c.source.unit for c in scene.connections if c.target == target), None)


def units_of(scene: Scene, model: str) -> list[SceneUnit]:
    """The units of a scene that are instances of a model, such as RigidBody."""
    return [unit for unit in scene.units.values() if unit.slave.description.name == model]


# Shapes


def ellipsoid(radii: tuple[float, float, float], rows: int = 24, columns: int = 48) -> Shape:
    """About the origin, in eight segments of two colours, so that a spin shows."""
    faces = []
    for column in range(8):
        u = np.linspace(column, column + 1, columns // 8 + 1) * (np.pi / 4)
        v = np.linspace(0.0, np.pi, rows + 1)
        u, v = (grid.reshape(-1) for grid in np.meshgrid(u, v, indexing="ij"))
        direction = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=1)
        normals = direction / np.array(radii)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        color = WHITE if column % 2 else ORANGE
        faces.append(_shape(direction * radii, normals, _grid_triangles(columns // 8 + 1, rows + 1), color))
    return joined(faces)


def box(sides: tuple[float, float, float], color: Color, face_colors: dict[int, Color] | None = None) -> Shape:
    """About the origin, edges along the axes. `face_colors`: of faces 0 to 5, -x +x -y +y -z +z."""
    faces = []
    for number in range(6):
        axis, sign = number // 2, 1.0 if number % 2 else -1.0
        normal = np.eye(3)[axis] * sign
        a, b = np.roll(np.eye(3), -(axis + 1), axis=0)[:2]
        corners = np.array([normal + i * sign * a + j * b for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        face_color = (face_colors or {}).get(number, color)
        faces.append(_shape(corners * sides / 2, np.tile(normal, (4, 1)), [(0, 1, 2), (0, 2, 3)], face_color))
    return joined(faces)


def cylinder(radius: float, length: float, color: Color, sides: int = 32) -> Shape:
    """Along +x, from the origin."""
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    circle = np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    ends = np.concatenate([circle * radius, circle * radius + [length, 0.0, 0.0]])
    n = sides + 1
    wall = [t for k in range(sides) for t in ((k, k + 1, n + k), (k + 1, n + k + 1, n + k))]
    parts = [_shape(ends, np.tile(circle, (2, 1)), np.array(wall), color)]
    for x, sign in ((0.0, -1.0), (length, 1.0)):
        points = np.concatenate([[[x, 0.0, 0.0]], circle[:-1] * radius + [x, 0.0, 0.0]])
        fan = np.array([(0, 1 + k, 1 + (k + 1) % sides) for k in range(sides)])
        normals = np.tile([sign, 0.0, 0.0], (len(points), 1))
        parts.append(_shape(points, normals, fan if sign > 0 else fan[:, ::-1], color))
    return joined(parts)


def joined(shapes: list[Shape]) -> Shape:
    """Several shapes as one."""
    starts = np.cumsum([0, *(len(shape.vertices) for shape in shapes[:-1])])
    return Shape(
        np.concatenate([shape.vertices for shape in shapes]),
        np.concatenate([shape.normals for shape in shapes]),
        np.concatenate([shape.triangles + start for shape, start in zip(shapes, starts, strict=True)]).astype(np.int32),
        np.concatenate([shape.colors for shape in shapes]),
    )


def _shape(vertices, normals, triangles, color: Color) -> Shape:
    vertices, triangles = np.asarray(vertices, np.float32), np.asarray(triangles, np.int32)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    flat = np.linalg.norm(np.cross(b - a, c - a), axis=1) == 0.0
    colors = np.tile(np.float32(color), (len(vertices), 1))
    return Shape(vertices, np.asarray(normals, np.float32), triangles[~flat], colors)


def _grid_triangles(columns: int, rows: int) -> np.ndarray:
    i, j = (grid.reshape(-1) for grid in np.meshgrid(np.arange(columns - 1), np.arange(rows - 1), indexing="ij"))
    a = i * rows + j
    b, c, d = a + rows, a + 1, a + rows + 1
    return np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])


# Units


def parts(results: Results, scene: Scene) -> list[Part]:
    """All rigid things of a scene; a bone in a skin is not seen. Raises KeyError if their motion was not recorded."""
    drawn = []
    skins = units_of(scene, "ArmSkin")
    covered = [source_of(scene, bone) for skin in skins for bone in (skin.forearm_position, skin.upper_arm_position)]
    for unit in scene.units.values():
        if unit.slave.description.name in LOOKS and unit not in covered:
            look = LOOKS[unit.slave.description.name]
            motion = (series(results, scene, f"{unit.name}.{name}") for name in ("position", "orientation"))
            drawn.append(Part(unit.name, look(scene, unit), *motion))
    return drawn


def _body(scene: Scene, unit: SceneUnit) -> Shape:
    """A ball if a sensor takes it for one; else the box of even density that has its moments of inertia."""
    for sensor in units_of(scene, "UltrasonicSensor"):
        if source_of(scene, sensor.sphere_center) is unit:
            return ellipsoid((sensor.slave.get("sphere_radius"),) * 3)
    inertia = np.array(unit.slave.get("inertia"))
    squares = np.maximum(6.0 * (inertia.sum() - 2.0 * inertia) / unit.slave.get("mass"), 0.0)
    sides = np.sqrt(np.maximum(squares, 1e-4 * squares.max()))
    return box(tuple(sides), WHITE, {5: ORANGE, 4: BLUE})


def _bone(_scene: Scene, unit: SceneUnit) -> Shape:
    """A thin rod from the hinge to the tip."""
    tip = np.array(unit.slave.get("tip"))
    length = float(np.linalg.norm(tip))
    return cylinder(0.03 * length, length, SILVER).turned(tip)


def _sensor(_scene: Scene, unit: SceneUnit) -> Shape:
    """Transmitter and receiver, a baseline apart, on a board."""
    half = unit.slave.get("baseline") / 2.0
    board = box((0.002, 0.046, 0.021), GREEN).moved((-0.001, 0.0, 0.0))
    return joined([board, *(cylinder(0.008, 0.012, SILVER).moved((0.0, side, 0.0)) for side in (half, -half))])


# The variables `position` and `orientation` of these units move them.
LOOKS: dict[str, Callable[[Scene, SceneUnit], Shape]] = {
    "RigidBody": _body,
    "HingedBody": _bone,
    "UltrasonicSensor": _sensor,
}


def skin_like(unit: SceneUnit) -> Slave:
    """A new ArmSkin with the parameters of a unit in a scene, initialised; to be closed."""
    skin = Slave("ArmSkin")
    variables = unit.slave.description.variables.values()
    for causality in ("structuralParameter", "parameter"):
        for variable in (v for v in variables if v.causality == causality):
            skin.set(variable.name, unit.slave.get(variable.name))
    skin.initialize()
    return skin
