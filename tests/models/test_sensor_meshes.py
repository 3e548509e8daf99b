"""Meshes of models/ultrasonic_sensor/meshes.py: closed, outside out, fine, of the area and volume of their bodies."""

import numpy as np
import pytest

from ulna.bench.ultrasonic_sensor import lit_triangles
from ulna.checks.textbook import load_model

MODEL = load_model("ultrasonic_sensor.meshes")
EDGE = 3.3e-3  # m
AXES = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
START, END = np.array([1.0, 0.2, -0.1]), np.array([1.1, 0.0, 0.1])
BOX = np.array([0.05, 0.1, 0.07])  # m
LENGTH = 0.3  # m, of the capsule's axis
MESHES = {
    "sphere": (MODEL.capsule_mesh(START, START, 0.07, EDGE), 4 * np.pi * 0.07**2, 4 / 3 * np.pi * 0.07**3),
    "capsule": (
        MODEL.capsule_mesh(START, END, 0.04, EDGE),
        2 * np.pi * 0.04 * (LENGTH + 2 * 0.04),
        np.pi * 0.04**2 * (LENGTH + 4 / 3 * 0.04),
    ),
    "box": (MODEL.box_mesh(START, AXES, BOX, EDGE), 2 * (0.005 + 0.0035 + 0.007), 0.05 * 0.1 * 0.07),
}


@pytest.mark.parametrize("name", MESHES)
def test_area_and_volume_are_those_of_the_body_and_edges_are_short(name):
    mesh, area, volume = MESHES[name]
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    normal = np.cross(b - a, c - a) / 2
    # chords of EDGE on the least radius, 4 cm, lack 1/24 of its square twice in a section
    lack = 0.0 if name == "box" else (EDGE / 0.04) ** 2 / 6
    assert area * (1 - lack) <= np.linalg.norm(normal, axis=1).sum() <= area * (1 + 1e-12)
    inside = np.sum(normal * (a - mesh.vertices.mean(axis=0))) / 3
    assert volume * (1 - 2 * lack) <= inside <= volume * (1 + 1e-12), "outside out, too"
    longest = max(np.linalg.norm(edge, axis=1).max() for edge in (b - a, c - b, a - c))
    assert longest <= EDGE * (np.sqrt(2) if name == "box" else 1.03), "a box has the diagonals of squares"


@pytest.mark.parametrize("name", MESHES)
def test_normals_are_those_of_the_triangles_but_for_the_bend(name):
    mesh = MESHES[name][0]
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    # a corner is at most an edge away from the middle of its triangle, on a radius of 4 cm or more
    least = 1.0 - 1e-12 if name == "box" else np.cos(EDGE / 0.04)
    for corner in range(3):
        assert np.sum(flat * mesh.normals[mesh.triangles[:, corner]], axis=1).min() > least
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("name", ["sphere", "capsule"])
def test_each_edge_has_a_triangle_on_either_side(name):
    mesh = MESHES[name][0]
    edges = np.concatenate([mesh.triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    forward = {tuple(edge) for edge in edges.tolist()}
    assert len(forward) == len(edges)
    assert {edge[::-1] for edge in forward} == forward
    assert len(mesh.triangles) == 2 * len(mesh.vertices) - 4


def test_inputs_are_padded_at_vertex_0_and_without_normals_flat():
    mesh = MODEL.plate_mesh(np.zeros(3), (np.array([0.0, 0.01, 0.0]), np.array([0.0, 0.0, 0.01])), 0.005)
    inputs = mesh.inputs()
    assert inputs["surface_vertex_count"] == 9
    assert inputs["surface_vertices"].shape == inputs["surface_normals"].shape == (3, 9)
    assert inputs["surface_triangles"].shape == (2, 9, 3)
    rows = inputs["surface_triangles"].reshape(-1, 3)
    np.testing.assert_array_equal(rows[:8], mesh.triangles)
    assert not rows[8:].any()
    assert not mesh.inputs(normals=False)["surface_normals"].any()
    for side, lit in ((1.0, 8), (-1.0, 0)):
        assert lit_triangles(mesh.vertices[mesh.triangles], [np.array([side, 0.0, 0.0])]) == lit


def test_half_of_a_far_sphere_is_lit():
    mesh = MODEL.capsule_mesh(np.zeros(3), np.zeros(3), 0.05, EDGE)
    lit = lit_triangles(mesh.vertices[mesh.triangles], (np.array([100.0, 0.01, 0.0]), np.array([100.0, -0.01, 0.0])))
    # but for the triangles at the rim, two to an edge
    rim = 2 * np.pi * 0.05 / EDGE
    assert abs(lit - len(mesh.triangles) / 2) < 2 * rim
