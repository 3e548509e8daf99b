"""The dependencies in ModelStructure against the compiled unit: what reacts is declared, what is declared reacts.

Every known (a real input, a continuous state) is moved alone, by a finite push, at random states with random
parameters, and every unknown (output, state derivative) is looked at, scalar by scalar, through FMI 2.
"""

from ctypes import c_double
from itertools import groupby

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.model_description import ModelDescription, ModelVariable
from generated import declaration, each_unit, stem

import ulna
from ulna.description import read_description

STATES = 9
PUSH = 0.3
# Far above round-off, which also reaches what does not depend on a variable; far below any reaction to such a push.
REACTION = 1e-9
UNIT_VECTORS = {"axis"}
SHORT_TIMES = {"echo_start", "time_out"}  # of milliseconds: a push of the others' size is refused
MESHED = {"surface"}  # needs a mesh, which FMI 2 cannot carry


class Probe:
    """A unit at one random state: `unknowns(values)` are its unknowns for values of its knowns."""

    def __init__(self, name: str, seed: int):
        path = ulna.fmu(name, "2.0")
        self.random = np.random.default_rng(seed)
        self.description: ModelDescription = fmpy.read_model_description(path)
        structure = [*self.description.outputs, *self.description.derivatives]
        self.unknown_variables = [u.variable for u in structure if u.variable.type == "Real"]
        self.declared = {
            (u.variable.name, known.name) for u in structure if u.variable.type == "Real" for known in u.dependencies
        }
        self.inputs = [v for v in self.description.modelVariables if v.causality == "input" and v.type == "Real"]
        self.states = [u.variable.derivative for u in self.description.derivatives]
        self.knowns = [*self.inputs, *self.states]
        kind, made = ("modelExchange", FMU2Model) if self.states else ("coSimulation", FMU2Slave)
        self.fmu = made(
            guid=self.description.guid,
            modelIdentifier=getattr(self.description, kind).modelIdentifier,
            unzipDirectory=str(read_description(path).folder),
        )
        self.fmu.instantiate()
        parameters = [v for v in self.description.modelVariables if v.causality == "parameter" and v.type == "Real"]
        # zeros would hide what they multiply; other start values are sound together, and stay
        drawn = [v for v in parameters if float(v.start) == 0.0 or stem(v.name) in UNIT_VECTORS]
        drawn = [v for v in drawn if v.name not in SHORT_TIMES]
        self.fmu.setReal([v.valueReference for v in drawn], self.numbers(name, drawn))
        choices = [v for v in self.description.modelVariables if v.causality == "parameter" and v.type == "Enumeration"]
        usable = [[int(item.value) for item in v.declaredType.items if item.name not in MESHED] for v in choices]
        entries = [values[seed % len(values)] for values in usable]
        self.fmu.setInteger([v.valueReference for v in choices], entries)
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if self.states:
            self.fmu.newDiscreteStates()
            self.fmu.enterContinuousTimeMode()
        self.values = np.array(self.numbers(name, self.knowns))

    def numbers(self, name: str, variables: list[ModelVariable]) -> list[float]:
        """Random values around the starts, within the limits; unit quaternions and unit vectors of any direction."""
        values: list[float] = []
        for array, group in groupby(variables, key=lambda v: stem(v.name)):
            elements = list(group)
            draw = self.random.standard_normal(len(elements))
            if array in UNIT_VECTORS or (declaration(name).by_name(array).quaternion and len(elements) == 4):
                values += list(draw / np.linalg.norm(draw))
                continue
            for v, x in zip(elements, draw, strict=True):
                value = float(v.start or 0.0) + PUSH * x
                values.append(abs(value) if v.min is not None else value)
        return values

    def unknowns(self, values: np.ndarray) -> np.ndarray:
        """The unknowns for these values of the knowns."""
        inputs, states = values[: len(self.inputs)], values[len(self.inputs) :]
        self.fmu.setReal([v.valueReference for v in self.inputs], list(inputs))
        if self.states:
            self.fmu.fmi2SetContinuousStates(self.fmu.component, (c_double * len(states))(*states), len(states))
        return np.array(self.fmu.getReal([v.valueReference for v in self.unknown_variables]))

    def reactions(self) -> set[tuple[str, str]]:
        """(unknown, known) of all that reacts here."""
        before = self.unknowns(self.values)
        found = set()
        for k, known in enumerate(self.knowns):
            moved = self.values.copy()
            moved[k] += PUSH
            change = np.abs(self.unknowns(moved) - before) / np.maximum(1.0, np.abs(before))
            found |= {(self.unknown_variables[u].name, known.name) for u in np.flatnonzero(change > REACTION)}
        return found

    def free(self) -> None:
        self.fmu.freeInstance()


@pytest.fixture(scope="module")
def probed():
    """`probed(name)`: what is declared, what reacted at one state at least, and what is declared of what array."""
    kept = {}

    def probe(name):
        if name not in kept:
            found, declared = set(), set()
            for seed in range(STATES):
                probe = Probe(name, seed)
                found |= probe.reactions()
                declared = probe.declared
                probe.free()
            kept[name] = declared, found
        return kept[name]

    return probe


@each_unit
def test_nothing_reacts_that_is_not_declared(probed, name):
    declared, found = probed(name)
    assert found - declared == set()


@each_unit
def test_nothing_is_declared_that_never_reacts(probed, name):
    """Between two arrays a declaration stands for every pair of elements, some of which may be zero by structure, as
    the diagonal of a cross product is. So of each such block every row and every column must react somewhere: each
    element of the unknown to some element of the known, and some element of the unknown to each of the known."""
    declared, found = probed(name)
    rows = {(unknown, stem(known)) for unknown, known in declared}
    columns = {(stem(unknown), known) for unknown, known in declared}
    assert rows - {(unknown, stem(known)) for unknown, known in found} == set()
    assert columns - {(stem(unknown), known) for unknown, known in found} == set()
