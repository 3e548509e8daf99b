"""A step of the FMU as built against the same step traced from its sources, for every solver."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from casadi import SX

from ..slave import Slave, UnitError
from .arithmetic import UndefinedError
from .as_built import VALUE_LIMIT, Traced, Worst
from .claims import Row
from .solvers import Case


def steps_as_built(unit: str, path: str | Path, cases: Mapping[str, list[Case]]) -> Iterator[Row]:
    """The claim that doStep does what the C says, to the roundings of its terms; none without cases."""
    if not cases:
        return
    worst = Worst()
    with Slave(path) as slave:
        for case in [case for several in cases.values() for case in several]:
            for solver in case.model.SOLVERS:
                try:
                    worst.see(*_step(slave, case, solver))
                except (UndefinedError, UnitError) as error:
                    worst.ratio, worst.where = math.inf, f"{solver}: {error or 'no value'}"
        yield worst.row(unit, f"FMI {slave.version}: a step of each solver is that of the sources", VALUE_LIMIT)


def _step(slave: Slave, case: Case, solver: str) -> tuple[dict, dict]:
    """States after a step: read, and as the traced path gives them from the states before."""
    model, h = case.model, float(case.h)
    slave.reset()
    slave.set("solver", solver)
    for name, value in case.given_to_unit.items():
        slave.set(name, value if value.size > 1 else value[0])
    slave.initialize()
    here = {name: np.atleast_1d(slave.get(name)) for name in model.STATES} | {"h": np.array([h])}
    slave.step(0.0, h)
    symbols = case.symbols | {"h": SX.sym("h")}
    traced = Traced(case.paths.step(solver, symbols, symbols["h"]), symbols)
    expected = traced.at(case.given_to_unit | here)
    read = {f"{solver}: {name}": np.atleast_1d(slave.get(name)) for name in model.STATES}
    return read, {f"{solver}: {name}": value for name, value in expected.items()}
