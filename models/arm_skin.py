"""ArmSkin from matrices and from the eight components of dual quaternions; its normals by the Jacobian's cofactors.

Points are carried in the world: a blend of the two bones' motions there must be what a blend in any other axes is.
Source: Kavan, Collins, Zara and O'Sullivan, "Geometric skinning with approximate dual quaternion blending", ACM
Transactions on Graphics 27 (4), 2008; Clifford, "Preliminary sketch of biquaternions", 1873; Le and Hodgins,
"Real-time skeletal skinning with optimized centers of rotation", ACM Transactions on Graphics 35 (4), 2016.
"""

from collections.abc import Mapping
from functools import cache

import casadi as ca
from casadi import SX

from .algebra import Equations, Values, conjugate, in_other_units, left, pure, right, rotation_matrix, substituted

LENGTHS = {"upper_arm_length": "m", "forearm_length": "m", "radius": "m", "blend_half_width": "m"}
POSES = {
    "upper_arm_position": "m",
    "upper_arm_orientation": "1",
    "forearm_position": "m",
    "forearm_orientation": "1",
}
SKIN = {
    "point": "m",
    "weight": "1",
    "weight_gradient": "1/m",
    "rest_normal": "1",
    "center": "m",
    "center_rate": "m",
    "widening": "1",
}
"""A vertex at rest: from the elbow; share of the forearm, its gradient; outward unit normal; centre of rotation, from
the elbow, its derivative by the weight; how much wider the middle of the blend zone is made."""

METHODS = ("linear_blend", "hinge", "dual_quaternion", "center_of_rotation", "compensated")
RIGID_SECTIONS = METHODS[1:4]
DRAW = 0.32
"""How far `compensated` draws a section in: by its shape over the weight, in half widths."""

CAPSULES = {
    "capsule_1_start": "m",
    "capsule_1_end": "m",
    "capsule_1_radius": "m",
    "capsule_2_start": "m",
    "capsule_2_end": "m",
    "capsule_2_radius": "m",
}
HOLDERS = ("upper_arm", "forearm")
POINTS = {f"{method}_{kind}": "m" for method in METHODS for kind in ("point", "vertex", "ring_vertex")}
POINTS |= {f"{bone}_vertex": "m" for bone in HOLDERS}
NORMALS = {f"{method}_{kind}": "1" for method in METHODS for kind in ("normal", "ring_normal")}
NORMALS |= {f"{bone}_normal": "1" for bone in HOLDERS}
BEND = {"bend_rotation": "1", "bend_gap": "m"}
RESULTS = CAPSULES | BEND | POINTS | NORMALS
UNITS = LENGTHS | POSES | SKIN | RESULTS
SIZES = dict.fromkeys((*LENGTHS, "weight", "widening"), 1) | {"upper_arm_orientation": 4, "forearm_orientation": 4}

SMALLEST_SQUARE = 2.0**-126
"""Stands in for the square of a normal without length: the smallest normal number of float32."""

SAMPLES = dict.fromkeys((*LENGTHS, "metre", "kilogram", "second"), (0.5, 2.0)) | {"weight": (0.0, 1.0)}


def symbols() -> Values:
    """Free symbols for lengths, poses and a vertex; the quaternions have any length."""
    return {name: SX.sym(name, SIZES.get(name, 3)) for name in LENGTHS | POSES | SKIN}


def equations(values: Values) -> Values:
    """Capsules, the bend at the elbow, and a vertex by each method: SI units.

    `METHOD_point` is in the axes of the upper arm, from its elbow; `METHOD_vertex` and `METHOD_normal` in the world;
    `METHOD_ring_normal` is that of a ring in the y, z plane on which weight and centre are the same.
    """
    function = _derived()
    results = function(*[values[name] for name in function.name_in()])
    return dict(zip(RESULTS, results, strict=True))


@cache
def _derived() -> ca.Function:
    """The results on free symbols, where they can be differentiated."""
    values = symbols()
    results = _derive(values)
    places = [f"result_{i}" for i, _ in enumerate(RESULTS)]
    return ca.Function("arm_skin", [*values.values()], [results[name] for name in RESULTS], [*values], places)


