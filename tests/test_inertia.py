"""ulna.inertia against textbook formulas, exact rational integrals, quadrature, and shapes given again as meshes."""

import doctest
import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import nquad, quad
from scipy.spatial.transform import Rotation

from ulna import Slave, inertia

DENSITY = 1040.0
# Sums over some hundreds of triangles, each right to a few units in the last place.
ROUND_OFF = 1e-13
TURN = Rotation.from_rotvec([0.4, -1.1, 0.7])

CUBE = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
CUBE_TRIANGLES = [
    *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
    *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
]


def box_mesh(size) -> tuple[np.ndarray, np.ndarray]:
    """Corners about the origin, and twelve triangles."""
    return (np.array(CUBE) - 0.5) * size, np.array(CUBE_TRIANGLES)


def turned_mesh(profile: np.ndarray, around: int) -> tuple[np.ndarray, np.ndarray]:
    """The solid of a profile, [n, 2] of (r, z) from the upper pole to the lower, turned about z in `around` steps."""
    angles = 2 * np.pi * np.arange(around) / around
    rings = [np.stack([r * np.cos(angles), r * np.sin(angles), np.full(around, z)], axis=1) for r, z in profile[1:-1]]
    vertices = np.concatenate([[[0, 0, profile[0][1]]], *rings, [[0, 0, profile[-1][1]]]])
    triangles = []
    for i in range(around):
        j, last = (i + 1) % around, len(rings) - 1
        triangles.append([0, 1 + i, 1 + j])
        for ring in range(last):
            a, b = 1 + ring * around, 1 + (ring + 1) * around
            triangles += [[a + i, b + i, b + j], [a + i, b + j, a + j]]
        triangles.append([len(vertices) - 1, 1 + last * around + j, 1 + last * around + i])
    return vertices, np.array(triangles)


def arc(radius: float, start: float, end: float, steps: int, z: float = 0.0) -> np.ndarray:
    """Points (r, z) of a meridian between two angles from the upper pole."""
    angles = np.linspace(start, end, steps + 1)
    return np.stack([radius * np.sin(angles), z + radius * np.cos(angles)], axis=1)


