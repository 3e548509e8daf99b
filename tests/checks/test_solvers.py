"""Whole steps: series are right, a wrong declaration is found, and the READMEs declare what is judged."""

import re
import tempfile
from dataclasses import replace
from math import comb, factorial
from pathlib import Path
from types import SimpleNamespace

import casadi as ca
import pytest
from casadi import SX
from mpmath import mp, mpf

from ulna import fmu
from ulna.bench.measuring import choices
from ulna.checks.graph import UnsupportedError, graph_of, run
from ulna.checks.lift import LiftError, extract
from ulna.checks.paths import trace_steps
from ulna.checks.series import SPARE, Series, flow
from ulna.checks.solvers import cases_of, of_solvers
from ulna.checks.textbook import load_model

REPOSITORY = Path(__file__).parents[2]
MODELS = {"RigidBody": load_model("rigid_body"), "HingedBody": load_model("hinged_body")}
x = SX.sym("x")

SERIES = {
    "a quotient": (1 / (1 - x), lambda n: 1),
    "a polynomial": ((1 + x) ** 2 - x * x, lambda n: (1, 2)[n] if n < 2 else 0),
    "a root": (ca.sqrt(1 + 4 * x), lambda n: mpf((-1) ** (n + 1) * comb(2 * n, n)) / (2 * n - 1)),
    "an exponential": (ca.exp(-x), lambda n: mpf((-1) ** n) / factorial(n)),
    "a sine": (ca.sin(2 * x), lambda n: mpf((-1) ** (n // 2) * 2**n) / factorial(n) if n % 2 else 0),
    "a cosine": (ca.cos(x), lambda n: 0 if n % 2 else mpf((-1) ** (n // 2)) / factorial(n)),
    "a turn that does not divide by zero": (
        ca.sin(ca.sqrt(x * x + 1e-300)) / ca.sqrt(x * x + 1e-300),
        lambda n: 0 if n % 2 else mpf((-1) ** (n // 2)) / factorial(n + 1),
    ),
}


@pytest.mark.parametrize("name", SERIES)
def test_series_are_those_of_the_functions(name):
    expression, coefficient = SERIES[name]
    with mp.workdps(50):
        [found] = run(graph_of(expression), Series(8, SPARE), [[mpf(0), mpf(1)]])
        found += [mpf(0)] * 8
        assert max(abs(found[n] - coefficient(n)) for n in range(9)) < mpf(10) ** -48


def test_what_has_no_series_here_is_refused():
    with pytest.raises(UnsupportedError, match="fabs"):
        run(graph_of(ca.fabs(x)), Series(3), [[mpf(1), mpf(1)]])


def test_the_flow_of_an_oscillator_is_cosine_and_minus_sine():
    place, speed = SX.sym("place"), SX.sym("speed")
    found = flow([(place, speed), (speed, -place)], {"place": mpf(1), "speed": mpf(0)}, 9)
    signs = [1, 0, -1, 0]
    assert [round(c * factorial(n)) for n, c in enumerate(found["place"])] == [signs[n % 4] for n in range(10)]
    assert [round(c * factorial(n)) for n, c in enumerate(found["speed"])] == [-signs[(n - 1) % 4] for n in range(10)]


def declared(unit, solver, **changes):
    """A model of which one solver is left, declared otherwise than it is."""
    model = MODELS[unit]
    table = {solver: replace(model.SOLVERS[solver], **changes)}
    return SimpleNamespace(**{name: getattr(model, name) for name in model.__all__} | {"SOLVERS": table}, __name__=unit)


def failed(unit, model):
    with tempfile.TemporaryDirectory() as scratch:
        cases = cases_of(extract(fmu(unit), scratch), model)
    return [row.claim for row in of_solvers(unit, model, cases) if not row.holds]


@pytest.mark.parametrize("order", [1, 3, None, float("inf")])
def test_an_order_that_is_not_the_solvers_is_found(order):
    orders = {"free": order, "loaded": 2}
    found = failed("RigidBody", declared("RigidBody", "midpoint", orders=orders))
    assert any("midpoint, without torque" in claim for claim in found)
    assert not any("with torques" in claim for claim in found)


def test_what_a_solver_is_said_to_keep_and_loses_is_found_and_the_other_way_round():
    model = MODELS["HingedBody"]
    quantities = set(model.QUANTITIES)
    kept = model.SOLVERS["semi_implicit_euler"].keeps
    found = failed("HingedBody", declared("HingedBody", "semi_implicit_euler", keeps=quantities - kept))
    assert len(found) == len(quantities) == 2


def test_the_attitude_of_moser_veselov_is_no_poisson_map_though_its_momentum_is():
    keeps = MODELS["RigidBody"].SOLVERS["splitting"].keeps | MODELS["RigidBody"].SOLVERS["moser_veselov"].keeps
    [found] = failed("RigidBody", declared("RigidBody", "moser_veselov", keeps=keeps))
    assert "orientation and angular momentum" in found


def test_a_step_that_the_unit_refuses_has_no_path(tmp_path):
    case = {"h": [1.0], "solver_step": [1e-12], "mass": [1.0], "inertia": [1.0, 1.0, 1.0], "orientation": [1, 0, 0, 0]}
    with pytest.raises(LiftError, match="divides a step"):
        trace_steps(extract(fmu("RigidBody"), tmp_path), ["midpoint"], ["orientation"], {"refused": case})


@pytest.mark.parametrize("unit", MODELS)
def test_every_solver_of_a_unit_is_declared(unit):
    assert list(MODELS[unit].SOLVERS) == list(choices(unit, "solver"))


@pytest.mark.parametrize("unit", MODELS)
def test_the_readme_gives_the_declared_orders(unit):
    model = MODELS[unit]
    text = (REPOSITORY / "fmus" / model.__name__.rpartition(".")[2] / "README.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| ([\d, ]+) \|", text, re.MULTILINE)
    assert len(rows) > 2
    for solver, orders in rows:
        numbers = list(model.SOLVERS[solver].orders.values())
        assert [int(n) for n in orders.split(",")] in (numbers, numbers[:1])
