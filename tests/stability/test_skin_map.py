"""The map of skins: where ArmSkin tears, folds, collapses and flips, on both sides of the closed forms."""

import math

import numpy as np
import pytest

from ulna.stability import skin_theory as theory
from ulna.stability.skin_measuring import (
    COLLAPSED,
    FOLLOWED,
    SHORTER,
    TORN,
    VERTICES,
    bend,
    measured_fold,
    skin_of,
    verdict,
)

BANDS = VERTICES // 32 // 4 * 2
"""Of rings in the blend zone."""
BAND = 2 / BANDS
"""Their width over h."""
DEPTH = 1 / (math.cos(2 * math.pi / 32) * (1 - BAND**2 / 3))
"""Largest part by which the mesh folds late: a triangle at the inner elbow reaches from r to r cos(2 pi / 32) from the
bone, and over a band of width u h, where the weight grows less by u^2/3 than at the elbow itself. Folds hang on h/r and
their angles are concave in it from 0 on, so that they grow by no larger part than it."""
NEAR = DEPTH - 1
"""Part of an angle that cells are away from a border for their verdict to be certain."""
PIVOT = ("hinge", "dual_quaternion")
KNOWN = ("linear_blend", *PIVOT)


def expected(row):
    """The verdict by the closed forms; None near a border, and where there is none."""
    method, kind, ratio, angle = (row[key] for key in ("method", "bend", "ratio", "angle"))
    if method == "rigid":
        edge = BAND * ratio
        gap = theory.gap(angle)
        return None if abs(gap - TORN) < edge or gap < TORN else "torn"
    if kind == "twist":
        if method != "linear_blend":
            return "sound"
        # at a quarter turn the section is COLLAPSED, at half a turn a point
        if angle in (90.0, 180.0):
            return None
        return "sound" if angle < 90.0 else "collapsed" if angle < 180.0 else "flipped"
    border = theory.fold_angle(method, ratio)
    section = theory.section(method, kind, angle)
    if border is None or 1 - NEAR < angle / border < 1 + NEAR or abs(section - COLLAPSED) < 1e-9 or angle == 180.0:
        return None
    folded = angle > border
    if section < COLLAPSED:
        return "folded, collapsed" if folded else "collapsed"
    return "folded" if folded else "sound"


@pytest.mark.parametrize("method", KNOWN)
@pytest.mark.parametrize("ratio", [0.25, 0.6, 1.0, 1.5, 2.0, 2.25, 2.9])
def test_first_fold_is_at_the_angle_of_the_closed_form(method, ratio):
    closed = theory.fold_angle(method, ratio)
    assert closed - theory.WITHIN <= measured_fold(method, ratio) <= closed * DEPTH + theory.WITHIN


@pytest.mark.parametrize("method", PIVOT)
@pytest.mark.parametrize("ratio", [3.0, 3.5])
def test_turns_about_the_pivot_do_not_fold_from_three_radii_on(method, ratio):
    assert theory.fold_angle(method, ratio) == math.inf
    assert measured_fold(method, ratio) == math.inf


def test_known_angles_of_the_default_width():
    """90 and 106 degrees at h = 1.5 r; 150 degrees without a fold need 2.3 r."""
    assert theory.fold_angle("linear_blend", 1.5) == pytest.approx(90.0)
    assert theory.fold_angle("dual_quaternion", 1.5) == pytest.approx(106.26, abs=0.005)
    assert theory.fold_angle("dual_quaternion", 2.3) == pytest.approx(150.0, abs=0.5)


@pytest.mark.parametrize("method", KNOWN)
@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_smooth_surface_folds_at_the_closed_form(method, ratio):
    """Its grid has a row of points on the elbow and a spoke at the innermost line, where the first fold is."""
    assert theory.smooth_fold_angle(method, ratio) == pytest.approx(theory.fold_angle(method, ratio), abs=theory.WITHIN)