ROUND = {
    "sphere": (lambda: inertia.sphere(0.3, DENSITY), lambda n: arc(0.3, 0, math.pi, n)),
    "cylinder": (
        lambda: inertia.cylinder(0.2, 0.7, DENSITY),
        lambda n: np.array([[0, 0.35], [0.2, 0.35], [0.2, -0.35], [0, -0.35]]),
    ),
    "capsule": (
        lambda: inertia.capsule(0.2, 0.7, DENSITY),
        lambda n: np.concatenate(
            [arc(0.2, 0, math.pi / 2, n // 2, 0.35), arc(0.2, math.pi / 2, math.pi, n // 2, -0.35)]
        ),
    ),
}
SHAPES = {"box": lambda: inertia.box((0.3, 0.9, 0.5), DENSITY)} | {name: solid for name, (solid, _) in ROUND.items()}


def polyhedron_of(name: str, steps: int) -> inertia.Inertia:
    return inertia.mesh(*turned_mesh(ROUND[name][1](steps), 2 * steps), DENSITY)


def slices(radius_at, low: float, high: float) -> np.ndarray:
    """Mass and tensor diagonal of a solid of revolution about z, from its discs by quadrature."""
    disc = [lambda z, r=radius_at: math.pi * r(z) ** 2, lambda z, r=radius_at: math.pi * r(z) ** 4]
    volume, fourth = (quad(f, low, high, epsabs=1e-14, epsrel=1e-13, points=[-0.35, 0.35])[0] for f in disc)
    along = quad(lambda z: z**2 * disc[0](z), low, high, epsabs=1e-14, epsrel=1e-13, points=[-0.35, 0.35])[0]
    return DENSITY * np.array([volume, fourth / 4 + along, fourth / 4 + along, fourth / 2])


def test_the_moments_are_those_of_the_textbook():
    box, ball, rod = (SHAPES[name]() for name in ("box", "sphere", "cylinder"))
    expected = box.mass / 12 * np.array([0.9**2 + 0.5**2, 0.3**2 + 0.5**2, 0.3**2 + 0.9**2])
    assert box.mass == pytest.approx(DENSITY * 0.3 * 0.9 * 0.5, rel=1e-15)
    np.testing.assert_allclose(np.diag(box.tensor()), expected, rtol=1e-14)
    assert ball.mass == pytest.approx(DENSITY * 4 / 3 * math.pi * 0.027, rel=1e-15)
    np.testing.assert_allclose(ball.moments, 2 / 5 * ball.mass * 0.09, rtol=1e-14)
    across = rod.mass * (3 * 0.2**2 + 0.7**2) / 12
    np.testing.assert_allclose(np.diag(rod.tensor()), [across, across, rod.mass * 0.2**2 / 2], rtol=1e-14)


def test_a_capsule_is_the_sum_of_its_discs():
    def radius(z: float) -> float:
        return math.sqrt(max(0.0, 0.2**2 - max(0.0, abs(z) - 0.35) ** 2))

    capsule = SHAPES["capsule"]()
    found = [capsule.mass, *np.diag(capsule.tensor())]
    np.testing.assert_allclose(found, slices(radius, -0.55, 0.55), rtol=1e-12)  # quadrature's own tolerance is 1e-13


def test_a_capsule_without_a_cylinder_is_a_sphere_and_one_without_length_is_none():
    np.testing.assert_allclose(inertia.capsule(0.3, 0.0, DENSITY).moments, inertia.sphere(0.3, DENSITY).moments)
    # a long one is a cylinder but for its ends, whose part falls as 1/length
    thin, rod = inertia.capsule(1e-6, 1.0, DENSITY), inertia.cylinder(1e-6, 1.0, DENSITY)
    np.testing.assert_allclose(thin.moments, rod.moments, rtol=1e-5)


def test_a_box_given_as_a_mesh_is_that_box():
    box, found = SHAPES["box"](), inertia.mesh(*box_mesh((0.3, 0.9, 0.5)), DENSITY)
    assert found.mass == pytest.approx(box.mass, rel=ROUND_OFF)
    np.testing.assert_allclose(found.moments, box.moments, rtol=ROUND_OFF)
    np.testing.assert_allclose(found.tensor(), box.tensor(), atol=ROUND_OFF * box.moments[2])


@pytest.mark.parametrize("name", ROUND)
def test_meshes_of_round_shapes_converge_with_order_two(name):
    exact = ROUND[name][0]()

    def errors(steps: int) -> np.ndarray:
        found = polyhedron_of(name, steps)
        return np.array([found.mass / exact.mass - 1, *(found.moments / exact.moments - 1)])

    # a facet lies as far inside as its width squared; the next term of the error is of order four
    orders = np.log2(errors(16) / errors(32))
    np.testing.assert_allclose(orders, 2.0, atol=0.02)
    assert np.all(errors(32) < 0.0), "a polyhedron inside a convex shape has less of everything"


def test_random_tetrahedra_have_exactly_the_rational_integrals():
    generator = np.random.default_rng(4)
    for _ in range(50):
        corners = generator.integers(-20, 21, (4, 3))
        a, b, c = ([Fraction(int(x)) for x in corners[i] - corners[0]] for i in (1, 2, 3))
        determinant = sum(a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3]) for i in range(3))
        if abs(determinant) < 50:  # flat ones lose digits in any arithmetic but the rational
            continue
        volume = abs(determinant) / 6
        mean = [Fraction(int(corners[:, k].sum()), 4) for k in range(3)]
        points = [[Fraction(int(x)) - m for x, m in zip(p, mean, strict=True)] for p in corners]
        # the integral of x_i x_j is V/20 (sum of p_i p_j + s_i s_j); about the corners' mean their sum s is 0
        second = [[volume / 20 * sum(p[i] * p[j] for p in points) for j in range(3)] for i in range(3)]
        trace = second[0][0] + second[1][1] + second[2][2]
        tensor = np.array([[float((i == j) * trace - second[i][j]) for j in range(3)] for i in range(3)])
        triangles = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
        if determinant < 0:
            triangles = triangles[:, ::-1]
        found = inertia.mesh(corners, triangles, 1.0)
        assert found.mass == pytest.approx(float(volume), rel=1e-13)
        np.testing.assert_allclose(found.center, corners.mean(axis=0), atol=1e-13)
        np.testing.assert_allclose(found.tensor(), tensor, atol=1e-12 * found.moments[2])


