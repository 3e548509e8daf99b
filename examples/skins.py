"""One elbow, bent to 150 degrees and twisted, under a skin by each method of ArmSkin: tears, collapses and bulges.

`results/skins/view.html` shows one skin at a time, and the plots all of them.
"""

from math import cos, pi, radians, sin

import numpy as np

from ulna import Scene

UNTIL = 8.0
STEP = 0.005
MASTER = "gauss_seidel"

METHODS = ("rigid", "linear_blend", "dual_quaternion", "center_of_rotation", "compensated")
BEND = radians(150.0)
TWIST = radians(170.0)


def elbow(time: float) -> np.ndarray:
    """Orientation of the forearm: bent and stretched within 4 s, then twisted and back, then at rest."""
    bend = BEND * sin(pi * time / 4.0) ** 2 if time < 4.0 else 0.0
    twist = TWIST * sin(pi * time / 4.0) ** 2 if time >= 4.0 else 0.0
    return np.array([cos(bend / 2.0) * cos(twist / 2.0), cos(bend / 2.0) * sin(twist / 2.0), -sin(bend / 2.0), 0.0])


def scene() -> Scene:
    """A skin for each method; all of the twist is left to the elbow, which is where skins fail."""
    skins = Scene("skins")
    for method in METHODS:
        skin = skins.add("ArmSkin", method, method=method, twist_share=0.0)
        skins.signal(skin.forearm_orientation, elbow)
        skins.record(skin.blend_volume_ratio, skin.minimum_section_ratio, skin.elbow_gap, skin.fold_fraction)
    return skins
