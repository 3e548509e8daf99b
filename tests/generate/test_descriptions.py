"""Both model descriptions say what the declaration says, and each other's: units, arrays, terminals, dependencies."""

from collections import defaultdict

import pytest
from generated import declaration, description, each_unit, each_version, stem, terminals

from ulna.generate.units import BASE, exponents, per_second

# The product of the base units that each unit of the project stands for, written out by hand.
SI = {
    "1": {},
    "m": {"m": 1},
    "kg": {"kg": 1},
    "s": {"s": 1},
    "rad": {"rad": 1},
    "K": {"K": 1},
    "Hz": {"s": -1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "m/s3": {"m": 1, "s": -3},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "rad/s3": {"rad": 1, "s": -3},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N/s": {"kg": 1, "m": 1, "s": -3},
    "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.m/s": {"kg": 1, "m": 2, "s": -3},
    "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N.m.s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
    "J": {"kg": 1, "m": 2, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "kg.m/s": {"kg": 1, "m": 1, "s": -1},
    "kg.m2": {"kg": 1, "m": 2},
    "kg.m2/s": {"kg": 1, "m": 2, "s": -1},
    "1/s": {"s": -1},
    "dB/m": {"m": -1},
}
SECOND = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "Enumeration": "Enumeration"}


def variables(name, version):
    """(name, type, attributes) of every variable, in order; in FMI 2 the attributes of the type belong to it."""
    for element in description(name, version).find("ModelVariables"):
        if version == 2:
            yield element.get("name"), SECOND[element[0].tag], {**element.attrib, **element[0].attrib}
        else:
            yield element.get("name"), element.tag, {**element.attrib, "sizes": [d.get("start") for d in element]}


@each_unit
@each_version
def test_every_number_has_a_unit_that_is_defined_by_si_base_units(name, version):
    defined = {unit.get("name"): unit.find("BaseUnit") for unit in description(name, version).iter("Unit")}
    for variable, kind, attributes in variables(name, version):
        if kind in ("Float64", "Float32"):
            assert attributes["unit"] in defined, variable
    for unit, base in defined.items():
        if unit == "dB":  # a logarithm has no factor to a base unit
            assert base is None
            continue
        assert set(base.attrib) <= set(BASE)
        assert {symbol: int(power) for symbol, power in base.attrib.items()} == SI[unit]


@pytest.mark.parametrize("unit", SI)
def test_units_are_read_as_si_says(unit):
    assert exponents(unit) == SI[unit]


@pytest.mark.parametrize("unit", ["mm", "kg m", "m/s/s", "m^2", "", "N.", "deg", "Kg"])
def test_a_unit_that_is_not_si_is_refused(unit):
    with pytest.raises(ValueError, match="unit"):
        exponents(unit)


@pytest.mark.parametrize(
    "unit", ["m", "m/s", "m/s2", "rad", "rad/s", "rad/s2", "1", "kg.m/s", "kg.m2/s", "N", "N.m", "K"]
)
def test_a_slope_has_one_second_less(unit):
    powers = {symbol: exponents(unit).get(symbol, 0) - (symbol == "s") for symbol in BASE}
    assert exponents(per_second(unit)) == {symbol: power for symbol, power in powers.items() if power}


@each_unit
def test_every_array_of_fmi_3_is_written_out_in_fmi_2(name):
    """Names, types, value references, starts, limits, units, descriptions: element k of the one is k of the other."""
    scalars = {variable: (kind, attributes) for variable, kind, attributes in variables(name, 2)}
    absent = {v.name for v in declaration(name).variables if 2 not in v.fmi}
    structural = {variable for variable, _, attributes in variables(name, 3) if "structural" in attributes["causality"]}
    for variable, kind, attributes in variables(name, 3):
        sizes = attributes["sizes"]
        if variable in absent or attributes["causality"] == "independent":
            continue
        count = 1
        for size in sizes:
            count *= int(size)
        if not sizes:
            names = [variable]
        elif variable.startswith("der("):
            names = [f"{variable[:-1]}[{k}])" for k in range(1, count + 1)]
        else:
            names = [f"{variable}[{k}]" for k in range(1, count + 1)]
        for k, scalar in enumerate(names):
            other_kind, other = scalars.pop(scalar)
            assert other_kind == ("Int32" if kind == "UInt64" else kind)
            assert int(other["valueReference"]) == int(attributes["valueReference"]) + k
            same = ["description", "unit", "declaredType"]
            if variable not in structural:
                same += ["causality", "variability", "min", "max"]
            assert {key: other.get(key) for key in same} == {key: attributes.get(key) for key in same}
            starts = attributes.get("start", "").split()
            assert other.get("start") == (starts[k] if starts else None)
    assert scalars == {}


@each_unit
def test_a_structural_parameter_is_a_constant_in_fmi_2(name):
    fixed = {variable: attributes for variable, _, attributes in variables(name, 2)}
    for variable, _, attributes in variables(name, 3):
        if attributes["causality"] == "structuralParameter" and 2 in declaration(name).by_name(variable).fmi:
            assert fixed[variable]["variability"] == "constant"
            assert fixed[variable]["start"] == attributes["start"]


def unknowns(name, version):
    """(kind, name) of every output and state derivative -> names of what it depends on."""
    root = description(name, version).find("ModelStructure")
    if version == 2:
        known = {str(i): variable for i, (variable, _, _) in enumerate(variables(name, 2), 1)}
        paths, key = {"output": "Outputs/Unknown", "derivative": "Derivatives/Unknown"}, "index"
    else:
        known = {attributes["valueReference"]: variable for variable, _, attributes in variables(name, 3)}
        paths, key = {"output": "Output", "derivative": "ContinuousStateDerivative"}, "valueReference"
    return {
        (kind, known[item.get(key)]): {known[dependency] for dependency in item.get("dependencies").split()}
        for kind, path in paths.items()
        for item in root.iterfind(path)
    }


@each_unit
def test_dependencies_of_arrays_are_those_of_their_elements(name):
    gathered = defaultdict(set)
    for (kind, unknown), known in unknowns(name, 2).items():
        gathered[kind, stem(unknown)] |= {stem(item) for item in known}
    assert dict(gathered) == unknowns(name, 3)
    assert gathered


@each_unit
@each_version
def test_terminals_hold_variables_that_exist_and_members_that_differ(name, version):
    known = {variable for variable, _, _ in variables(name, version)}
    for terminal in terminals(name, version).iter("Terminal"):
        members = [member.attrib for member in terminal.iter("TerminalMemberVariable")]
        assert members, terminal.get("name")
        assert {member["variableName"] for member in members} <= known
        assert len({member["memberName"] for member in members}) == len(members)
        assert terminal.get("description")


@each_unit
@each_version
def test_every_variable_is_described(name, version):
    assert all(attributes.get("description") for _, _, attributes in variables(name, version))
    assert description(name, version).get("description")
