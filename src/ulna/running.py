"""The run of a coupling: its initial values, its steps, and the rows that are recorded."""

import math
import time as clock
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .adaptive import Controlled
from .connections import End, Signal
from .coupling import Coupling, CouplingError
from .results import Results
from .slave import UnitError
from .watch import FLOAT64, Watch

# A run counts as a whole number of steps if it misses it by less than this share: round-off is far below.
WHOLE = 1e-9
# How often a run reports its progress.
REPORTS = 200
# How often the watch looks at the rows: often enough to warn while a run is wrong.
REVIEWS = 20


@dataclass(frozen=True)
class Grid:
    """The times of a run, start + n * step to the bit, and the length of its last step."""

    times: np.ndarray
    step: float
    last_step: float


def time_grid(start: float, until: float, step: float) -> Grid:
    """Times of the rows (s); if the step does not divide the time, the last one is shorter.

    Raises ValueError for times that make no run.
    """
    if not (math.isfinite(start) and math.isfinite(until) and 0.0 < step < math.inf and until >= start):
        raise ValueError(f"cannot run from {start} to {until} s in steps of {step} s")
    ratio = (until - start) / step
    if abs(ratio - round(ratio)) <= WHOLE * ratio:
        return Grid(start + np.arange(round(ratio) + 1) * step, step, step)
    times = start + np.arange(math.floor(ratio) + 1) * step
    return Grid(np.append(times, until), step, until - float(times[-1]))


def check_signal(signal: Signal, start: float) -> None:
    """Raises ValueError if a signal does not return the shape of its input."""
    shape = np.shape(signal.function(start))
    if shape != signal.target.shape:
        raise ValueError(f"the signal for {signal.target} returns values of shape {shape}")


def march(
    coupling: Coupling,
    advance: Callable[[float, float, float], None],
    watch: Watch,
    grid: Grid,
    recorded: Sequence[End],
    summary: dict[str, Any],
    progress: Callable[[float], None] | None,
) -> Results:
    """Takes all steps and returns what was recorded; a UnitError carries the rows before it as its `results`."""
    blocks = {dtype: np.empty((len(grid.times), values.size), dtype) for dtype, values in coupling.outputs.items()}
    probes = np.zeros((len(grid.times), coupling.probed.get(FLOAT64, np.zeros(0)).size))
    began = clock.perf_counter()

    def review(row: int) -> None:
        nonlocal seen
        if FLOAT64 in blocks and (row >= seen + (len(grid.times) - 1) // REVIEWS or row == len(grid.times) - 1):
            new = slice(seen + 1, row + 1)
            watch.review(blocks[FLOAT64][new], probes[new], grid.times[new])
            seen = row

    def collect(rows: int) -> Results:
        wall_time = clock.perf_counter() - began
        simulated = float(grid.times[rows - 1] - grid.times[0])
        figures = {"steps": rows - 1, "wall_time": wall_time, "real_time_factor": simulated / wall_time}
        return _results(
            coupling, recorded, grid.times[:rows], blocks, summary | figures | coupling.figures | watch.figures()
        )

    row, seen = 0, -1
    try:
        for row in _steps(coupling, advance, grid, blocks, probes):
            if not isinstance(advance, Controlled):
                review(row)
            if progress:
                progress(float(grid.times[row]))
    except (UnitError, CouplingError) as error:
        # The failing step began at the time of the last row, or after it.
        error.results = collect(int(np.searchsorted(grid.times, coupling.time.value, side="right")))
        raise
    for slave in coupling.slaves.values():
        slave.time = float(grid.times[row])
        slave.terminate()
        if slave.end_requested:
            summary["ended_by"] = slave.name
    return collect(row + 1)


def _steps(
    coupling: Coupling,
    advance: Callable[[float, float, float], None],
    grid: Grid,
    blocks: dict[np.dtype, np.ndarray],
    probes: np.ndarray,
) -> Iterator[int]:
    """Steps and writes the rows; yields the number of the latest row now and then, and of the last one."""
    times = grid.times.tolist()
    rows = [(blocks[dtype], values) for dtype, values in coupling.outputs.items()]
    flags = [slave.end_requested for slave in coupling.slaves.values() if slave.version != "2.0"]
    probed = coupling.probed.get(FLOAT64)
    last = len(times) - 1
    report = max(1, last // REPORTS)
    for block, values in rows:
        block[0] = values
    yield 0
    begin, step = times[0], grid.step
    for row in range(1, last + 1):
        if row == last:
            step = grid.last_step
        end = times[row]
        advance(begin, step, end)
        if probed is not None:
            probes[row] = probed
        for block, values in rows:
            block[row] = values
        for flag in flags:
            if flag.value:
                yield row
                return
        if row % report == 0 or row == last:
            yield row
        begin = end


def _results(
    coupling: Coupling,
    recorded: Sequence[End],
    times: np.ndarray,
    blocks: dict[np.dtype, np.ndarray],
    summary: dict[str, Any],
) -> Results:
    columns = {}
    for end in recorded:
        dtype, start, stop = coupling.place(end)
        values = blocks[dtype][: len(times), start:stop].reshape(len(times), *end.shape)
        columns[end.name] = values.astype(bool) if end.variable.type == "Boolean" else values
    return Results(times, columns, {end.name: end.variable.unit.name for end in recorded}, summary)
