"""Pieces of a page in HTML: numbers, tiles, tables, cards and facts."""

import math
from collections.abc import Iterable, Sequence
from html import escape

from skyverse.draw.scene import SceneFinding

MAX_SHOWN_FINDINGS = 200
NO_VALUE = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"


def number(value: float | None, decimals: int = 2) -> str:
    """Return a number with separated thousands; a dash for ``None`` and nan."""
    if value is None or math.isnan(value):
        return NO_VALUE
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    return f"{value:,.{decimals}f}".replace("-", MINUS)


def tiles(shown: Iterable[tuple[str, str, str]]) -> str:
    """Return tiles, each with a name, a value and a note below it."""
    return "".join(f"<div><dt>{name}</dt><dd>{value}<small>{note}</small></dd></div>" for name, value, note in shown)


def table(caption: str, heads: Sequence[tuple[str, str]], rows: Iterable[str], *, text_columns: int) -> str:
    """Return a table of `rows`; each of `heads` is a column's name and its tooltip, the first columns are text."""
    head = ""
    for column, (name, title) in enumerate(heads):
        kind = ' class="text"' if column < text_columns else ""
        tooltip = f' title="{title}"' if title else ""
        head += f'<th scope="col"{kind}{tooltip}>{name}</th>'
    said = f"<caption>{caption}</caption>" if caption else ""
    return f"{said}<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody>"


def uav_row(name: str, colour: str, texts: Iterable[str], cells: Iterable[str]) -> str:
    """Return a UAV's row of a table: its name with its colour, then `texts` and `cells`, both in HTML."""
    columns = [f'<td class="text">{text}</td>' for text in texts] + [f"<td>{cell}</td>" for cell in cells]
    return f'<tr><th scope="row"><i style="background:{colour}"></i>{escape(name)}</th>{"".join(columns)}</tr>'


def card(tone: str, sign: str, heading: str, body: str) -> str:
    """Return a card above the picture: tone ``good``, ``warn``, ``bad`` or ``note``; heading and body in HTML."""
    return (
        f'<section class="verdict {tone}"><span class="sign" aria-hidden="true">{sign}</span>'
        f"<div><h2>{heading}</h2>{body}</div></section>"
    )


def finding_line(finding: SceneFinding) -> str:
    """Return one finding as a list item, with a button that shows the scene at its time."""
    parts = [f'<span class="kind">{escape(finding.kind)}</span>']
    if finding.uavs:
        parts.append(f"<b>{escape(', '.join(finding.uavs))}</b>")
    parts.append(escape(finding.message))
    if finding.time is not None and math.isfinite(finding.time):
        t = finding.time
        parts.append(f'<button type="button" class="jump" data-time="{t:.6g}">show t = {t:.2f} s</button>')
    return f'<li class="{finding.severity}">{" ".join(parts)}</li>'


def facts_list(facts: dict[str, str]) -> str:
    """Return named facts for the foot of the page."""
    return "".join(f"<div><dt>{name}</dt><dd>{escape(fact)}</dd></div>" for name, fact in facts.items())
