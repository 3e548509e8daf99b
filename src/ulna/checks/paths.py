"""Whole steps of a unit, with their branches and loops: traced along the path that is taken at given values.

The unit's `unit.c` is compiled as C++ with every number a pair of symbol and value. Where the C compares, the value
decides; what the path computes is then one formula, which holds near those values.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi
from casadi import SX

from .lift import SNIPPETS, Header, read_header, traced

Numbers = Mapping[str, Sequence[float]]
"""Values by the names of variables, elements in a row."""


@dataclass(frozen=True)
class Paths:
    """Steps of one case, by solver: a function of the values and of `h`, to the states after it."""

    functions: Mapping[str, casadi.Function]

    def step(self, solver: str, values: Mapping[str, SX], h: SX) -> dict[str, SX]:
        """The states after a step of `h` s; names that `values` lacks become free symbols."""
        function = self.functions[solver]
        known = {**values, "h": h}
        names = function.name_in()
        arguments = [SX(known[n]) if n in known else SX.sym(n, function.size1_in(n)) for n in names]
        results = function.call(arguments, True, False)
        return {
            name.removeprefix("to_"): casadi.densify(result)
            for name, result in zip(function.name_out(), results, strict=True)
        }


def program(header: Header, solvers: Sequence[str], states: Sequence[str], cases: Mapping[str, Numbers]) -> str:
    """The C++ program that traces one step of each solver in each case; `h` is among the values of a case."""
    unit = header.unit
    lines = ['#include "lift.hpp"', '#include "path_begin.hpp"', '#include "unit.c"', "", "int main()", "{"]
    for case, values in cases.items():
        for solver in solvers:
            lines += ["    {", "        Trace trace;", f"        {unit} body = {{}};", "        Path h;"]
            for name, numbers in values.items():
                place = "h" if name == "h" else f"body.{name}"
                elements = ", ".join(float(number).hex() for number in numbers)
                lines.append(f'        trace.value("{name}", PATHS({place}), {{{elements}}});')
            lines.append(f"        body.solver = {header.solvers[solver]};")
            lines.append(f"        {header.snake}_step(&body, h, nullptr);")
            lines += [f'        trace.result("{state}", PATHS(body.{state}));' for state in states]
            lines += [f'        trace.save("{case}_{solver}");', "    }"]
    return "\n".join([*lines, "}", ""])


def trace_steps(
    sources: Path, solvers: Sequence[str], states: Sequence[str], cases: Mapping[str, Numbers], folder: Path = SNIPPETS
) -> dict[str, Paths]:
    """Steps of `solvers` in each of the cases, whose names are identifiers; values are what a case gives, others zero.

    Raises LiftError where the C cannot be traced, or does not take the step.
    """
    header = read_header(Path(sources) / "variables.h")
    fields = {**header.fields, "h": 1}
    known = {case: {n: v for n, v in values.items() if n in fields} for case, values in cases.items()}
    functions = traced(Path(sources).resolve(), program(header, solvers, states, known), folder)
    return {case: Paths({solver: functions[f"{case}_{solver}"] for solver in solvers}) for case in cases}
