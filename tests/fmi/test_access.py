"""Reading and setting of variables, for all that the model description shows."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from raw import DECLARATIONS, UNITS, VERSIONS, WITH_STATES, Raw, random_values, set_random_inputs, variables_of

SETTABLE = ("parameter", "input")


def refusal(unit: Raw, call, *arguments) -> str:
    """The line that a refused call logs."""
    unit.log.clear()
    with pytest.raises(FMICallException):
        call(*arguments)
    return unit.log[-1][2]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_start_values_are_those_of_the_model_description(name, version):
    with Raw(name, version) as unit:
        unit.begin()
        for variable in unit.variables.values():
            if variable.start is not None:
                np.testing.assert_array_equal(unit.get(variable.name), variable.start, err_msg=variable.name)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_what_is_set_is_read_back_to_the_bit(name, version):
    random = np.random.default_rng(2)
    with Raw(name, version) as unit:
        unit.begin()
        for variable in (v for causality in SETTABLE for v in unit.of(causality)):
            values = random_values(variable, random)
            unit.set(variable.name, values)
            np.testing.assert_array_equal(unit.get(variable.name), values, err_msg=variable.name)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_many_variables_in_one_call_are_as_one_by_one(name, version):
    with Raw(name, version) as unit:
        unit.start()
        set_random_inputs(unit, np.random.default_rng(3))
        outputs = unit.reals("output")
        references = [reference for variable in outputs for reference in variable.references]
        if version == "2.0":
            together = unit.getReal(references)
        else:
            together = unit.getFloat64(references, sum(variable.size for variable in outputs))
        np.testing.assert_array_equal(together, np.concatenate([unit.get(variable.name) for variable in outputs]))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_limits_are_those_of_the_model_description_and_themselves_allowed(name, version):
    limited = 0
    with Raw(name, version) as unit:
        unit.begin()
        for variable in (v for causality in SETTABLE for v in unit.of(causality, "Real", "Float64")):
            for limit, beyond in ((variable.minimum, -np.inf), (variable.maximum, np.inf)):
                if limit is not None:
                    limited += 1
                    unit.set(variable.name, np.full(variable.size, limit))
                    wrong = np.full(variable.size, np.nextafter(limit, beyond))
                    line = refusal(unit, unit.set, variable.name, wrong)
                    assert variable.name in line
                    assert "allowed range" in line
                    np.testing.assert_array_equal(unit.get(variable.name), limit)
    assert limited > 2


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", [name for name in UNITS if "enumeration" in DECLARATIONS[name]])
def test_enumerations_take_their_entries_and_nothing_else(name, version):
    with Raw(name, version) as unit:
        unit.begin()
        enumerations = unit.of("parameter", "Enumeration")
        assert enumerations
        for variable in enumerations:
            count = int(refusal(unit, unit.set, variable.name, 0).rsplit(" ", 1)[1])
            for number in range(1, count + 1):
                unit.set(variable.name, number)
                assert unit.get(variable.name) == number
            for wrong in (-1, 0, count + 1, 2**31 - 1):
                assert variable.name in refusal(unit, unit.set, variable.name, wrong)
            assert unit.get(variable.name) == count


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_a_value_of_the_wrong_type_is_refused_with_the_right_one(name, version):
    with Raw(name, version) as unit:
        unit.start()
        variable = unit.reals("input")[0]
        reference, zeros = [variable.references[0]], [0] * (1 if version == "2.0" else variable.size)
        for suffix in (
            ("Integer", "Boolean") if version == "2.0" else ("Int32", "Int64", "UInt64", "Boolean", "Float32")
        ):
            for verb, arguments in (("get", () if version == "2.0" else (len(zeros),)), ("set", (zeros,))):
                line = refusal(unit, getattr(unit, verb + suffix), reference, *arguments)
                assert variable.name in line
                assert "Float64" in line
        for suffix in ("String",) if version == "2.0" else ("Int8", "UInt16", "String"):
            assert "type" in refusal(unit, getattr(unit, "get" + suffix), reference)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_what_the_unit_computes_cannot_be_set(name, version):
    with Raw(name, version) as unit:
        unit.start()
        for variable in (*unit.reals("output"), *unit.reals("local"), *unit.reals("independent")):
            assert variable.name in refusal(unit, unit.set, variable.name, np.zeros(variable.size))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", UNITS)
def test_a_fixed_parameter_cannot_be_set_after_initialization(name, version):
    with Raw(name, version) as unit:
        unit.start()
        for variable in unit.of("parameter"):
            if variable.variability == "fixed":
                assert variable.name in refusal(unit, unit.set, variable.name, variable.start)


@pytest.mark.parametrize("version", VERSIONS)
def test_booleans_and_integers_of_the_sensor_arrive(version):
    with Raw("UltrasonicSensor", version) as sensor:
        sensor.set("seed", 7)
        sensor.set("period", 0.0)
        sensor.start()
        assert sensor.get("seed") == 7
        sensor.doStep(0.0, 0.1)
        assert sensor.get("sequence") == 0
        sensor.set("trigger", True)
        assert sensor.get("trigger")
        sensor.doStep(0.1, 0.1)
        assert sensor.get("sequence") == 1
        assert not sensor.get("valid")


# Structural parameters and streams


def test_a_structural_parameter_is_set_in_configuration_mode_only():
    with Raw("ArmSkin", "3.0") as skin:
        assert "vertex_count" in refusal(skin, skin.set, "vertex_count", 1024)
        skin.enterConfigurationMode()
        assert "Configuration Mode" in refusal(skin, skin.set, "radius", 0.05)
        skin.set("vertex_count", 1024)
        assert "vertex_count" in refusal(skin, skin.set, "vertex_count", 31)
        skin.exitConfigurationMode()
        skin.start()
        assert skin.get("vertex_count") == 1024
        assert "vertex_count" in refusal(skin, skin.set, "vertex_count", 2048)


def test_a_count_that_makes_no_whole_rings_is_refused_with_the_nearest_two():
    with Raw("ArmSkin", "3.0") as skin:
        skin.enterConfigurationMode()
        skin.set("vertex_count", 1025)
        skin.exitConfigurationMode()
        skin.begin()
        line = refusal(skin, skin.exitInitializationMode)
        assert "vertex_count = 1025" in line
        assert "1024 and 1056" in line


@pytest.mark.parametrize("count", [512, 2048, 4096])
def test_a_stream_has_the_size_that_the_structural_parameter_says(count):
    with Raw("ArmSkin", "3.0") as skin:
        skin.enterConfigurationMode()
        skin.set("vertex_count", count)
        skin.exitConfigurationMode()
        skin.start()
        references = {name: list(skin.variables[name].references) for name in ("vertices", "triangles", "weights")}
        for wrong in (3 * count - 1, 3 * count + 1, 0):
            refusal(skin, skin.getFloat32, references["vertices"], wrong)
        vertices = np.reshape(skin.getFloat32(references["vertices"], 3 * count), (3, count))
        triangles = np.reshape(skin.getInt32(references["triangles"], 6 * count), (-1, 3))
        weights = np.array(skin.getFloat32(references["weights"], count))
        # at rest: along x from 0 to 0.7, less what the last rings cut off the round ends; across up to the radius
        assert vertices[0].min() == pytest.approx(0.0, abs=0.01)
        assert vertices[0].max() == pytest.approx(0.7, abs=0.01)
        assert np.hypot(vertices[1], vertices[2]).max() == pytest.approx(0.04, abs=1e-8)
        assert set(triangles[: 2 * count - 4].ravel()) == set(range(count))
        assert (weights.min(), weights.max()) == (0.0, 1.0)


def test_fmi_2_shows_the_count_as_a_constant_and_no_streams():
    variables = variables_of("ArmSkin", "2.0")
    assert variables["vertex_count"].variability == "constant"
    assert not {"vertices", "normals", "triangles", "weights"} & set(variables)
    with Raw("ArmSkin", "2.0") as skin:
        skin.begin()
        assert skin.get("vertex_count") == 2048
        refusal(skin, skin.set, "vertex_count", 1024)


# Slopes of inputs


def stepped(name: str, version: str, give_slope) -> dict[str, bytes]:
    """Outputs after a step on inputs with slopes that `give_slope(unit, input, slope)` sets."""
    random = np.random.default_rng(4)
    with Raw(name, version) as unit:
        unit.start()
        set_random_inputs(unit, random)
        for variable in unit.reals("input"):
            if f"{variable.name}_rate" in unit.variables:
                give_slope(unit, variable, random.uniform(-1, 1, variable.size))
        unit.doStep(0.0, 0.05)
        return unit.outputs()


@pytest.mark.parametrize("name", WITH_STATES)
def test_fmi_2_input_derivatives_are_the_rate_inputs(name):
    def by_derivative(unit, variable, slope):
        unit.setRealInputDerivatives(list(variable.references), [1] * variable.size, list(slope))

    def by_rate(unit, variable, slope):
        unit.set(f"{variable.name}_rate", slope)

    expected = stepped(name, "2.0", by_rate)
    assert stepped(name, "2.0", by_derivative) == expected
    assert stepped(name, "3.0", by_rate) == expected
    assert stepped(name, "2.0", lambda unit, variable, slope: None) != expected


@pytest.mark.parametrize("name", UNITS)
def test_fmi_2_input_derivatives_of_order_two_or_without_a_rate_are_refused(name):
    with Raw(name, "2.0") as unit:
        unit.start()
        variable = unit.reals("input")[0]
        for order in (0, 2):
            line = refusal(unit, unit.setRealInputDerivatives, [variable.references[0]], [order], [1.0])
            assert variable.name in line
        output = unit.reals("output")[0]
        refusal(unit, unit.setRealInputDerivatives, [output.references[0]], [1], [1.0])


@pytest.mark.parametrize("version", VERSIONS)
def test_a_force_with_a_slope_gives_its_exact_momentum(version):
    force, rate, h = np.array([1.0, -2.0, 3.0]), np.array([30.0, 10.0, -20.0]), 0.1
    with Raw("RigidBody", version) as body:
        body.set("gravity", np.zeros(3))
        body.start()
        body.set("force", force)
        if version == "2.0":
            body.setRealInputDerivatives(list(body.variables["force"].references), [1, 1, 1], list(rate))
        else:
            body.set("force_rate", rate)
        body.doStep(0.0, h)
        gained = force * h + rate * h**2 / 2
        # Runge-Kutta is exact for it: 100 internal steps of 4 roundings of numbers below 3
        np.testing.assert_allclose(body.get("linear_momentum"), gained, rtol=0, atol=400 * 3 * 2.2e-16 / 2)
