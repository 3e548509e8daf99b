"""What the shared library shows: every function of the standard, and nothing else; what is not supported says so."""

import subprocess
from ctypes import CDLL, addressof, c_double, c_int, c_size_t, c_void_p, create_string_buffer

import pytest
from importer_cases import each_unit, each_version, extract, library, standard_functions

from ulna import Slave

# What no unit can do, with the arguments after the instance: p memory, n a count or reference of one, e an
# enumeration or reference of zero, t a time.
UNSUPPORTED = {
    "2.0": {
        "fmi2GetString": "pnp",
        "fmi2SetString": "pnp",
        "fmi2GetRealOutputDerivatives": "pnpp",
        "fmi2CancelStep": "",
        "fmi2GetStatus": "ep",
        "fmi2GetIntegerStatus": "ep",
        "fmi2GetStringStatus": "ep",
    },
    "3.0": {
        "fmi3GetString": "pnpn",
        "fmi3SetString": "pnpn",
        "fmi3GetBinary": "pnppn",
        "fmi3SetBinary": "pnppn",
        "fmi3GetClock": "pnp",
        "fmi3SetClock": "pnp",
        "fmi3GetIntervalDecimal": "pnpp",
        "fmi3GetIntervalFraction": "pnppp",
        "fmi3GetShiftDecimal": "pnp",
        "fmi3GetShiftFraction": "pnpp",
        "fmi3SetIntervalDecimal": "pnp",
        "fmi3SetIntervalFraction": "pnpp",
        "fmi3SetShiftDecimal": "pnp",
        "fmi3SetShiftFraction": "pnpp",
        "fmi3ActivateModelPartition": "et",
        "fmi3GetOutputDerivatives": "pnppn",
        "fmi3GetNumberOfVariableDependencies": "np",
        "fmi3GetVariableDependencies": "nppppn",
    },
}


@each_unit
@each_version
def test_exactly_the_functions_of_the_standard_are_exported(name, version, tmp_path):
    path = library(extract(name, version, tmp_path), name)
    listed = subprocess.run(["nm", "-D", "--defined-only", str(path)], check=True, capture_output=True, text=True)
    exported = {line.split()[2] for line in listed.stdout.splitlines()}
    assert exported == set(standard_functions(version))
    loaded = CDLL(str(path))
    assert all(hasattr(loaded, function) for function in exported)


@each_unit
@pytest.mark.parametrize(
    ("version", "function"), [(version, function) for version, calls in UNSUPPORTED.items() for function in calls]
)
def test_an_unsupported_function_fails_says_so_and_does_no_harm(name, version, function):
    memory = create_string_buffer(64)
    values = {"p": c_void_p(addressof(memory)), "n": c_size_t(1), "e": c_int(0), "t": c_double(0.0)}
    with Slave(name, version=version) as unit:
        unit.initialize()
        arguments = [values[kind] for kind in UNSUPPORTED[version][function]]
        assert unit.function(function)(c_void_p(unit.component), *arguments) == 3
        assert function in unit.messages.take_errors()
        unit.step(0.0, 0.01)