def test_a_turned_and_moved_mesh_keeps_its_moments_and_says_how_it_is_turned():
    vertices, triangles = box_mesh((0.3, 0.9, 0.5))
    still = inertia.mesh(vertices, triangles, DENSITY)
    moved = inertia.mesh(TURN.apply(vertices) + np.array([1, -2, 3]), triangles, DENSITY)
    np.testing.assert_allclose(moved.center, [1, -2, 3], rtol=1e-14)
    np.testing.assert_allclose(moved.moments, still.moments, rtol=ROUND_OFF)
    turn = TURN.as_matrix()
    np.testing.assert_allclose(moved.tensor(), turn @ still.tensor() @ turn.T, atol=1e-13 * still.moments[2])


@pytest.mark.parametrize(
    "turn", [Rotation.random(rng=seed) for seed in range(20)] + [Rotation.from_rotvec([np.pi, 0, 0])]
)
def test_the_principal_axes_are_right_handed_ascending_and_make_the_tensor_diagonal(turn):
    vertices, triangles = box_mesh((0.3, 0.9, 0.5))
    found = inertia.mesh(turn.apply(vertices), triangles, DENSITY)
    axes = Rotation.from_quat(np.roll(found.orientation, -1)).as_matrix()  # always right-handed
    assert np.linalg.norm(found.orientation) == pytest.approx(1.0, abs=1e-14)
    assert found.orientation[0] >= 0.0
    assert np.all(np.diff(found.moments) > 0.0)
    # against the tensor by quadrature-free closed form, turned
    tensor = turn.as_matrix() @ SHAPES["box"]().tensor() @ turn.as_matrix().T
    np.testing.assert_allclose(axes.T @ tensor @ axes, np.diag(found.moments), atol=1e-13 * found.moments[2])


def test_the_axes_are_the_least_turn_among_the_right_handed_ones():
    # the longest edge along x, so that the moments ascend along x, y, z already
    found = inertia.box((0.9, 0.5, 0.3), DENSITY)
    np.testing.assert_array_equal(found.orientation, [1, 0, 0, 0])
    np.testing.assert_array_equal(inertia.sphere(0.3, DENSITY).orientation, [1, 0, 0, 0])
    vertices, triangles = box_mesh((0.9, 0.5, 0.3))
    for seed in range(10):
        # a turn by less than 90 degrees is the least: the others turn by 180 degrees more about one axis
        turn = Rotation.from_rotvec(np.random.default_rng(seed).uniform(-0.8, 0.8, 3))
        found = inertia.mesh(turn.apply(vertices), triangles, DENSITY).orientation
        np.testing.assert_allclose(found, np.roll(turn.as_quat(canonical=True), 1), atol=1e-13)


def test_the_tensor_about_a_point_follows_from_shifting_the_shape():
    point = np.array([0.4, -0.2, 0.9])
    box = SHAPES["box"]()

    def moment(i: int, j: int) -> float:
        def density(x: float, y: float, z: float) -> float:
            r = np.array([x, y, z]) - point
            return DENSITY * ((i == j) * (r @ r) - r[i] * r[j])

        # polynomials of degree two: Gauss's rule is exact
        return nquad(density, [[-0.15, 0.15], [-0.45, 0.45], [-0.25, 0.25]], opts={"epsrel": 1e-10})[0]

    expected = [[moment(i, j) for j in range(3)] for i in range(3)]
    np.testing.assert_allclose(box.tensor(point), expected, rtol=1e-12, atol=1e-12)


