"""What a run recorded: one row for each time, one column for each variable."""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .names import unknown

HEADER = re.compile(r"(?P<name>.+?)(?:\[(?P<index>\d+(?:,\d+)*)\])? \[(?P<unit>[^\]]*)\]")


@dataclass
class Results:
    """`time` has shape (n,), seconds; `columns` maps "unit.variable" to an array of shape (n, *shape of the variable).

    Row k holds the values at time[k]; the first row is the initialised system.
    """

    time: np.ndarray
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    """Physical unit of every column."""
    summary: dict[str, Any] = field(default_factory=dict)
    """Of the run: master, step, number of steps, wall_time (s), real_time_factor, loops, ended_by.

    Of the coupling: input_error (over an input's nominal plus largest value) and input_error_at, coupling_energy and
    system_energy (J), wrong; of masters that repeat steps, sweeps; of joints, largest_gap (m); with a tolerance,
    macro_steps, repeated_steps, shortest_step (s).
    """

    def __getitem__(self, name: str) -> np.ndarray:
        """A column, or `time`; raises KeyError with the nearest right names."""
        if name == "time":
            return self.time
        try:
            return self.columns[name]
        except KeyError:
            raise KeyError(unknown("the recording", "column", name, self.columns)) from None

    def __contains__(self, name: str) -> bool:
        """Whether a variable was recorded."""
        return name in self.columns

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.time)

    def __iter__(self) -> Iterator[str]:
        """Names of the columns."""
        return iter(self.columns)

    def to_csv(self, path: str | PathLike) -> None:
        """Writes a table with a header such as `time [s], ball.position[1] [m]`; every number reads back to the bit."""
        header, table = ["time [s]"], [self.time]
        for name, values in self.columns.items():
            for index in np.ndindex(values.shape[1:]):
                position = f"[{','.join(str(number + 1) for number in index)}]" if index else ""
                header.append(f"{name}{position} [{self.units[name]}]")
                table.append(values[(slice(None), *index)])
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(header)
            writer.writerows(zip(*(column.tolist() for column in table), strict=True))

    @classmethod
    def from_csv(cls, path: str | PathLike) -> "Results":
        """Reads what `to_csv` wrote; the summary is not part of it."""
        with Path(path).open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        parts: dict[str, dict[tuple[int, ...], np.ndarray]] = {}
        units = {}
        for number, title in enumerate(header):
            match = HEADER.fullmatch(title)
            if not match:
                raise ValueError(f"{path}: column {title!r} does not read as `name [unit]`")
            index = tuple(int(part) - 1 for part in (match["index"] or "").split(",") if part)
            parts.setdefault(match["name"], {})[index] = _parse([row[number] for row in rows])
            units[match["name"]] = match["unit"]
        columns = {name: _assemble(elements) for name, elements in parts.items()}
        return cls(columns.pop("time"), columns, {name: units[name] for name in columns})


def _parse(texts: list[str]) -> np.ndarray:
    """Python writes floats with a point or an exponent, integers without, and Booleans as words."""
    if set(texts) <= {"True", "False"} and texts:
        return np.array([text == "True" for text in texts])
    try:
        return np.array([int(text) for text in texts], np.int64)
    except ValueError:
        return np.array([float(text) for text in texts])


def _assemble(elements: Mapping[tuple[int, ...], np.ndarray]) -> np.ndarray:
    if () in elements:
        return elements[()]
    shape = tuple(max(numbers) + 1 for numbers in zip(*elements, strict=True))
    stacked = np.stack([elements[index] for index in np.ndindex(shape)], axis=-1)
    return stacked.reshape(len(stacked), *shape)
