"""The map of k, c and H through the FMUs, every master on both sides of the borders that theory sees."""

import math

import numpy as np
import pytest

from ulna.stability import coupling_theory as theory
from ulna.stability.coupling_measuring import RELAXED_GAIN, border, cell
from ulna.stability.oscillator import MASTERS, STEP, Oscillator, factors, parameters, rate_error, seen, theory_of

EVERY = pytest.mark.parametrize("master", MASTERS)
DAMPING_RATIOS = (0.05, 0.5, 3.0)
NEAR = 0.05
"""Part of a border by which tests stay away from it, on either side."""


@pytest.fixture(scope="module")
def oscillator():
    with Oscillator() as made:
        yield made


def ran(oscillator, master, z, zeta, count):
    *_, k, c = parameters(z, zeta)
    run = oscillator.run(master, k, c, STEP, count)
    return run.distance() / [1.0, z / STEP], run.failure


def test_the_factors_of_a_known_step_are_found():
    """Five numbers, of which two are seen, as with a jacobi that extrapolates; also where it grows without end."""
    matrix = theory.jacobi_order_1(0.8, 0.35, 1e4, 20.0, 1e-3)
    for scale in (1.0, 2.0):
        state, rows = np.array([0.01, 2.0, 100.0, 50.0, 70.0]), []
        for _ in range(60):
            rows.append(state[:2])
            state = scale * matrix @ state
        short = seen(np.array(rows))
        assert (len(short) < 60) == (scale > 1.0)
        for factor in scale * np.linalg.eigvals(matrix):
            assert np.abs(factors(short) - factor).min() < 1e-6


def test_rates_of_a_true_swing_have_no_error():
    m1, m2, k, c = parameters(0.3, 0.2)
    rate = theory.true_rates(m1, m2, k, c)[0]
    swing = np.exp(rate * STEP * np.arange(60))
    rows = np.stack([swing.real, (rate * swing).real], axis=1)
    assert rate_error(rows, k, c, STEP) < 1e-10
    # twice the damping: the rate moves by zeta w
    assert rate_error(rows, k, 2 * c, STEP) == pytest.approx(0.2, rel=0.05)


@EVERY
def test_every_cell_grows_as_theory_says(coupled, master):
    rows = [row for row in coupled["cells"] if row["master"] == master and row["verdict"] != "did not settle"]
    assert len(rows) > 70
    for row in rows:
        # of factors that grow a hundredfold a step, three rows are all there is to see
        bound = 1e-6 if row["theory_growth"] < 1.0 else 1e-4
        assert row["growth"] == pytest.approx(row["theory_growth"], abs=bound), row
        if row["theory_error"] < 0.1:
            assert row["error"] == pytest.approx(row["theory_error"], abs=1e-5), row
    kinds = {row["verdict"] for row in rows}
    assert kinds == {"accurate", "bounded", "neither"}


@EVERY
def test_cells_lie_on_the_right_side_of_the_borders(coupled, master):
    borders = {row["zeta"]: border(master, row["zeta"]) for row in coupled["cells"]}
    for row in [row for row in coupled["cells"] if row["master"] == master and row["verdict"] != "did not settle"]:
        edges = borders[row["zeta"]]
        if min(abs(row["z"] / edges[kind] - 1.0) for kind in ("stable", "accurate")) > NEAR:
            bounded = "bounded" if row["z"] < edges["stable"] else "neither"
            assert row["verdict"] == ("accurate" if row["z"] < edges["accurate"] else bounded), row


