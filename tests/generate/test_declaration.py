"""What is wrong in a unit.toml is refused, with a message that names the file, the variable and what is wrong."""

import pytest
from generated import declaration, each_unit

from ulna.generate.declaration import DeclarationError, load

GOOD = """
name = "Toy"
description = "A toy"
kinds = ["co-simulation"]
sources = ["unit.c"]

[terminal]
plug = "A frame"

[enumeration.Mode]
plain = "As it is"
doubled = "Twice"

[structural]
count = { type = "UInt64", start = 4, min = 1, description = "How many" }

[parameter]
gain = { unit = "kg.m2", start = 2.0, min = 0.0, description = "Gain" }
mode = { enumeration = "Mode", start = "doubled", description = "Mode" }

[input]
force = { unit = "N", size = 3, rate = true, terminal = "plug.force", description = "Force" }

[output.position]
unit = "m"
size = 3
state = true
derivative_depends = ["force@"]
description = "Position"

[output.energy]
unit = "J"
depends = ["position", "force"]
description = "Energy"

[local.points]
type = "Float32"
size = [3, "count"]
stream = true
description = "Points"
"""

SURFACE = """
[input.surface]
size = ["count"]
description = "Surface"
"""

TICK = """
[input.tick]
type = "Clock"
description = "Tick"
"""

# What is changed in the good one, into what, and the words that the message must hold.
WRONG = {
    "unknown key": ('"Gain"', '"Gain", colour = "red"', r"parameter\.gain.*unknown key colour.*known:.*unit"),
    "unknown type": ("start = 2.0", 'type = "Float16"', r"parameter\.gain.*Float16.*Float64"),
    "unknown unit": ('"kg.m2"', '"lbf"', r"parameter\.gain.*lbf.*known:.*kg"),
    "unit that is not SI": ('"N"', '"kN"', r"input\.force.*kN"),
    "two slashes": ('"kg.m2"', '"m/s/s"', r"parameter\.gain.*more than one slash"),
    "no description": ('description = "Gain"', 'description = ""', r"parameter\.gain.*description"),
    "start of another length": (
        "size = 3, rate",
        "size = 3, start = [1.0, 2.0], rate",
        r"input\.force.*2 values for 3",
    ),
    "unknown enumeration": ('enumeration = "Mode"', 'enumeration = "Mood"', r"parameter\.mode.*Mood"),
    "unknown entry": ('start = "doubled"', 'start = "tripled"', r"parameter\.mode.*tripled"),
    "dependency on a parameter": ('["position", "force"]', '["gain"]', r"energy.*'gain'.*no input and no state"),
    "dependency on nothing": ('["force@"]', '["farce@"]', r"der\(position\).*'farce@'.*no input and no state"),
    "dependency on itself": ('["position", "force"]', '["energy"]', r"energy.*'energy'.*no input and no state"),
    "terminal that is not listed": ('"plug.force"', '"plog.force"', r"force.*plog"),
    "size by what is no structural parameter": ('[3, "count"]', '[3, "gain"]', r"points.*gain.*structural parameter"),
    "size by nothing": ('[3, "count"]', '[3, "cuont"]', r"points.*cuont.*structural parameter"),
    "array sized by a structural parameter": ("stream = true\n", "", r"local\.points.*only a stream"),
    "array sized by two": ('[3, "count"]', '["count", "count"]', r"local\.points.*more than one dimension"),
    "array that starts at a value": (
        "\n[local.points]",
        f"{SURFACE}start = 1.0\n[local.points]",
        r"input\.surface.*starts at zero",
    ),
    "array without a largest size": ("\n[local.points]", f"{SURFACE}[local.points]", r"surface.*'count'.*have a max"),
    "array of no element": ("start = 4, min = 1", "start = 0, min = 0", r"points.*'count'.*starts at 1 or more"),
    "size by no UInt64": ('"UInt64", start = 4', '"Int32", start = 4', r"points.*'count'.*UInt64"),
    "array that would be differentiated": (
        'sources = ["unit.c"]\n',
        'sources = ["unit.c"]\ndirectional_derivatives = true\n[input.surface]\nsize = ["count"]\n'
        'description = "Surface"\n',
        r"surface.*no directional derivative",
    ),
    "clock of no interval": (
        "\n[local.points]",
        f"{TICK}[local.points]",
        r"input\.tick.*Clock, of no interval.*countdown",
    ),
    "clock of a wrong interval": (
        "\n[local.points]",
        f'{TICK}interval = "daily"\n[local.points]',
        r"input\.tick.*Clock, of no interval.*triggered",
    ),
    "clock that is an output": (
        "\n[local.points]",
        f'{TICK}interval = "triggered"\n[local.points]'.replace("input.tick", "output.tick"),
        r"output\.tick.*no scalar input",
    ),
    "array of clocks": (
        "\n[local.points]",
        f'{TICK}interval = "triggered"\nsize = 3\n[local.points]',
        r"input\.tick.*no scalar input",
    ),
    "clock of a unit without events": (
        "\n[local.points]",
        f'{TICK}interval = "triggered"\n[local.points]',
        r"tick is a Clock, but the unit has no events",
    ),
    "interval of no clock": ('"Gain"', '"Gain", interval = "countdown"', r"parameter\.gain.*no Clock"),
    "text that is no TOML": ('name = "Toy"', "name = Toy", r"Invalid value"),
    "no name": ('name = "Toy"', 'name = ""', r"name is missing"),
    "no description of the unit": ('description = "A toy"', 'description = ""', r"description is missing"),
    "unknown top key": ('name = "Toy"', 'name = "Toy"\ncolour = "red"', r"key 'colour' is none of.*name"),
    "unknown kind": ('["co-simulation"]', '["cosimulation"]', r"kind 'cosimulation'.*co-simulation, model-exchange"),
    "unknown variability": ('"Gain"', '"Gain", variability = "often"', r"parameter\.gain.*variability.*tunable"),
    "name declared twice": ("gain = {", 'force = { description = "Twice" }\ngain = {', r"force is declared twice"),
    "start outside the limits": ("start = 2.0", "start = -2.0", r"parameter\.gain.*outside its limits"),
    "min above max": ("min = 0.0", "min = 3.0, max = 1.0", r"parameter\.gain.*min above its max"),
    "element by element between sizes": ('["position", "force"]', '["force@"]', r"energy.*'force@'.*sizes differ"),
    "input that is a state": ("size = 3, rate = true", "size = 3, state = true", r"input\.force.*no Float64 output"),
    "stream that is an output": ("[local.points]", "[output.points]", r"output\.points.*stream.*not local"),
    "quaternion with a size": ("size = 3, rate", "quaternion = true, size = 3, rate", r"force.*quaternion and size"),
    "enumeration with a type": ('"doubled",', '"doubled", type = "Int32",', r"mode.*enumeration and type"),
    "fraction of a whole number": ("start = 4,", "start = 4.5,", r"structural\.count.*no whole number"),
    "dimension of nothing": ("size = 3, rate", "size = 0, rate", r"input\.force.*dimension below 1"),
    "limit in words": ("min = 0.0", 'min = "none"', r"parameter\.gain.*no number"),
    "name that C keeps": ("gain = {", "double = {", r"parameter\.double.*field in C"),
    "slope without a spelling": ('unit = "N", size', 'unit = "N/s", size', r"input\.force.*add it to the table"),
}


