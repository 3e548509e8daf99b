"""All measurements of the map of couplings, as one table of plain numbers."""

import math
import platform
from collections.abc import Iterator
from typing import Any

import numpy as np

from . import coupling_theory as theory
from . import hinges
from .mobility import hinge_loop_gain, settling_mass_ratio
from .oscillator import MASSES, MASTERS, STEP, SWING, Oscillator, Run, factors, parameters, rate_error, seen, theory_of

COUNT = 60
"""Steps of a run from which its factors are taken."""
ACCURATE = 0.01
MARGIN = 1e-8
"""Of the log of a growth factor; it is known to a part of this where it is near 0."""
FASTER, MORE_DAMPED = (0.003, 10.0), (0.01, 10.0)
"""Ranges of z and of zeta."""
LIGHT = 0.1
"""Damping ratio of the runs that are stable but wrong."""
SHOWN = 0.1
"""z of the run that is drawn: there a jacobi of order 0 leaves 0.28 of the damping."""
SWINGS = 2
RELAXED_GAIN = 2 / 0.02 - 1
"""Gain at which even the least share of a change that `iterated` takes, .02, is too much: `relaxed_gain` is 1."""

Row = dict[str, Any]


def measure_coupling(quick: bool = False) -> dict[str, Any]:
    """Everything that the map shows: lists of rows by topic; coarser grids if `quick`."""
    zs = np.geomspace(*FASTER, 11 if quick else 29).tolist()
    zetas = np.geomspace(*MORE_DAMPED, 7 if quick else 19).tolist()
    lines = 13 if quick else 61
    elbows = np.radians(np.linspace(0, 180, 5 if quick else 13)).tolist()
    ratios = np.geomspace(0.1, 30.0, 6 if quick else 14).tolist()
    with Oscillator() as oscillator:
        return {
            "about": {
                "quick": quick,
                "machine": f"{platform.system()} {platform.machine()}",
                "masses": MASSES,
                "step": STEP,
                "accurate": ACCURATE,
                "damping_ratio": LIGHT,
            },
            "cells": [cell(oscillator, master, z, zeta) for master in MASTERS for zeta in zetas for z in zs],
            "borders": [border(master, zeta) for master in MASTERS for zeta in np.geomspace(*MORE_DAMPED, lines)],
            "undamped": list(_undamped(oscillator, np.geomspace(0.05, 1.0, 4 if quick else 9).tolist())),
            "loops": [loop(elbow, ratio) for elbow in elbows for ratio in ratios],
            "mass_ratios": [_mass_ratio(elbow) for elbow in elbows],
            "swings": list(_swings(oscillator)),
            "energies": list(_energies(oscillator, np.geomspace(0.003, 0.6, 4 if quick else 12).tolist())),
        }


def verdict(growth: float, error: float) -> str:
    """Of a run with this growth (log of the factor a step) and `rate_error`."""
    if growth > MARGIN:
        return "neither"
    return "accurate" if error <= ACCURATE else "bounded"


def cell(oscillator: Oscillator, master: str, z: float, zeta: float) -> Row:
    """One run, and what theory says of it: growth a step, and error of frequency and damping."""
    *masses, k, c = parameters(z, zeta)
    row: Row = {"master": master, "z": z, "zeta": zeta, "k": k, "c": c, "H": STEP}
    named = theory_of(master)
    row["theory_growth"] = STEP * theory.growth(named, *masses, k, c, STEP)
    row["theory_error"] = theory.rate_error(named, *masses, k, c, STEP)
    row["gain"] = theory.iteration_gain(*masses, k, c, STEP)
    run = oscillator.run(master, k, c, STEP, COUNT)
    if run.failure == "loop":
        return row | {"verdict": "did not settle", "growth": None, "error": None, "sweeps": None}
    rows = seen(run.distance())
    growth = math.log(np.abs(factors(rows)).max())
    error = rate_error(rows, k, c, STEP)
    summary = run.results.summary
    sweeps = summary["sweeps"] / summary["steps"] if "sweeps" in summary else None
    return row | {"verdict": verdict(growth, error), "growth": growth, "error": error, "sweeps": sweeps}


