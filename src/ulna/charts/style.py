"""Colour, mark and name of every solver and peer, in one table."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Look:
    """How a solver is drawn."""

    label: str
    color: str
    mark: str
    peer: bool = False


# Colours after Okabe & Ito and Paul Tol, which stay apart for the colour-blind; marks differ besides.
LOOKS = {
    "explicit_euler": Look("explicit_euler", "#999999", "v"),
    "notes": Look("notes", "#7a5c3e", "^"),
    "semi_implicit_euler": Look("semi_implicit_euler", "#7a5c3e", "^"),
    "midpoint": Look("midpoint", "#e69f00", "s"),
    "splitting": Look("splitting", "#cc79a7", "D"),
    "rk4": Look("rk4", "#0072b2", "o"),
    "moser_veselov": Look("moser_veselov", "#56b4e9", "P"),
    "taylor": Look("taylor", "#d55e00", "*"),
    "exact": Look("exact", "#009e73", "X"),
    "automatic": Look("automatic", "#000000", "o"),
    "mujoco_euler": Look("MuJoCo Euler", "#b9a3d0", "v", peer=True),
    "mujoco_implicitfast": Look("MuJoCo implicitfast", "#8e6bbf", "^", peer=True),
    "mujoco_rk4": Look("MuJoCo RK4", "#5e3c99", "o", peer=True),
    "dop853": Look("SciPy DOP853", "#6b6b00", "s", peer=True),
    "cvode": Look("CVODE (FMPy)", "#a04000", "D", peer=True),
}


def look(solver: str) -> Look:
    """A solver that is new to the table is drawn in grey under its own name."""
    return LOOKS.get(solver, Look(solver, "#666666", "h"))