@pytest.fixture
def loaded(tmp_path):
    """`loaded(text)` reads a declaration from a file."""

    def read(text):
        path = tmp_path / "unit.toml"
        path.write_text(text)
        return load(path)

    return read


@pytest.mark.parametrize("mistake", WRONG)
def test_a_wrong_declaration_is_refused_with_a_reason(loaded, tmp_path, mistake):
    old, new, message = WRONG[mistake]
    assert GOOD.count(old) == 1
    with pytest.raises(DeclarationError, match=message) as refusal:
        loaded(GOOD.replace(old, new))
    assert str(tmp_path / "unit.toml") in str(refusal.value)


def test_a_good_declaration_is_read_whole(loaded):
    unit = loaded(GOOD)
    names = ["time", "count", "gain", "mode", "force", "force_rate", "position", "der(position)", "energy", "points"]
    assert [v.name for v in unit.variables] == names
    assert [v.reference for v in unit.variables] == [0, 1, 2, 3, 4, 7, 10, 13, 16, 17]
    assert unit.by_name("mode").start == (2,)
    assert unit.by_name("force_rate").unit == "N/s"
    assert unit.by_name("der(position)").unit == "m/s"
    assert unit.by_name("der(position)").depends == ("force@",)
    assert unit.by_name("points").fmi == (3,)
    assert unit.groups == ["derivatives", "outputs"]
    assert unit.by_name("force_rate").terminal == ("plug.force_rate",)


def test_a_countdown_clock_brings_what_is_remembered_of_it(loaded):
    clock = f'{TICK}interval = "countdown"\n[local.points]'
    unit = loaded(GOOD.replace("\n[local.points]", clock).replace("kinds =", "events = true\nkinds ="))
    place = unit.variables.index(unit.by_name("tick"))
    rows = unit.variables[place : place + 3]
    assert [v.name for v in rows] == ["tick", "tick_tick", "tick_interval"]
    assert [v.causality for v in rows] == ["input", "memory", "memory"]
    assert unit.by_name("tick").fmi == (3,)


@each_unit
def test_value_references_count_the_scalars(name):
    """So that one number finds an element in FMI 2 and its array in FMI 3."""
    expected = 0
    for variable in declaration(name).variables:
        assert variable.reference == expected
        changes_size = any(isinstance(extent, str) for extent in variable.size)
        expected += 1 if variable.stream or changes_size else variable.count


@each_unit
def test_start_values_are_within_their_limits(name):
    for v in declaration(name).variables:
        for start in v.start or ():
            assert v.min is None or start >= v.min, v.name
            assert v.max is None or start <= v.max, v.name