def _derive(values: Values) -> Values:
    upper_arm, forearm, elbow = bone_maps(values)
    turn, place = upper_arm[:3, :3], upper_arm[:3, 3]
    relative = inverse_motion(upper_arm) @ forearm
    results = {
        "bend_rotation": left(conjugate(_unit(values, "upper_arm"))) @ _unit(values, "forearm"),
        "bend_gap": relative[:3, :3] @ elbow + relative[:3, 3] - elbow,
        **_capsules(values),
    }
    blends = (_linear_blend, _hinge, _dual_quaternion_blend, _center_of_rotation, _compensated)
    for method, blend in zip(METHODS, blends, strict=True):
        vertex = blend(values)
        results[f"{method}_vertex"] = results[f"{method}_ring_vertex"] = vertex
        results[f"{method}_point"] = turn.T @ (vertex - place) - elbow
        results[f"{method}_normal"] = deformed_normal(vertex, values)
        results[f"{method}_ring_normal"] = deformed_normal(vertex, values | _on_ring(values))
    for bone, image in zip(HOLDERS, (upper_arm, forearm), strict=True):
        results[f"{bone}_vertex"] = (image @ ca.vertcat(elbow + values["point"], 1))[:3]
        results[f"{bone}_normal"] = image[:3, :3] @ values["rest_normal"]
    # a ring's middle is on the bone, and so is its centre of rotation
    on_bone = [(values[name][1:], SX.zeros(2)) for name in ("center", "center_rate")]
    for kind in ("ring_vertex", "ring_normal"):
        results[f"center_of_rotation_{kind}"] = substituted(results[f"center_of_rotation_{kind}"], on_bone)
    return results


def _on_ring(values: Values) -> Values:
    """A ring of radius 1 m: normals along the bone and along the spokes, the weight's gradient along the bone."""
    point, normal = values["point"], values["rest_normal"]
    return {
        "rest_normal": ca.vertcat(normal[0], normal[1] * point[1:]),
        "weight_gradient": ca.vertcat(values["weight_gradient"][0], SX(2, 1)),
    }


def _unit(values: Values, bone: str) -> SX:
    q = values[f"{bone}_orientation"]
    return q / ca.norm_2(q)


def motion_matrix(turn: SX, place: SX) -> SX:
    """x -> turn x + place on (x, 1), 4x4."""
    return ca.blockcat([[turn, place], [SX(1, 3), SX(1)]])


def inverse_motion(motion: SX) -> SX:
    """The motion back, for a 4x4 matrix of a rotation and a shift."""
    turn = motion[:3, :3]
    return motion_matrix(turn.T, -turn.T @ motion[:3, 3])


def bone_maps(values: Values) -> tuple[SX, SX, SX]:
    """What carries the arm from rest (shoulder at the origin, along x) to the world; and the elbow at rest."""
    elbow = ca.vertcat(values["upper_arm_length"], 0, 0)
    turns = [rotation_matrix(values[f"{bone}_orientation"]) for bone in ("upper_arm", "forearm")]
    from_elbow = motion_matrix(SX.eye(3), -elbow)
    upper_arm = motion_matrix(turns[0], values["upper_arm_position"])
    return upper_arm, motion_matrix(turns[1], values["forearm_position"]) @ from_elbow, elbow


def _mean_image(values: Values, point: SX) -> SX:
    """The mean of the bones' matrices, on a point from the elbow."""
    upper_arm, forearm, elbow = bone_maps(values)
    weight = values["weight"]
    blend = (1 - weight) * upper_arm + weight * forearm
    return (blend @ ca.vertcat(elbow + point, 1))[:3]


def _linear_blend(values: Values) -> SX:
    return _mean_image(values, values["point"])


def _mean_turn(values: Values) -> SX:
    """The rotation of the normalised mean of the bones' quaternions."""
    weight = values["weight"]
    return rotation_matrix((1 - weight) * _unit(values, "upper_arm") + weight * _unit(values, "forearm"))


def _hinge(values: Values) -> SX:
    """Turned about the elbow, which the bones carry to places of which the mean counts."""
    return _mean_turn(values) @ values["point"] + _mean_image(values, SX(3, 1))


def _center_of_rotation(values: Values) -> SX:
    """Le and Hodgins, equation 1 and algorithm 1: the centre is carried by the mean of the matrices."""
    center = values["center"]
    return _mean_turn(values) @ (values["point"] - center) + _mean_image(values, center)


def _compensated(values: Values) -> SX:
    """As `hinge`, of a point whose section is wider, and drawn in toward the inner elbow."""
    weight, point = values["weight"], values["point"]
    turn = left(conjugate(_unit(values, "upper_arm"))) @ _unit(values, "forearm")
    bow = weight * (1 - weight) * (1 + 3 * (1 - 2 * weight) ** 2)
    inward = DRAW * values["blend_half_width"] * bow * ca.cross(turn[1:], SX([1, 0, 0]))
    width = 1 + 4 * values["widening"] * weight * (1 - weight)
    section = ca.vertcat(point[0], width * point[1:]) + inward
    return _mean_turn(values) @ section + _mean_image(values, SX(3, 1))


