"""A report as data: headings, text, tables and figures in order. `report_files` writes it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from skyverse.lab.formatting import one_line

if TYPE_CHECKING:
    from matplotlib import figure

NO_VALUE = "\u2013"
"""What a cell without a value shows."""
_MINUS = "\u2212"


@dataclass(frozen=True)
class Printed:
    """A text that tells numbers, by the names of the columns that they have in CSV."""

    text: str
    numbers: Mapping[str, float | None]


Cell = str | int | float | Printed | None
"""Plain text or a number; ``None`` and nan mean that there is no value, and are printed as a dash."""


@dataclass(frozen=True)
class SectionHeading:
    """A heading in plain text; 2 is the highest level below the title."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Text:
    """Paragraphs in Markdown (CommonMark with tables, no HTML); names that a user gave must pass through `literal`."""

    markdown: str


@dataclass(frozen=True)
class Table:
    """Cells in plain text; columns of numbers are aligned to the right, with as many decimals in every row.

    `caption` and `notes` are Markdown.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    notes: Sequence[str] = ()

    @classmethod
    def from_records(cls, records: Sequence[Mapping[str, Cell]], caption: str = "", notes: Sequence[str] = ()) -> Self:
        """Return a table with a row for each record, one or more; the keys of the longest are the heads of columns."""
        head = max((tuple(record) for record in records), key=len)
        return cls(head, [[record.get(column) for column in head] for record in records], caption, notes)


@dataclass(frozen=True)
class Figure:
    """A figure: `draw` makes it when the report is written, `name` is the stem of its files, `caption` is Markdown."""

    name: str
    caption: str
    draw: "Callable[[], figure.Figure]"


Block = SectionHeading | Text | Table | Figure


@dataclass(frozen=True)
class Report:
    """A title in plain text, and the blocks below it."""

    title: str
    blocks: Sequence[Block]


def cells(table: Table) -> list[list[str]]:
    """Return the cells of `table` as they are printed, row by row."""
    columns = [_printed([row[column] for row in table.rows]) for column in range(len(table.head))]
    return [list(row) for row in zip(*columns, strict=True)]


def _printed(column: list[Cell]) -> list[str]:
    numbers = [abs(value) for value in column if isinstance(value, float) and math.isfinite(value)]
    places = decimals(numbers)
    printed = []
    for value in column:
        if value is None or (isinstance(value, float) and math.isnan(value)):
            printed.append(NO_VALUE)
        elif isinstance(value, float):
            text = f"{value:,.{places}f}" if math.isfinite(value) else "∞" if value > 0 else "-∞"
            printed.append(text.replace("-", _MINUS))
        elif isinstance(value, int):
            printed.append(f"{value:,}".replace("-", _MINUS))
        else:
            printed.append(one_line(value.text if isinstance(value, Printed) else value))
    return printed


def decimals(numbers: list[float]) -> int:
    """Return how many decimals show the largest of `numbers` with four digits or more; 0 where all are whole."""
    largest = max(numbers, default=0.0)
    if largest == 0.0 or all(number == int(number) for number in numbers):
        return 0
    return min(6, max(1 if largest < 1e4 else 0, 3 - math.floor(math.log10(largest))))
