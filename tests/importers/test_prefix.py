"""Function prefixes of source FMUs (FMI 3): what they are there for is several units in one program."""

import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from importer_cases import HEADERS, UNITS, each_unit, extract, standard_functions

from ulna import Slave
from ulna.description import read_description
from ulna.paths import fmu as path_of

PLAIN = ("FMI3_OVERRIDE_FUNCTION_PREFIX",)
STEPS = 10

PROGRAM = """
#include <math.h>
#include <stdio.h>
#include "fmi3FunctionTypes.h"

static void say(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)e;
    fprintf(stderr, "%d %s: %s\\n", (int)status, category, message);
}

#define UNIT(NAME, TOKEN, OUTPUT, COUNT)                                                                        \\
    extern fmi3InstantiateCoSimulationTYPE NAME##_fmi3InstantiateCoSimulation;                                  \\
    extern fmi3EnterInitializationModeTYPE NAME##_fmi3EnterInitializationMode;                                  \\
    extern fmi3ExitInitializationModeTYPE NAME##_fmi3ExitInitializationMode;                                    \\
    extern fmi3DoStepTYPE NAME##_fmi3DoStep;                                                                    \\
    extern fmi3GetFloat64TYPE NAME##_fmi3GetFloat64;                                                            \\
    extern fmi3FreeInstanceTYPE NAME##_fmi3FreeInstance;                                                        \\
    static int run_##NAME(void)                                                                                 \\
    {                                                                                                           \\
        fmi3ValueReference output = OUTPUT;                                                                     \\
        fmi3Float64 values[COUNT], last;                                                                        \\
        fmi3Boolean event, terminate, early;                                                                    \\
        int bad = 0;                                                                                            \\
        fmi3Instance it = NAME##_fmi3InstantiateCoSimulation("it", TOKEN, NULL, fmi3False, fmi3False, fmi3False, \\
                                                             fmi3False, NULL, 0, NULL, say, NULL);              \\
        bad |= !it || NAME##_fmi3EnterInitializationMode(it, fmi3False, 0.0, 0.0, fmi3False, 0.0);              \\
        bad |= NAME##_fmi3ExitInitializationMode(it);                                                           \\
        for (int n = 0; n < STEPS; n++) {                                                                       \\
            bad |= NAME##_fmi3DoStep(it, n * 0.015625, 0.015625, fmi3True, &event, &terminate, &early, &last);  \\
        }                                                                                                       \\
        bad |= NAME##_fmi3GetFloat64(it, &output, 1, values, COUNT);                                            \\
        for (int i = 0; i < COUNT; i++) {                                                                       \\
            printf("%a ", values[i]);                                                                           \\
        }                                                                                                       \\
        printf("\\n");                                                                                           \\
        NAME##_fmi3FreeInstance(it);                                                                            \\
        return bad;                                                                                             \\
    }

UNITS

int main(void)
{
    return RUNS;
}
"""


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """Object files of a unit's sources; `compiled(name, *definitions)` compiles them once."""

    @cache
    def compile_unit(name: str, *definitions: str) -> list[Path]:
        folder = extract(name, "3.0", tmp_path_factory.mktemp(name)) / "sources"
        sources = [folder / file for file in ("fmu.c", "complex.c") if (folder / file).is_file()]
        options = ["-std=c11", "-O1", "-fPIC", "-ffp-contract=off", f"-I{HEADERS}", *(f"-D{d}" for d in definitions)]
        for source in sources:
            subprocess.run(["cc", *options, "-c", str(source), "-o", str(source.with_suffix(".o"))], check=True)
        return [source.with_suffix(".o") for source in sources]

    return compile_unit


def external_names(objects: list[Path]) -> set[str]:
    """What other files of a program can see of these."""
    listed = subprocess.run(["nm", "-g", "--defined-only", *objects], check=True, capture_output=True, text=True)
    return {line.split()[2] for line in listed.stdout.splitlines() if len(line.split()) == 3}


@each_unit
def test_without_the_override_every_function_has_the_prefix_and_nothing_else_is_exported(name, compiled):
    names = external_names(compiled(name))
    prefixed = {f"{name}_{function}" for function in standard_functions("3.0")}
    assert prefixed <= names
    # what the two files of a unit share bears the unit's name too, so that no other unit can clash with it
    snake = "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
    assert {other for other in names - prefixed if not other.startswith(f"{snake}_")} == set()


@each_unit
def test_with_the_override_the_names_are_plain(name, compiled):
    assert set(standard_functions("3.0")) <= external_names(compiled(name, *PLAIN))
    assert not any(other.startswith(f"{name}_fmi3") for other in external_names(compiled(name, *PLAIN)))


def test_all_units_link_into_one_program_and_run_there(compiled, tmp_path):
    descriptions = {name: read_description(path_of(name, "3.0")) for name in UNITS}
    outputs = {
        name: next(v for v in description.variables.values() if v.causality == "output" and v.type == "Float64")
        for name, description in descriptions.items()
    }
    macros = [
        f'UNIT({name}, "{descriptions[name].token}", {v.references[0]}, {int(np.prod(v.dimensions))})'
        for name, v in outputs.items()
    ]
    text = PROGRAM.replace("\nUNITS\n", "\n" + "\n".join(macros) + "\n").replace("STEPS", str(STEPS))
    source = tmp_path / "program.c"
    source.write_text(text.replace("RUNS", " | ".join(f"run_{name}()" for name in UNITS)))
    objects = [str(path) for name in UNITS for path in compiled(name)]
    program = tmp_path / "program"
    subprocess.run(["cc", f"-I{HEADERS}", str(source), *objects, "-lm", "-o", str(program)], check=True)
    ran = subprocess.run([str(program)], check=True, capture_output=True, text=True)
    assert ran.stderr == ""
    for (name, output), line in zip(outputs.items(), ran.stdout.splitlines(), strict=True):
        with Slave(name, version="3.0") as unit:
            unit.initialize()
            for n in range(STEPS):
                unit.step(n / 64, 1 / 64)
            # the same sources with another optimisation, which for C's doubles without fused operations changes nothing
            np.testing.assert_array_equal([float.fromhex(x) for x in line.split()], np.ravel(unit.get(output.name)))