def dual_product(a: SX, b: SX) -> SX:
    """The product of two dual quaternions, eight components each: real part, then dual part."""
    matrix = ca.blockcat([[left(a[:4]), SX(4, 4)], [left(a[4:]), left(a[:4])]])
    return matrix @ b


def _dual_motion(q: SX, shift: SX) -> SX:
    """The unit dual quaternion of x -> R(q) x + shift."""
    return ca.vertcat(q, right(q) @ pure(shift) / 2)


def _dual_quaternion_blend(values: Values) -> SX:
    """The normalised mean of the bones' dual quaternions, on the point: b (1 + eps x) b' / (b b*)."""
    upper_arm, forearm, elbow = bone_maps(values)
    weight = values["weight"]
    first = _dual_motion(_unit(values, "upper_arm"), upper_arm[:3, 3])
    blend = (1 - weight) * first + weight * _dual_motion(_unit(values, "forearm"), forearm[:3, 3])
    real, dual = blend[:4], blend[4:]
    back = ca.vertcat(conjugate(real), -conjugate(dual))
    square = dual_product(blend, ca.vertcat(conjugate(real), conjugate(dual)))  # a dual number
    one_over = ca.vertcat(1 / square[0], SX(3, 1), -square[4] / square[0] ** 2, SX(3, 1))
    point = ca.vertcat(1, SX(4, 1), elbow + values["point"])
    moved = dual_product(dual_product(dual_product(blend, point), back), one_over)
    return moved[5:]


def cofactors(matrix: SX) -> SX:
    """det(M) M^-T of a 3x3 matrix, also where it is singular: Cayley and Hamilton."""
    trace, square = ca.trace(matrix), matrix @ matrix
    return (square - trace * matrix + (trace**2 - ca.trace(square)) / 2 * SX.eye(3)).T


def deformed_normal(vertex: SX, values: Values) -> SX:
    """cof(J) n over its length; J the Jacobian of the deformation, in which weight and centre change with the point."""
    by_weight = ca.jacobian(vertex, values["weight"]) + ca.jacobian(vertex, values["center"]) @ values["center_rate"]
    jacobian = ca.jacobian(vertex, values["point"]) + by_weight @ values["weight_gradient"].T
    normal = cofactors(jacobian) @ values["rest_normal"]
    return normal / ca.sqrt(ca.dot(normal, normal) + SMALLEST_SQUARE)


def _capsules(values: Values) -> Values:
    """Their axes are those of the bones: at rest from one round end to the elbow, and on to the other."""
    upper_arm, forearm, elbow = bone_maps(values)

    def carried(bone: SX, x: SX) -> SX:
        return (bone @ ca.vertcat(x, 0, 0, 1))[:3]

    end = values["upper_arm_length"] + values["forearm_length"] - values["radius"]
    return {
        "capsule_1_start": carried(upper_arm, values["radius"]),
        "capsule_1_end": carried(upper_arm, elbow[0]),
        "capsule_1_radius": values["radius"],
        "capsule_2_start": carried(forearm, elbow[0]),
        "capsule_2_end": carried(forearm, end),
        "capsule_2_radius": values["radius"],
    }


def identities(f: Equations) -> dict[str, SX]:
    """What holds for every skin between two bones, by the claim in words."""
    values = symbols()
    results = f(values)
    return {
        **_images(f, values, results),
        **_rigid_motions(f, values, results),
        **_normals(results, values),
        "every equation is right in its units": in_other_units(f, values, UNITS, CAPSULES | BEND | POINTS),
    }


def _world(values: Values, point: SX) -> SX:
    """From the axes of the upper arm, from its elbow, to the world."""
    upper_arm, _, elbow = bone_maps(values)
    return (upper_arm @ ca.vertcat(elbow + point, 1))[:3]


