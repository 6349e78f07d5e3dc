"""A report as data: headings, text, tables and figures in order, and how it writes text. `report_files` writes it."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

from skyverse.model.short_lines import listed

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


def literal(text: str) -> str:
    """Return Markdown that shows `text` as it is, on one line."""
    return re.sub(r"([\\`*_\[\]<>|~&#!$])", r"\\\1", one_line(text))


def one_line(text: str) -> str:
    """Return `text` on one line; control characters, which would break pages and figures, are replaced."""
    return re.sub(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]", "\ufffd", " ".join(text.split()))


def p_value(p: float | None) -> str:
    """Return p with its name; ``None`` stands for too few runs to compute p."""
    if p is None:
        return "too few runs for p"
    return f"p {bare_p(p)}" if p < 0.001 else f"p = {bare_p(p)}"


def bare_p(p: float) -> str:
    """Return p without its name."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}" if p < 0.1 else f"{p:.2f}"


def whole_numbers(numbers: Iterable[int]) -> str:
    """Return the distinct whole numbers as a range or a list, or how many there are where a list would be long."""
    found = sorted(set(numbers))
    if len(found) > 2 and found[-1] - found[0] == len(found) - 1:
        return f"{found[0]} to {found[-1]}"
    return listed([str(number) for number in found]) if len(found) <= 12 else f"{len(found)} of them"


def named(labels: Sequence[str], indices: Iterable[int]) -> str:
    """Return the labels at `indices`, in Markdown, separated by commas."""
    return ", ".join(literal(labels[index]) for index in indices)