def test_folds_without_a_closed_form_are_those_of_the_smooth_surface(skins):
    rows = [row for row in skins["folds"] if not row["closed_form"]]
    assert {row["method"] for row in rows} == {"center_of_rotation", "compensated"}
    for row in rows:
        # both borders are searched; a ring of the grid may stand where another is of the mesh, 1/64 of h away
        assert row["theory"] - 2 * theory.WITHIN <= row["measured"] <= row["theory"] * DEPTH, row


def test_verdicts_change_at_their_bounds():
    for kind, inverted in (("flexion", "folded"), ("twist", "flipped")):
        assert verdict(kind, TORN - 1e-9, 0.0, COLLAPSED + 1e-9) == "sound"
        assert verdict(kind, TORN + 1e-9, 0.1, COLLAPSED - 1e-9) == "torn"
        assert verdict(kind, 0.0, 1e-9, 1.0) == inverted
        assert verdict(kind, 0.0, 0.0, COLLAPSED - 1e-9) == "collapsed"
    assert verdict("flexion", 0.0, 1e-9, COLLAPSED - 1e-9) == "folded, collapsed"
    assert (TORN, COLLAPSED) == (0.25, 0.5), "what the picture's key says"


def test_every_cell_has_the_verdict_of_the_closed_forms(skins):
    certain = [row for row in skins["cells"] if expected(row)]
    for row in certain:
        assert row["verdict"] == expected(row), row
    kinds = {row["verdict"] for row in certain}
    assert kinds == {"sound", "folded", "collapsed", "folded, collapsed", "flipped", "torn"}
    assert len(certain) > 0.55 * len(skins["cells"])


def test_twist_collapses_at_half_a_turn_and_flips_beyond_only_with_the_linear_blend(skins):
    for row in skins["cells"]:
        if row["bend"] == "twist" and row["method"] not in ("rigid", "linear_blend"):
            assert row["verdict"] == "sound" and row["section"] == pytest.approx(1.0, abs=1e-12), row
    with skin_of("linear_blend", 1.5) as skin:
        bend(skin, "twist", 180.0)
        assert skin.get("minimum_section_ratio") == pytest.approx(0.0, abs=1e-12)


def test_rigid_skin_is_open_by_the_closed_form_less_an_edge(skins):
    rows = [row for row in skins["cells"] if row["method"] == "rigid"]
    for row in rows:
        edge = BAND * row["ratio"]
        assert -edge - 1e-9 <= row["gap"] - theory.gap(row["angle"]) <= 1e-9, row


def test_sections_and_volume_of_the_linear_blend_are_those_of_the_closed_forms(skins):
    for row in [row for row in skins["curves"] if row["method"] == "linear_blend"]:
        where = row["bend"], row["angle"]
        # round-off
        assert row["section"] == pytest.approx(theory.section("linear_blend", *where), abs=1e-12), row
        # chords between rings: the README's bound
        assert row["volume"] == pytest.approx(theory.volume(*where), abs=1.5 / BANDS**2), row


def test_followed_turns_never_jump_and_the_shorter_way_jumps_through_the_arm(skins):
    """A degree moves the hand by pi r / 180; the shorter way turns the middle from +89.75 to -89.75 degrees."""
    rows = [row for row in skins["flips"] if row["method"] == "dual_quaternion"]
    followed, shorter = ([row for row in rows if row["mode"] == mode] for mode in (FOLLOWED, SHORTER))
    assert len(followed) == len(shorter) > 20
    # float32 coordinates: 3e-8 m over r
    assert all(row["move"] < 2 * math.sin(math.radians(0.5)) + 5e-6 for row in followed)
    jumps = {row["angle"]: row["move"] for row in shorter if row["move"] > 0.02}
    assert jumps == pytest.approx({180.0: 2 * math.cos(math.radians(0.25)), 540.0: 2 * math.cos(math.radians(0.25))})


def test_one_turn_and_two_have_no_holes():
    with skin_of("dual_quaternion", 1.5) as skin:
        for angle in np.arange(10.0, 721.0, 10.0):
            bend(skin, "twist", float(angle))
            skin.step(skin.time, 0.01)
            assert np.isfinite(skin.get("vertices")).all() and np.isfinite(skin.get("normals")).all()
            assert skin.get("minimum_section_ratio") == pytest.approx(1.0, abs=1e-12)