def _images(f: Equations, values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """Where a point goes at rest, at the ends of the blend, and between."""
    upper_arm, forearm, elbow = bone_maps(values)
    point, weight = values["point"], values["weight"]
    q = values["upper_arm_orientation"]
    unbent = {"forearm_orientation": q, "forearm_position": _world(values, SX(3, 1)), "widening": SX(0)}
    straight = f(values | unbent)
    images = [(bone @ ca.vertcat(elbow + point, 1))[:3] for bone in (upper_arm, forearm)]
    mean = (1 - weight) * images[0] + weight * images[1]
    ring = f(values | {"center": SX([1, 0, 0]) * values["center"]})
    claims = {"linear blend is the mean of the two images": _world(values, results["linear_blend_point"]) - mean}
    for method in METHODS:
        ends = [f(values | {"weight": SX(end)}) for end in (0, 1)]
        claims |= {
            f"{method}: an unbent arm keeps its shape": straight[f"{method}_point"] - point,
            f"{method}: at the ends of the blend a point follows one bone": ca.vertcat(
                *[_world(values, end[f"{method}_point"]) - image for end, image in zip(ends, images, strict=True)]
            ),
            f"{method}: the mesh's closed form is the definition": results[f"{method}_vertex"]
            - _world(values, results[f"{method}_point"]),
            f"{method}: a ring is a row of vertices": ring[f"{method}_ring_vertex"] - ring[f"{method}_vertex"],
        }
    return claims | {
        "the capsules lie along the bones, one round end within each": ca.vertcat(
            results["capsule_1_end"] - _world(values, SX(3, 1)),
            results["capsule_2_start"] - values["forearm_position"],
            _axis_error(results, values, "capsule_1", "upper_arm"),
            _axis_error(results, values, "capsule_2", "forearm"),
        ),
        "a straight arm has its capsules in one line": ca.cross(
            straight["capsule_2_end"] - straight["capsule_1_end"],
            straight["capsule_1_end"] - straight["capsule_1_start"],
        ),
        "the bend is the forearm seen from the upper arm": ca.vertcat(
            ca.vec(
                rotation_matrix(results["bend_rotation"]) - rotation_matrix(q).T @ forearm[:3, :3],
            ),
            rotation_matrix(q) @ results["bend_gap"] - (values["forearm_position"] - _world(values, SX(3, 1))),
        ),
    }


def _axis_error(results: Mapping[str, SX], values: Values, capsule: str, bone: str) -> SX:
    """A capsule's axis less that of its bone, as long as the bone without the round end."""
    axis = results[f"{capsule}_end"] - results[f"{capsule}_start"]
    length = values[f"{bone}_length"] - results[f"{capsule}_radius"]
    return axis - length * rotation_matrix(values[f"{bone}_orientation"])[:, 0]


def _rigid_motions(f: Equations, values: Values, results: Mapping[str, SX]) -> dict[str, SX]:
    """The arm moved as a whole; the two bones exchanged; a dual quaternion moves a section without strain."""
    turn, shift, other = SX.sym("turn", 4), SX.sym("shift", 3), SX.sym("other_point", 3)
    matrix = rotation_matrix(turn)
    moved = {}
    for bone in ("upper_arm", "forearm"):
        moved[f"{bone}_position"] = matrix @ values[f"{bone}_position"] + shift
        moved[f"{bone}_orientation"] = left(turn) @ values[f"{bone}_orientation"]
    there = f(values | moved)
    vectors = [name for name in CAPSULES | POINTS if not name.endswith(("radius", "point"))]
    same = [name for name in RESULTS if name.endswith(("radius", "point")) or name in BEND]

    upper_arm, forearm, elbow = bone_maps(values)
    exchanged = values | {
        "upper_arm_orientation": values["forearm_orientation"],
        "upper_arm_position": forearm[:3, 3],
        "forearm_orientation": values["upper_arm_orientation"],
        "forearm_position": (upper_arm @ ca.vertcat(elbow, 1))[:3],
        "weight": 1 - values["weight"],
    }
    swapped, neighbour = f(exchanged), f(values | {"point": other})
    distance = values["point"] - other
    strained = {name: results[f"{name}_point"] - neighbour[f"{name}_point"] for name in RIGID_SECTIONS}
    return {
        "moved as a whole, the arm keeps its shape": ca.vertcat(
            *[there[name] - matrix @ results[name] - shift for name in vectors],
            *[there[name] - matrix @ results[name] for name in NORMALS],
            *[there[name] - results[name] for name in same],
        ),
        **{
            f"{method}: one weight is one rigid motion": ca.dot(strain, strain) - ca.dot(distance, distance)
            for method, strain in strained.items()
        },
        **{
            f"{method}: no bone comes first": _world(exchanged, swapped[f"{method}_point"])
            - _world(values, results[f"{method}_point"])
            for method in METHODS[:4]
        },
    }


def _normals(results: Mapping[str, SX], values: Values) -> dict[str, SX]:
    """The skin's normals stand on the skin as it is deformed, and on that side which was outside."""
    claims = {}
    for method in METHODS:
        vertex, ring = results[f"{method}_vertex"], results[f"{method}_ring_vertex"]
        claims[f"{method}: normals are the cofactors of the deformation's own Jacobian"] = ca.vertcat(
            results[f"{method}_normal"] - deformed_normal(vertex, values),
            results[f"{method}_ring_normal"] - deformed_normal(ring, values | _on_ring(values)),
        )
    return claims
