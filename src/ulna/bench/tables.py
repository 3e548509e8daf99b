"""What a benchmark gives back, and how it is printed."""

from collections.abc import Sequence
from dataclasses import dataclass

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table as RichTable

Cell = str | float


@dataclass(frozen=True)
class Table:
    """Rows of names and plain numbers; `note` says what was done to get them."""

    title: str
    note: str
    columns: tuple[str, ...]
    rows: list[tuple[Cell, ...]]

    def column(self, name: str) -> list[Cell]:
        """The cells below a heading; raises ValueError for a wrong one."""
        place = self.columns.index(name)
        return [row[place] for row in self.rows]


def text_of(cell: Cell) -> str:
    """Two digits of a number, three where they fit without an exponent."""
    if isinstance(cell, str):
        return cell
    return (
        f"{cell:.3g}"
        if cell == 0 or 0.1 <= abs(cell) < 1000
        else f"{cell:.1e}".replace("e-0", "e-").replace("e+0", "e")
    )


def show(tables: Sequence[Table], console: Console | None = None) -> None:
    """Prints tables, on the terminal unless told otherwise; they fit into 80 columns."""
    console = console or Console()
    for table in tables:
        console.print(table.title, style="bold")
        drawn = RichTable(box=SIMPLE_HEAD, pad_edge=False, collapse_padding=True)
        for heading, cell in zip(table.columns, table.rows[0], strict=True):
            drawn.add_column(heading, **({"no_wrap": True} if isinstance(cell, str) else {"justify": "right"}))
        for row in table.rows:
            drawn.add_row(*map(text_of, row))
        console.print(drawn, table.note, "", sep="\n")
