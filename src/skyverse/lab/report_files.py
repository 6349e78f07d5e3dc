"""Reports written as Markdown and as one web page."""

import base64
import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from importlib.resources import files
from io import StringIO
from pathlib import Path

from skyverse.atomic import whole_file, write_text
from skyverse.errors import InputError
from skyverse.lab.figures import image, style
from skyverse.lab.report import (
    NO_VALUE,
    Cell,
    Figure,
    Printed,
    Report,
    SectionHeading,
    Table,
    Text,
    cells,
    literal,
    one_line,
)

_TYPES = {"svg": "image/svg+xml", "png": "image/png"}
_SUFFIXES = (*_TYPES, "pdf")


def write_report_files(
    report: Report,
    folder: Path | str,
    *,
    stem: str = "report",
    formats: Sequence[str] = ("html", "md"),
    figures: Sequence[str] = ("svg",),
) -> list[Path]:
    """Write `report` into `folder`, which is created if needed, and return the paths of all files, figures first.

    Equal reports give equal bytes.

    Parameters
    ----------
    stem
        The name of the report's files without suffix.
    formats
        ``"html"``: one page with all figures inside. ``"md"``: Markdown that shows the files in ``figures/``. ``"csv"``
        and ``"tex"``: each table as a file of its own in ``tables/``, named by its number and heading; in CSV each
        number has a column of its own.
    figures
        The formats of the files in ``figures/``: ``"svg"``, ``"png"``, ``"pdf"``. Pages show the first that is
        ``"svg"`` or ``"png"``. Without any, the page contains SVG, and the Markdown has only captions. PDF has its
        fonts embedded as TrueType (Type 42), as journals ask.

    Raises
    ------
    ValueError
        For another format, or if the name of a figure is not unique or cannot be a file name.
    InputError
        If a file cannot be written.
    """
    _check(report, formats, figures)
    folder = Path(folder)
    shown = next((suffix for suffix in figures if suffix in _TYPES), "svg")
    try:
        (folder / "figures" if figures and _figures(report) else folder).mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{str(folder)!r}: cannot be made: {getattr(error, 'strerror', None) or error}") from None
    written, images = [], {}
    for block in _figures(report):
        with style():
            drawn = block.draw()
            contents = {suffix: image(drawn, suffix) for suffix in sorted({*figures, shown})}
        images[block.name] = f"data:{_TYPES[shown]};base64,{base64.b64encode(contents[shown]).decode()}"
        for suffix in sorted(set(figures)):
            written.append(folder / "figures" / f"{block.name}.{suffix}")
            with whole_file(written[-1]) as beside:
                beside.write_bytes(contents[suffix])
    if "md" in formats:
        written.append(folder / f"{stem}.md")
        write_text(written[-1], markdown(report, suffix=shown if shown in figures else None))
    if "html" in formats:
        written.append(folder / f"{stem}.html")
        write_text(written[-1], html(report, images))
    for suffix, text_of in (("csv", _csv), ("tex", latex)):
        if suffix in formats:
            (folder / "tables").mkdir(exist_ok=True)
            for name, table in _named_tables(report):
                written.append(folder / "tables" / f"{name}.{suffix}")
                write_text(written[-1], text_of(table))
    return written


def _named_tables(report: Report) -> Iterator[tuple[str, Table]]:
    heading, number = "", 0
    for block in report.blocks:
        if isinstance(block, SectionHeading):
            heading = one_line(block.text)
        elif isinstance(block, Table):
            number += 1
            captioned = block if block.caption else replace(block, caption=heading or "Runs")
            name = re.sub(r"\W+", "-", heading.lower()).strip("-")[:40]
            yield f"{number:02}-{name or 'runs'}", captioned


def _csv(table: Table) -> str:
    file = StringIO()
    writer = csv.writer(file, lineterminator="\n")
    columns = [column for k, head in enumerate(table.head) for column in _spread(head, [row[k] for row in table.rows])]
    writer.writerows(zip(*columns, strict=True))
    return file.getvalue()


def _spread(head: str, column: list[Cell]) -> Iterator[list[str | float]]:
    """Yield a column as it is, below its head, or one for each of the numbers that its texts tell."""
    names = dict.fromkeys(name for cell in column if isinstance(cell, Printed) for name in cell.numbers)
    for name in names or [head]:
        values = [cell.numbers.get(name) if isinstance(cell, Printed) else None if names else cell for cell in column]
        yield [name, *("" if value is None or value != value else value for value in values)]