def border(master: str, zeta: float) -> Row:
    """Theory's borders in z for a damping ratio: up to which a master is stable, accurate, and iteration contracts."""
    oscillator = parameters(1.0, zeta, 1.0)
    named = theory_of(master)
    return {
        "master": master,
        "zeta": zeta,
        "stable": theory.stable_step(named, *oscillator),
        "accurate": theory.accurate_step(named, *oscillator, bound=ACCURATE),
        "iteration": theory.iteration_step(*oscillator),
    }


def _undamped(oscillator: Oscillator, zs: list[float]) -> Iterator[Row]:
    for master in MASTERS:
        for z in zs:
            *masses, k, c = parameters(z, 0.0)
            rows = seen(oscillator.run(master, k, c, STEP, 4 * COUNT).distance())
            growth = math.log(np.abs(factors(rows)).max()) / z
            expected = STEP * theory.growth(theory_of(master), *masses, k, c, STEP) / z
            yield {"master": master, "z": z, "growth": growth, "theory": expected}


def loop(elbow: float, ratio: float) -> Row:
    """The loop of two hinges: gain of a pass, whether passes settle, and errors of those masters that solve it."""
    mass = ratio * hinges.FELT
    moment = mass * (hinges.SLENDERNESS * hinges.LEVER) ** 2
    expected = hinge_loop_gain(hinges.UPPER_MOMENT, hinges.LENGTH, mass, hinges.LEVER, moment, elbow)
    gain, settled = hinges.measured_gain(ratio, elbow)
    row = {"elbow": elbow, "ratio": ratio, "gain": gain, "theory": -expected, "settled": settled}
    return row | {master: hinges.solution_error(master, ratio, elbow) for master in ("iterated", "newton")}


def _mass_ratio(elbow: float) -> Row:
    expected = settling_mass_ratio(hinges.SLENDERNESS, elbow)
    return {"elbow": elbow, "measured": hinges.border(elbow), "theory": expected}


def _swings(oscillator: Oscillator) -> Iterator[Row]:
    """Distance over time of runs that are stable but, some of them, wrong; "" is the true motion."""
    *masses, k, c = parameters(SHOWN, LIGHT)
    for master in ("jacobi_order_0", "gauss_seidel_order_0", "newton"):
        run = oscillator.run(master, k, c, STEP, math.ceil(SWINGS * 2 * math.pi / SHOWN))
        distance, times = run.distance(), run.results.time
        angle = times / STEP * SHOWN
        yield {"master": master, "angle": angle.tolist(), "distance": (distance[:, 0] / SWING).tolist()}
    rate, other = theory.true_rates(*masses, k, c)
    start = np.linalg.solve([[1.0, 1.0], [rate, other]], distance[0])
    true = (start @ np.exp(np.outer([rate, other], times))).real / SWING
    yield {"master": "", "angle": angle.tolist(), "distance": true.tolist()}


def created_energy(run: Run, k: float, c: float, H: float) -> float:
    """Energy (J) that came from nowhere until the last row but one, which is as far as the watch knows: what the bodies
    and the spring between them have gained, and the damper has taken, by Simpson's rule: for odd numbers of steps."""
    distance, rate = run.distance().T
    kinetic = run.results["first.kinetic_energy"] + run.results["second.kinetic_energy"]
    energy, power = kinetic + k * distance**2 / 2, c * rate**2
    lost = H / 3 * np.sum(power[:-3:2] + 4 * power[1:-2:2] + power[2:-1:2])
    return float(energy[-2] - energy[0] + lost)


def _energies(oscillator: Oscillator, zs: list[float]) -> Iterator[Row]:
    for master in MASTERS:
        for z in zs:
            *_, k, c = parameters(z, LIGHT)
            run = oscillator.run(master, k, c, STEP, 2 * math.ceil(SWINGS * math.pi / z) + 1)
            summary = run.results.summary
            yield {
                "master": master,
                "z": z,
                "created": created_energy(run, k, c, STEP),
                "watched": summary["coupling_energy"],
                "system": summary["system_energy"],
                "wrong": summary["wrong"],
                "warned": run.warned,
            }
