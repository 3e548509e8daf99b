"""The rest frame of an imported mesh, the elbow at the origin and the upper arm along x; and its estimated lengths."""

import numpy as np

# m; ranges of the parameters
LENGTHS = {
    "upper_arm_length": (0.001, 100.0),
    "forearm_length": (0.001, 100.0),
    "radius": (0.0001, 10.0),
    "blend_half_width": (0.0001, 100.0),
}
# float32 matrices of scaled rigs
EVEN = 1e-3
# glTF 2.0, 3.4: +y is up, a model's front faces +z
UP, FRONT = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
# smoothstep is .01 where |x| is this share of its half width
ONE_PERCENT = 0.8822


def rest_frame(shoulder: np.ndarray, elbow: np.ndarray) -> tuple[np.ndarray, float]:
    """(4, 4) from glTF's world, m, to the rest frame, and the upper arm's length, m; ValueError out of its range."""
    length = float(np.linalg.norm(elbow - shoulder))
    check_length("upper_arm_length", length)
    x = (elbow - shoulder) / length
    across = UP if abs(x @ UP) < 0.9 else FRONT
    z = across - (across @ x) * x
    z /= np.linalg.norm(z)
    frame = np.eye(4)
    frame[:3, :3] = [x, np.cross(z, x), z]
    frame[:3, 3] = -frame[:3, :3] @ elbow
    return frame, length


def placed(
    where: str, vertices: np.ndarray, normals: np.ndarray | None, triangles: np.ndarray, matrix: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, normals (0 where there are none) and triangles, moved by a matrix (4, 4) that keeps shapes.

    Raises ValueError, which begins with `where`, for another matrix.
    """
    linear = matrix[:3, :3]
    scale = np.cbrt(np.linalg.det(linear))
    if not abs(scale) > 0.0 or np.abs(linear @ linear.T / scale**2 - np.eye(3)).max() > EVEN:
        raise ValueError(f"{where} is stretched by its nodes; allowed: the same scale in all directions")
    # column by column, so that equal vertices stay equal to the bit
    vertices = sum(vertices[:, k, None] * linear[:, k] for k in range(3)) + matrix[:3, 3]
    normals = np.zeros_like(vertices) if normals is None else normals @ linear.T / abs(scale)
    return vertices, normals, triangles if scale > 0.0 else triangles[:, ::-1]


def without_unused(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices that triangles with three corners have, and those triangles (t, 3) in their numbers."""
    triangles = triangles[np.all(triangles != np.roll(triangles, 1, axis=1), axis=1)]
    used, corners = np.unique(triangles, return_inverse=True)
    return used, corners.reshape(-1, 3)


def whole_normals(vertices: np.ndarray, triangles: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Normals at length 1; where they are 0, the mean of the triangles' by area, across seams too.

    Raises ValueError for a vertex that has neither.
    """
    corner = [vertices[triangles[:, k]] for k in range(3)]
    area = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    _, same = np.unique(vertices, axis=0, return_inverse=True)
    same = same.ravel()
    total = np.zeros((same.max() + 1, 3))
    for k in range(3):
        np.add.at(total, same[triangles[:, k]], area)
    normals = np.where(np.linalg.norm(normals, axis=1, keepdims=True) > 1e-6, normals, total[same])
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    if not np.all(size > 0.0):
        vertex = int(np.argmin(size))
        raise ValueError(f"vertex {vertex} has neither a normal nor a triangle with an area")
    return normals / size


def lengths(vertices: np.ndarray, shares: np.ndarray, distances: np.ndarray, upper_arm: float) -> dict[str, float]:
    """Estimates, m, by name.

    The forearm ends at the farthest vertex that follows it. Half of the vertices beside the bones are within the radius
    by `distances` (n,) from the bones, m, NaN where one does not count. The shares from 1 to 99 % are as far out as
    those of a smoothstep. Raises ValueError out of range.
    """
    x = vertices[:, 0]
    forearm = float(x[shares >= 0.5].max())
    check_length("forearm_length", forearm)
    beside = np.isfinite(distances) & (x > -upper_arm) & (x < forearm)
    radius = float(np.median(distances[beside])) if beside.any() else 0.0
    blend = np.abs(x[(shares > 0.01) & (shares < 0.99)])
    half_width = float(blend.max()) / ONE_PERCENT if len(blend) else radius
    found = dict(zip(LENGTHS, (upper_arm, forearm, radius, half_width), strict=True))
    for name, value in found.items():
        check_length(name, value)
    if radius + half_width >= forearm:
        raise ValueError(
            f"radius = {radius:.4g} m and blend_half_width = {half_width:.4g} m leave nothing of a forearm that ends "
            f"{forearm:.4g} m from the elbow; allowed range: their sum below its length. Does the forearm point along "
            "the upper arm at rest, and are all joints of the hand below it?"
        )
    return found


def check_length(name: str, value: float) -> None:
    """Raises ValueError for a length that the parameter of this name does not allow."""
    least, most = LENGTHS[name]
    if not least <= value <= most:
        raise ValueError(f"{name} = {value:.6g} m by the file; allowed range: {least:g} m to {most:g} m")