def latex(table: Table) -> str:
    """Return a table in LaTeX, for the package booktabs; its caption stands in a comment."""
    printed, right = _aligned(table)
    rows = [" & ".join(map(_in_latex, row)) + r" \\" for row in [list(table.head), *printed]]
    rows = [re.sub(r"^(?=[\[*])", "{}", row) for row in rows]  # else an argument of the command in the line above
    lines = [
        f"% {one_line(table.caption)}",
        rf"\begin{{tabular}}{{{''.join('r' if flush else 'l' for flush in right)}}}",
        r"\toprule",
        rows[0],
        r"\midrule",
        *rows[1:],
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


_LATEX = {
    **{sign: rf"\{sign}" for sign in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "±": r"$\pm$",
    "\u2212": "$-$",
    "∞": r"$\infty$",
    "<": "$<$",
    ">": "$>$",
    "\u2013": "--",
}


def _in_latex(text: str) -> str:
    return "".join(_LATEX.get(sign, sign) for sign in one_line(text))


def markdown(report: Report, *, suffix: str | None = "svg") -> str:
    """Return `report` in Markdown that shows ``figures/*.suffix``, or only captions where `suffix` is ``None``."""
    parts = [f"# {literal(report.title)}"]
    for block in report.blocks:
        match block:
            case SectionHeading(text, level):
                parts.append(f"{'#' * level} {literal(text)}")
            case Text(text):
                parts.append(text.strip())
            case Table():
                parts += [one_line(block.caption), _markdown_table(block), *map(one_line, block.notes)]
            case Figure(name, caption):
                parts += [f"![{name}](figures/{name}.{suffix})"] if suffix else []
                parts.append(one_line(caption))
    return "\n\n".join(part for part in parts if part) + "\n"


def html(report: Report, images: dict[str, str]) -> str:
    """Return `report` as one web page; `images` maps the name of each figure to the address of its image."""
    style = files("skyverse.lab").joinpath("report.css").read_text("utf-8")
    body, contents = [], []
    for number, block in enumerate(report.blocks):
        match block:
            case SectionHeading(text, level):
                body.append(f'<h{level} id="s{number}">{_text(text)}</h{level}>')
                if level <= 3:
                    contents.append(f'<li class="level-{level}"><a href="#s{number}">{_text(text)}</a></li>')
            case Text(text):
                body.append(_rendered(text))
            case Table():
                body.append(_html_table(block))
            case Figure(name, caption):
                image = f'<img src="{images[name]}" alt="{escape(name)}">'
                told = f"<figcaption>{_rendered(caption)}</figcaption>"
                body.append(f"<figure>{image}{told}</figure>")
    title = _text(report.title)
    lines = "\n".join
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
        f'<nav aria-label="Contents"><ul>\n{lines(contents)}\n</ul></nav>\n'
        f"<main>\n<h1>{title}</h1>\n{lines(body)}\n</main>\n</body>\n</html>\n"
    )


def _to_the_right(column: list[str]) -> bool:
    """Return whether the printed cells of a column are numbers."""
    told = [text for text in column if text not in ("", NO_VALUE)]
    return bool(column) and all(re.match(r"[<>≈±+\u2212-]?\s*[\d∞]", text) for text in told)


def _aligned(table: Table) -> tuple[list[list[str]], list[bool]]:
    printed = cells(table)
    return printed, [_to_the_right([row[column] for row in printed]) for column in range(len(table.head))]


def _markdown_table(table: Table) -> str:
    printed, right = _aligned(table)
    rows = [[literal(text) for text in row] for row in [list(table.head), *printed]]
    widths = [max(3, *(len(row[column]) for row in rows)) for column in range(len(right))]
    lines = [
        " | ".join(
            text.rjust(width) if flush else text.ljust(width)
            for text, width, flush in zip(row, widths, right, strict=True)
        )
        for row in rows
    ]
    rule = ("-" * (width - flush) + ":" * flush for width, flush in zip(widths, right, strict=True))
    return "\n".join(f"| {line} |" for line in [lines[0], " | ".join(rule), *lines[1:]])


def _html_table(table: Table) -> str:
    printed, right = _aligned(table)
    side = [' class="number"' if flush else "" for flush in right]
    head = "".join(f'<th scope="col"{s}>{_text(text)}</th>' for s, text in zip(side, table.head, strict=True))
    named = [f'{s} data-head="{escape(one_line(text))}"' for s, text in zip(side, table.head, strict=True)]
    rows = "\n".join(
        f"<tr>{''.join(f'<td{s}>{_text(text)}</td>' for s, text in zip(named, row, strict=True))}</tr>"
        for row in printed
    )
    caption = f"<figcaption>{_rendered(table.caption)}</figcaption>" if table.caption else ""
    notes = "".join(f'<div class="note">{_rendered(note)}</div>' for note in table.notes)
    return (
        f'<figure class="table">{caption}<table>\n<thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{rows}\n</tbody>\n</table>{notes}</figure>"
    )


def _rendered(text: str) -> str:
    from markdown_it import MarkdownIt

    return str(MarkdownIt("commonmark", {"html": False}).enable("table").render(text)).strip()


def _text(text: str) -> str:
    return escape(one_line(text))


def _figures(report: Report) -> list[Figure]:
    return [block for block in report.blocks if isinstance(block, Figure)]


def _check(report: Report, formats: Sequence[str], figures: Sequence[str]) -> None:
    for wanted, known in ((formats, ("html", "md", "csv", "tex")), (figures, _SUFFIXES)):
        for suffix in wanted:
            if suffix not in known:
                raise ValueError(f"expected {', '.join(known)}, not {suffix!r}")
    names = [block.name for block in _figures(report)]
    for name in names:
        if not re.fullmatch(r"[A-Za-z0-9][\w.-]*", name) or names.count(name) > 1:
            raise ValueError(f"a figure's name is a file name of its own, not {name!r}")