@EVERY
@pytest.mark.parametrize("zeta", DAMPING_RATIOS)
def test_a_long_run_dies_out_below_the_border_and_grows_above(oscillator, master, zeta):
    """To a tenth, or tenfold: as theory counts, that takes some hundred steps 5 % from the border."""
    limit = theory.stable_step(theory_of(master), *parameters(1.0, zeta, 1.0))
    for z, dies in ((limit * (1 - NEAR), True), (limit * (1 + NEAR), False)):
        growth = STEP * theory.growth(theory_of(master), *parameters(z, zeta), STEP)
        assert (growth < 0.0) == dies
        rows, failure = ran(oscillator, master, z, zeta, math.ceil(4.6 / abs(growth)) + 20)
        assert not failure
        sizes = np.linalg.norm(rows, axis=1)
        assert (sizes[-20:].max() < 0.1 * sizes[:20].max()) == dies
        assert (sizes[-20:].max() > 10 * sizes[:20].max()) == (not dies)


@EVERY
@pytest.mark.parametrize("zeta", DAMPING_RATIOS)
def test_a_run_is_accurate_below_the_border_and_not_above(oscillator, master, zeta):
    limit = theory.accurate_step(theory_of(master), *parameters(1.0, zeta, 1.0))
    for z, verdict in ((limit * (1 - NEAR), "accurate"), (limit * (1 + NEAR), "bounded")):
        assert cell(oscillator, master, z, zeta)["verdict"] == verdict


@EVERY
def test_without_a_damper_energy_grows_at_twice_the_rate_of_the_table(oscillator, master):
    """Mean of a swing late in the run over that of the first; the next term is some units times z^2."""
    power, factor = theory.UNDAMPED_GROWTH[theory_of(master)]
    z, count = 0.1, 1200
    rows, _ = ran(oscillator, master, z, 0.0, count)
    swing = round(2 * math.pi / z)
    energy = np.sum(rows**2, axis=1)
    found = math.log(energy[-swing:].mean() / energy[:swing].mean()) / (count + 1 - swing)
    # a swing is no whole number of steps: its mean is off by 1e-3 of what the energy varies
    assert found == pytest.approx(2 * factor * z ** (power + 1), rel=10 * z**2, abs=1e-7)


@EVERY
def test_growth_without_a_damper(coupled, master):
    rows = [row for row in coupled["undamped"] if row["master"] == master]
    power, factor = theory.UNDAMPED_GROWTH[theory_of(master)]
    for row in rows:
        assert row["growth"] == pytest.approx(row["theory"], abs=1e-7), row
    least = min(rows, key=lambda row: row["z"])
    assert least["growth"] == pytest.approx(factor * least["z"] ** power, rel=10 * least["z"] ** 2, abs=1e-7)


def light(gain):
    """z at which iteration has this gain, z^2 / 6 + zeta z, and zeta."""
    return 3 * (math.sqrt(0.01 + gain * 2 / 3) - 0.1), 0.1


def test_sweeps_of_a_plain_iteration_are_those_of_its_gain(oscillator):
    """Each falls by the gain: as many more as the logarithm is less; one sweep is the check."""
    few, many = (cell(oscillator, "iterated", *light(gain)) for gain in (0.2, 0.4))
    assert (few["gain"], many["gain"]) == (pytest.approx(0.2), pytest.approx(0.4))
    assert (many["sweeps"] - 1) / (few["sweeps"] - 1) == pytest.approx(math.log(0.2) / math.log(0.4), rel=0.1)


@pytest.mark.parametrize("gain", [0.9, 1.1, 3.0, 45.0])
def test_relaxed_an_iteration_solves_one_mode_in_few_sweeps_on_both_sides_of_gain_1(oscillator, gain):
    assert cell(oscillator, "iterated", *light(gain))["sweeps"] < 5.0


def test_an_iteration_does_not_settle_where_the_least_relaxation_is_too_much(oscillator):
    assert theory.relaxed_gain([RELAXED_GAIN], 0.02) == pytest.approx(1.0)
    gain = 1.05 * RELAXED_GAIN
    assert cell(oscillator, "iterated", *light(gain))["verdict"] == "did not settle"
    assert cell(oscillator, "newton", *light(gain))["verdict"] != "did not settle"
