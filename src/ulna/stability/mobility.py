"""How a body gives way where it is joined, and what that says of the loops through a joint.

A mobility is the acceleration of a point by force there, 1/kg; its inverse is the mass that the joint feels.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def free_mobility(mass: float, inertia: Sequence[float], frame: Sequence[float]) -> Array:
    """Mobility [3, 3] (1/kg), in body axes, of a point of a free body, at `frame` (m) from its centre of mass.

    `mass` in kg, `inertia` [3] the principal moments in kg m2: 1/m - [r] I^-1 [r], the square of the cross product.
    """
    cross = _cross(frame)
    return np.eye(3) / mass - cross @ np.diag(1.0 / np.asarray(inertia, float)) @ cross


def hinged_mobility(moment: float, axis: Sequence[float], tip: Sequence[float]) -> Array:
    """Mobility [3, 3] (1/kg), in body axes, of a point at `tip` (m) from a fixed hinge about `axis`, of length 1.

    `moment` is that about the hinge, kg m2. It gives way in one direction only.
    """
    lever = np.cross(axis, tip)
    return np.outer(lever, lever) / moment


def joint_gains(mobility: Array, k: float, c: float, H: float) -> Array:
    """Gains [3] of fixed-point iteration, least first, of a spring k (N/m) and damper c (N s/m), alike in all
    directions, between two points whose mobilities add up to `mobility` [3, 3] (1/kg), in steps of H (s).

    `coupling_theory.iteration_gain` for each direction: the eigenvalues of (k H^2/6 + c H/2) times the mobility.
    """
    return (k * H**2 / 6 + c * H / 2) * np.linalg.eigvalsh(mobility)


def hinge_loop_gain(
    upper_moment: float, upper_length: float, mass: float, lever: float, moment: float, angle: float
) -> float:
    """Gain of the algebraic loop of two HingedBody units in a plane, a forearm on the tip of an upper arm.

    The tip's acceleration moves the forearm's anchor, whose reaction pulls the tip. `upper_moment` (kg m2) about the
    shoulder, `upper_length` (m) to the elbow; of the forearm `mass` (kg), `lever` (m) from the elbow to its centre of
    mass, `moment` (kg m2) about the centre, and `angle` (rad) of the elbow, 0 where it is straight. A pass through both
    multiplies the error of the reaction by

        -(l^2 / J1) m (1 - m s^2 / (I + m s^2) cos^2(angle))

    the upper arm's mobility across itself times the mass of the forearm felt in that direction: all of it along the
    forearm, m I / (I + m s^2) across, where it swings away. Passes settle only between -1 and 0: beyond, the master
    must relax or solve. No torque about the axis reacts, so the anchor's angular acceleration has no part.
    """
    share = mass * lever**2 / (moment + mass * lever**2)
    return -(upper_length**2 / upper_moment) * mass * (1 - share * math.cos(angle) ** 2)


def settling_mass_ratio(slenderness: float, angle: float) -> float:
    """Largest ratio of the forearm's mass to that felt at the tip of the upper arm, J1 / l^2, at which passes settle.

    `slenderness` is the radius of gyration about the centre of mass over the distance of that from the elbow, `angle`
    (rad) as in `hinge_loop_gain`, which is -1 here: 1 for a right angle, 1 + 1/slenderness^2 for a straight elbow.
    """
    return 1 / (1 - math.cos(angle) ** 2 / (1 + slenderness**2))


def _cross(r: Sequence[float]) -> Array:
    x, y, z = r
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
