"""In which order units are stepped, and which loops their connections make."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from .connections import Connection

Node = TypeVar("Node", bound=Hashable)


@dataclass(frozen=True)
class Loop:
    """Units that wait for one another."""

    units: tuple[str, ...]
    """In the order in which they are stepped."""
    broken: tuple[str, ...]
    """The connections that carry values one step old for it."""
    algebraic: tuple[str, ...]
    """The inputs through which the loop closes without any state in between: its values settle only by iteration."""

    def __str__(self) -> str:
        """What reports say of it."""
        kind = f"algebraic, through {', '.join(self.algebraic)}" if self.algebraic else "through states"
        return f"{', '.join(self.units)}: broken at {', '.join(self.broken)} ({kind})"


def cycles(nodes: Sequence[Node], edges: Iterable[tuple[Node, Node]]) -> list[list[Node]]:
    """The strongly connected components that hold a cycle, by transitive closure: scenes are small."""
    index = {node: number for number, node in enumerate(nodes)}
    reach = np.zeros((len(nodes), len(nodes)), bool)
    for before, after in edges:
        reach[index[before], index[after]] = True
    for middle in range(len(nodes)):
        reach |= np.outer(reach[:, middle], reach[middle])
    components, seen = [], set()
    for number, node in enumerate(nodes):
        if reach[number, number] and node not in seen:
            component = [nodes[k] for k in np.flatnonzero(reach[number] & reach[:, number])]
            components.append(component)
            seen.update(component)
    return components


def step_order(units: Sequence[str], connections: Sequence[Connection]) -> list[str]:
    """Every unit after those whose outputs it takes; among equals, as they were added.

    Loops are opened first where the input reaches no output of its unit directly (the new value then only misses
    the step itself), and otherwise before the unit that was added first.
    """
    edges = {(c.source.unit.name, c.target.unit.name, feeds_through(c, connections)) for c in connections}
    edges = {(before, after, direct) for before, after, direct in edges if before != after}
    while loops := cycles(units, [edge[:2] for edge in edges]):
        for loop in loops:
            inside = {edge for edge in edges if edge[0] in loop and edge[1] in loop}
            indirect = {edge for edge in inside if not edge[2] and (*edge[:2], True) not in edges}
            edges -= indirect or {edge for edge in inside if edge[1] == loop[0]}
    order: list[str] = []
    while len(order) < len(units):
        waiting = {after for before, after, _ in edges if before not in order}
        order.append(next(unit for unit in units if unit not in order and unit not in waiting))
    return order


def step_blocks(units: Sequence[str], connections: Sequence[Connection]) -> list[list[str]]:
    """The units in blocks, each after the blocks it takes from: a loop is one block, in the order of `step_order`."""
    order = step_order(units, connections)
    edges = {(c.source.unit.name, c.target.unit.name) for c in connections}
    block_of = {unit: (unit,) for unit in order}
    for loop in cycles(order, edges):
        block_of.update(dict.fromkeys(loop, tuple(loop)))
    waits = {(block_of[before], block_of[after]) for before, after in edges if block_of[before] != block_of[after]}
    blocks: list[tuple[str, ...]] = []
    left = list(dict.fromkeys(block_of[unit] for unit in order))
    while left:
        ready = next(block for block in left if not any((other, block) in waits for other in left))
        blocks.append(ready)
        left.remove(ready)
    return [list(block) for block in blocks]


def feeds_through(connection: Connection, connections: Sequence[Connection]) -> bool:
    """Whether some output of the target's unit that is connected further depends directly on this input."""
    target = connection.target
    used = {c.source.variable.name for c in connections if c.source.unit is target.unit}
    return any(target.variable.name in target.unit.slave.description.inputs_of(name) for name in used)


def find_loops(units: Sequence[str], connections: Sequence[Connection]) -> list[Loop]:
    """The loops of the connections, with the places where `step_order` opens them."""
    order = step_order(units, connections)
    place = {unit: number for number, unit in enumerate(order)}
    algebraic = {name for component in cycles(*_input_graph(connections)) for name in component}
    loops = []
    for component in cycles(order, [(c.source.unit.name, c.target.unit.name) for c in connections]):
        inside = [c for c in connections if c.source.unit.name in component and c.target.unit.name in component]
        broken = [c for c in inside if place[c.source.unit.name] >= place[c.target.unit.name]]
        through = [c.target.name for c in inside if c.target.name in algebraic]
        loops.append(Loop(tuple(component), tuple(map(str, broken)), tuple(through)))
    return loops


def _input_graph(connections: Sequence[Connection]) -> tuple[list[str], list[tuple[str, str]]]:
    """Connected inputs, and an edge wherever one reaches the next through the direct dependencies of an output."""
    edges = []
    for after in connections:
        known = after.source.unit.slave.description.inputs_of(after.source.variable.name)
        for before in connections:
            if before.target.unit is after.source.unit and before.target.variable.name in known:
                edges.append((before.target.name, after.target.name))
    return [c.target.name for c in connections], edges
