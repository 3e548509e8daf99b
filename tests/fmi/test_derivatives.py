"""Directional and adjoint derivatives against differences of the values themselves."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from raw import (
    DECLARATIONS,
    DIFFERENTIABLE,
    MODEL_EXCHANGE,
    ROUND_OFF,
    VERSIONS,
    WITH_STATES,
    Raw,
    Variable,
    set_random_inputs,
)

STEP = 1e-3
NOT_DIFFERENTIABLE = {"fold_fraction"}  # a count over a count: its derivative is zero or none
WITH_WORKSPACE = {name for name in DIFFERENTIABLE if "workspace" in DECLARATIONS[name]}
HELD = {"axis", "solver_step", "tolerance"}  # of unit length within 1e-9; at their least: no room for a difference
GENERIC = {
    "RigidBody": {"inertia": [2.0, 2.5, 3.0], "initial_orientation": [0.9, 0.1, -0.3, 0.2]},
    "HingedBody": {"inertia": [0.05, 0.06, 0.07], "axis": [0.6, 0.0, 0.8], "friction": 0.5},
    "CompliantJoint": {"axis": [0.6, 0.0, 0.8], "friction": 0.5},
}


def read(unit: Raw, unknowns: list[Variable]) -> np.ndarray:
    return np.concatenate([unit.get(variable.name) for variable in unknowns])


def unknowns_of(unit: Raw) -> list[Variable]:
    return [v for v in (*unit.reals("output"), *unit.reals("local")) if v.name not in NOT_DIFFERENTIABLE]


def generic(unit: Raw, name: str) -> Raw:
    """Parameters and inputs without symmetry, in initialization mode."""
    random = np.random.default_rng(5)
    unit.begin()
    for parameter, value in GENERIC.get(name, {}).items():
        unit.set(parameter, value)
    for parameter in unit.reals("parameter"):
        if parameter.name.startswith("initial_") and "orientation" not in parameter.name:
            unit.set(parameter.name, random.uniform(-1, 1, parameter.size))
    set_random_inputs(unit, random)
    return unit


def assert_is_difference(exact: np.ndarray, at) -> None:
    """`exact` is the derivative of the vector `at(s)` by s at 0.

    Of two central differences at h and h / 2 the second has a truncation error of a third of what
    parts them (order 2), which bounds it three times over; round-off of values f is 8 roundings of
    the largest of them over h. `at(0)` is left set.
    """
    coarse = (at(STEP) - at(-STEP)) / (2 * STEP)
    fine = (at(STEP / 2) - at(-STEP / 2)) / STEP
    round_off = 8 * ROUND_OFF * max(1.0, np.abs(at(0.0)).max()) / (STEP / 2)
    excess = np.abs(exact - fine) - np.abs(fine - coarse) - round_off
    assert excess.max() <= 0.0, f"element {excess.argmax()}: {exact[excess.argmax()]} != {fine[excess.argmax()]}"


def check_settable(unit: Raw, knowns: list[Variable], random: np.random.Generator) -> None:
    """Along a random direction of each of the knowns alone, and of all together."""
    unknowns = unknowns_of(unit)
    start = {known.name: unit.get(known.name) for known in knowns}
    for group in (*([known] for known in knowns), knowns):
        seeds = {known.name: random.uniform(-1, 1, known.size) for known in group}

        def at(s, group=group, seeds=seeds):
            for known in group:
                unit.set(known.name, start[known.name] + s * seeds[known.name])
            return read(unit, unknowns)

        exact = unit.directional(unknowns, group, np.concatenate(list(seeds.values())))
        assert_is_difference(exact, at)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", DIFFERENTIABLE)
def test_derivatives_by_inputs_are_their_differences(name, version):
    with Raw(name, version) as unit:
        generic(unit, name).exitInitializationMode()
        check_settable(unit, unit.reals("input"), np.random.default_rng(6))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", sorted(set(DIFFERENTIABLE) - WITH_WORKSPACE))
def test_derivatives_by_parameters_in_initialization_are_their_differences(name, version):
    with Raw(name, version) as unit:
        generic(unit, name)
        knowns = [v for v in unit.reals("parameter") if v.name not in HELD]
        check_settable(unit, knowns, np.random.default_rng(7))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", WITH_STATES)
def test_derivatives_by_states_are_their_differences(name, version):
    random = np.random.default_rng(8)
    with Raw(name, version, MODEL_EXCHANGE) as unit:
        generic(unit, name).exitInitializationMode()
        unit.enterContinuousTimeMode()
        knowns = [v for v in unit.reals("output") if f"der({v.name})" in unit.variables]
        assert sum(v.size for v in knowns) == unit.states
        unknowns = [v for v in unknowns_of(unit) if v not in knowns]
        states = unit.get_states()
        for direction in (*np.eye(unit.states), *random.uniform(-1, 1, (5, unit.states))):

            def at(s, direction=direction):
                unit.set_states(states + s * direction)
                return read(unit, unknowns)

            assert_is_difference(unit.directional(unknowns, knowns, direction), at)


@pytest.mark.parametrize("name", DIFFERENTIABLE)
def test_both_versions_give_the_same_derivatives_to_the_bit(name):
    found = []
    for version in VERSIONS:
        with Raw(name, version) as unit:
            knowns = generic(unit, name).reals("input")
            seed = np.random.default_rng(9).uniform(-1, 1, sum(v.size for v in knowns))
            found.append(unit.directional(unknowns_of(unit), knowns, seed))
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("initializing", [False, True])
@pytest.mark.parametrize("name", DIFFERENTIABLE)
def test_adjoint_derivatives_are_the_transpose(name, initializing):
    random = np.random.default_rng(10)
    with Raw(name, "3.0") as unit:
        knowns = generic(unit, name).reals("input")
        if initializing and name not in WITH_WORKSPACE:
            knowns = knowns + unit.reals("parameter")
        if not initializing:
            unit.exitInitializationMode()
        unknowns = unknowns_of(unit)
        columns = np.eye(sum(v.size for v in knowns))
        jacobian = np.array([unit.directional(unknowns, knowns, column) for column in columns]).T
        assert np.count_nonzero(jacobian) > 10
        for _ in range(3):
            seed = random.uniform(-1, 1, len(jacobian))
            # a sum of n products is off by n roundings of the sum of their sizes (Higham 2002, 3.1)
            bound = len(seed) * ROUND_OFF * (np.abs(seed) @ np.abs(jacobian))
            assert np.all(np.abs(unit.adjoint(unknowns, knowns, seed) - seed @ jacobian) <= bound)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", DIFFERENTIABLE)
def test_a_derivative_leaves_the_values_as_they_were(name, version):
    with Raw(name, version) as unit, Raw(name, version) as twin:
        for instance in (unit, twin):
            generic(instance, name).exitInitializationMode()
        knowns = unit.reals("input")
        unit.directional(unknowns_of(unit), knowns, np.ones(sum(v.size for v in knowns)))
        unit.doStep(0.0, 0.01)
        twin.doStep(0.0, 0.01)
        assert unit.outputs() == twin.outputs()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_fixed_parameter_is_no_known_after_initialization(version):
    with Raw("RigidBody", version) as body:
        body.start()
        mass = [body.variables["mass"]]
        with pytest.raises(FMICallException):
            body.directional([body.variables["velocity"]], mass, np.ones(1))
        assert "mass" in body.log[-1][2]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", sorted(WITH_WORKSPACE))
def test_a_parameter_that_shapes_a_workspace_is_no_known_since_that_is_not_differentiated(name, version):
    with Raw(name, version) as unit:
        generic(unit, name)
        for parameter in unit.reals("parameter"):
            with pytest.raises(FMICallException):
                unit.directional(unknowns_of(unit)[:1], [parameter], np.ones(1))
            assert parameter.name in unit.log[-1][2]


@pytest.mark.parametrize("version", VERSIONS)
def test_a_unit_without_continuous_outputs_says_so(version):
    with Raw("UltrasonicSensor", version) as sensor:
        sensor.start()
        with pytest.raises(FMICallException):
            sensor.directional([sensor.variables["distance"]], [sensor.variables["sphere_radius"]], np.ones(1))
        assert "continuous outputs" in sensor.log[-1][2]