def test_parts_add_up_by_the_parallel_axis_theorem():
    vertices, triangles = box_mesh((0.3, 0.9, 0.5))
    both = np.concatenate([vertices, 0.5 * vertices + [1, 2, 3]]), np.concatenate([triangles, triangles + 8])
    pair = inertia.mesh(*both, DENSITY)
    parts = [inertia.mesh(v, triangles, DENSITY) for v in (vertices, 0.5 * vertices + [1, 2, 3])]
    assert pair.mass == pytest.approx(sum(part.mass for part in parts), rel=ROUND_OFF)
    expected = sum(part.tensor(about=pair.center) for part in parts)
    np.testing.assert_allclose(pair.tensor(), expected, atol=ROUND_OFF * pair.moments[2])


def test_a_cavity_is_taken_away():
    vertices, triangles = box_mesh((0.3, 0.9, 0.5))
    hollow = inertia.mesh(
        np.concatenate([vertices, 0.5 * vertices]), np.concatenate([triangles, triangles[:, ::-1] + 8]), DENSITY
    )
    solid = inertia.mesh(vertices, triangles, DENSITY)
    assert hollow.mass == pytest.approx(solid.mass * (1 - 1 / 8), rel=ROUND_OFF)
    np.testing.assert_allclose(hollow.moments, solid.moments * (1 - 1 / 32), rtol=ROUND_OFF)


def test_a_far_origin_costs_only_the_digits_that_the_vertices_lose():
    vertices, triangles = box_mesh((0.3, 0.9, 0.5))
    far = inertia.mesh(vertices + 1e6, triangles, DENSITY)
    # a vertex at 1e6 m is known to 6e-11 m, of an edge of 0.3 m
    np.testing.assert_allclose(far.moments, inertia.mesh(vertices, triangles, DENSITY).moments, rtol=2e-9)


@pytest.mark.parametrize("name", SHAPES)
def test_no_moment_exceeds_the_other_two_so_that_rigid_body_takes_all(name):
    solid = SHAPES[name]()
    needle = inertia.cylinder(1e-5, 1.0, DENSITY)
    plate = inertia.box((1.0, 1.0, 1e-6), DENSITY)
    for found in (solid, needle, plate):
        assert found.moments[2] <= (found.moments[0] + found.moments[1]) * (1 + 1e-15)
        with Slave("RigidBody") as body:
            body.set("mass", found.mass)
            body.set("inertia", found.moments)
            body.set("initial_orientation", found.orientation)
            body.initialize()


def test_the_integrals_of_the_notes_are_no_inertia():
    """One number for all axes, that grows with the wrong power of the size."""
    size, brick = np.array([1.0, 2.0, 3.0]), inertia.box((1.0, 2.0, 3.0), 1000.0)
    # midpoint rule, order two; 60^3 cells are within 1e-3 of both integrals
    cells = np.stack(np.meshgrid(*[(np.arange(60) + 0.5) / 60 - 0.5] * 3, indexing="ij"), axis=-1).reshape(-1, 3)

    def of_notes(scale: float) -> tuple[float, float]:
        distances = np.linalg.norm(cells * size * scale, axis=1)
        mass = 1000.0 * np.prod(size * scale)
        return mass * np.mean(distances**2), mass * np.mean(distances)

    squares, lengths = of_notes(1.0)
    assert squares == pytest.approx(brick.moments.sum() / 2, rel=1e-3)
    assert lengths == pytest.approx(6106, rel=1e-3)
    for wrong in (squares, lengths):
        assert np.max(np.abs(brick.moments / wrong - 1)) > 0.5
    twice = inertia.box(2 * size, 1000.0)
    np.testing.assert_allclose(twice.moments / brick.moments, 32.0, rtol=1e-14)
    assert of_notes(2.0)[1] / lengths == pytest.approx(16.0, rel=1e-12)
    # a torque about x meets the moment about x
    with Slave("RigidBody") as body:
        body.set("inertia", brick.moments)
        body.set("initial_orientation", brick.orientation)
        body.set("torque", [65.0, 0, 0])
        body.initialize()
        acceleration = body.get("angular_acceleration")[0]
    assert acceleration == pytest.approx(65.0 / 6500.0, rel=1e-13)
    assert acceleration != pytest.approx(65.0 / squares, rel=0.05)


