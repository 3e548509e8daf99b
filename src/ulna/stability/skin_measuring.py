"""Where skins tear, fold, collapse and flip, measured on the FMU over angle and width of the blend."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..bench.measuring import choices, started
from ..bench.skinning import RADIUS, about
from ..slave import Slave
from . import skin_theory as theory

AXES = {"flexion": [0.0, 1.0, 0.0], "twist": [1.0, 0.0, 0.0]}
LARGEST = {"flexion": 180.0, "twist": 360.0}
"""degrees"""
VERTICES = 8192
TORN, COLLAPSED = 0.25, 0.5
"""Radii of a gap and part of a section, from and below which a skin is said to be torn and collapsed."""
WIDTH = 1.5
"""Of the unit's start values: h/r of the curves over the angle."""
FOLLOWED, SHORTER = "turns followed", "the shorter way"


def measure_skin(quick: bool = False) -> dict[str, Any]:
    """All that the map shows: verdicts of cells, borders of folds, curves of section and volume, and flips."""
    methods = choices("ArmSkin", "method")
    ratios = np.arange(0.5, 4.01, 0.5) if quick else np.arange(0.25, 4.01, 0.25)
    step = 15.0 if quick else 5.0
    return {
        "about": {"vertices": VERTICES, "torn": TORN, "collapsed": COLLAPSED, "width": WIDTH, "step": step},
        "cells": [row for method in methods for ratio in ratios for row in cells(method, float(ratio), step)],
        "folds": [row for method in methods for row in folds(method, ratios[1::4] if quick else ratios)],
        "curves": [row for method in methods for row in curves(method, step)],
        "flips": [row for method in ("linear_blend", "dual_quaternion") for row in flips(method, 2 * step)],
    }


def skin_of(method: str, ratio: float) -> Slave:
    """At rest, with h/r, all of the twist in the blend zone."""
    width = ratio * RADIUS
    return started("ArmSkin", vertex_count=VERTICES, method=method, blend_half_width=width, twist_share=0.0)


def bend(skin: Slave, kind: str, angle: float) -> None:
    """Turns the forearm; angle in degrees from rest."""
    skin.set("forearm_orientation", about(AXES[kind], angle))


def follow(skin: Slave, kind: str, angles: np.ndarray) -> Iterator[float]:
    """Bends and steps from rest through angles (degrees) less than half a turn apart, so that turns are followed."""
    for angle in angles:
        bend(skin, kind, float(angle))
        skin.step(skin.time, 0.01)
        yield float(angle)


def verdict(kind: str, gap: float, folded: float, section: float) -> str:
    """Of a cell: gap in radii, part of the triangles, least section over that at rest.

    A twist folds nothing. What stands against the turn that was followed has gone through the bone's axis.
    """
    if gap > TORN:
        return "torn"
    if kind == "twist" and folded > 0.0:
        return "flipped"
    if section < COLLAPSED:
        return "folded, collapsed" if folded > 0.0 else "collapsed"
    return "folded" if folded > 0.0 else "sound"


def cells(method: str, ratio: float, step: float) -> Iterator[dict[str, Any]]:
    """Over flexion, and a whole turn of twist."""
    for kind, largest in LARGEST.items():
        with skin_of(method, ratio) as skin:
            for angle in follow(skin, kind, np.arange(step, largest + 0.1, step)):
                gap = skin.get("elbow_gap") / RADIUS
                folded, least = skin.get("fold_fraction"), skin.get("minimum_section_ratio")
                found = {"gap": gap, "fold_fraction": folded, "section": least}
                where = {"method": method, "bend": kind, "ratio": ratio, "angle": angle}
                yield {**where, **found, "verdict": verdict(kind, gap, folded, least)}


def measured_fold(method: str, ratio: float) -> float:
    """Degrees of flexion at which the first triangle is inverted; inf if none is before 180."""
    with skin_of(method, ratio) as skin:

        def folded(angle: float) -> bool:
            bend(skin, "flexion", angle)
            return skin.get("fold_fraction") > 0.0

        return theory.border(folded, 179.9)


def folds(method: str, ratios: np.ndarray) -> Iterator[dict[str, Any]]:
    """The border of folds, measured, beside the closed form, and beside that of the smooth surface where none is."""
    if method == "rigid":
        return
    for ratio in map(float, ratios):
        known = theory.fold_angle(method, ratio)
        found = theory.smooth_fold_angle(method, ratio) if known is None else known
        row = {"method": method, "ratio": ratio, "measured": measured_fold(method, ratio)}
        yield {**row, "theory": found, "closed_form": known is not None}


def curves(method: str, step: float) -> Iterator[dict[str, Any]]:
    """Least section and volume over flexion and half a turn of twist."""
    with skin_of(method, WIDTH) as skin:
        for kind in AXES:
            for angle in np.arange(0.0, 180.1, step):
                bend(skin, kind, float(angle))
                found = {"section": skin.get("minimum_section_ratio"), "volume": skin.get("blend_volume_ratio")}
                yield {"method": method, "bend": kind, "angle": float(angle), **found}


def flips(method: str, step: float) -> Iterator[dict[str, Any]]:
    """The farthest that a vertex goes while the twist grows by one degree, radii, through two turns.

    Turns followed, as the unit does from step to step; and each pose by itself, the unit put back to its start.
    """
    for mode in (FOLLOWED, SHORTER):
        with skin_of(method, WIDTH) as skin:
            start, before = skin.save(), None
            # half a degree beside the middles, for at 180 itself both ways are as short
            angles = np.unique(np.concatenate([np.arange(0.0, 720.1, step), np.arange(175.0, 720.0, 180.0)]))
            steps = np.sort(np.concatenate([angles - 0.5, angles + 0.5]))
            for angle in steps:
                if mode == SHORTER:
                    skin.restore(start)
                    bend(skin, "twist", float(angle))
                else:
                    list(follow(skin, "twist", np.array([angle])))
                points = skin.get("vertices")
                if before is not None and angle - before[0] < 1.0 + 1e-9:
                    move = np.linalg.norm(points - before[1], axis=0).max() / RADIUS
                    yield {"method": method, "mode": mode, "angle": (angle + before[0]) / 2, "move": float(move)}
                before = angle, points