def test_the_numbers_in_the_docstring_are_true():
    assert doctest.testmod(inertia) == (0, 2)


WRONG_MESHES = {
    "a hole": (lambda v, t: (v, t[1:]), r"not closed: only triangle \d+ has the edge of vertices \d and \d \(3 such"),
    "a triangle turned round": (
        lambda v, t: (v, np.concatenate([t[:1, ::-1], t[1:]])),
        r"not oriented: triangles \[0, \d+\] run the same way along the edge",
    ),
    "a fin": (lambda v, t: (np.append(v, [[9, 9, 9]], 0), np.append(t, [[0, 1, 8]], 0)), "not closed"),
    "inside out": (lambda v, t: (v, t[:, ::-1]), "inside out .*swap two corners of every triangle"),
    "flat": (lambda v, t: (TURN.apply(v * [1, 1, 0]), t), "encloses no volume"),
    "a corner twice": (lambda v, t: (v, np.append(t, [[0, 0, 1]], 0)), r"triangle 12 has a corner twice: \[0, 0, 1\]"),
    "an index too high": (lambda v, t: (v, np.append(t, [[0, 1, 8]], 0)), r"triangle 12 is \[0, 1, 8\], .* 0 to 7"),
    "an index below 0": (lambda v, t: (v, np.append(t, [[0, 1, -1]], 0)), "triangle 12 is"),
    "not a number": (lambda v, t: (v * [1, 1, np.nan], t), "vertex 0 is not finite"),
    "indices not whole": (lambda v, t: (v, t * 1.0), "whole numbers"),
    "points of a plane": (lambda v, t: (v[:, :2], t), r"shape must be \(n, 3\), not \(8, 2\)"),
    "no triangles": (lambda v, t: (v, t[:0]), "triangles: whole numbers"),
}


@pytest.mark.parametrize("name", WRONG_MESHES)
def test_a_wrong_mesh_is_refused_with_what_is_wrong(name):
    spoil, message = WRONG_MESHES[name]
    with pytest.raises(ValueError, match=message):
        inertia.mesh(*spoil(np.array(CUBE, float), np.array(CUBE_TRIANGLES)), DENSITY)


WRONG_SIZES = {
    "radius = -1": lambda: inertia.sphere(-1, DENSITY),
    "radius = 0": lambda: inertia.cylinder(0, 1, DENSITY),
    "length = 0": lambda: inertia.cylinder(1, 0, DENSITY),
    "length = -1": lambda: inertia.capsule(1, -1, DENSITY),
    "density = nan": lambda: inertia.box((1, 2, 3), math.nan),
    r"size\[1\] = 0": lambda: inertia.box((1, 0, 3), DENSITY),
    "size: three": lambda: inertia.box((1, 2), DENSITY),
    "density = 0": lambda: inertia.mesh(*box_mesh(1.0), 0.0),
}


@pytest.mark.parametrize("message", WRONG_SIZES)
def test_a_wrong_size_is_refused_by_name(message):
    with pytest.raises(ValueError, match=message):
        WRONG_SIZES[message]()


def test_a_result_cannot_be_changed():
    solid = inertia.sphere(1.0, DENSITY)
    with pytest.raises(ValueError, match="read-only"):
        solid.moments[0] = 1.0
    with pytest.raises(AttributeError):
        solid.mass = 1.0
