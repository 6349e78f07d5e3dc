"""The web page that shows a scene: its template filled, with all scripts, styles and data inside."""

import json
import math
import re
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from skyverse.draw.drawn_world import first_view
from skyverse.draw.map_traces import from_above
from skyverse.draw.mover_traces import active_zones, mover_motions
from skyverse.draw.palette import style_sheet
from skyverse.draw.plotly_values import flat, round_step
from skyverse.draw.profile_traces import from_the_side
from skyverse.draw.scene_traces import in_space
from skyverse.draw.scenes import Scene, SceneFinding
from skyverse.draw.shape_kinds import MAX_EDGED_SHAPES
from skyverse.draw.survey_traces import survey_data
from skyverse.errors import in_words
from skyverse.model.frame import Origin
from skyverse.model.short_lines import told_clock
from skyverse.model.verdict import Verdict

MAX_SHOWN_FINDINGS = 200
NO_VALUE = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
SLIDER_STEPS = 250
_SCRIPTS = ("plotly_internals.js", "motion.js", "margins.js", "maps.js", "replans.js", "page.js")
_MAPS = """
  <section class="card map" aria-label="Map">
    <div class="bar"><h2>Map</h2><output id="where"></output></div>
    <div id="map" role="img" aria-label="The mission from above"></div>
    <p class="hint" id="mapped"></p>
  </section>
  <section class="card profile" aria-label="Altitude profile">
    <div class="bar"><h2>Altitude profile</h2>
      <label>UAV <select id="whose" aria-label="UAV of the profile"></select></label></div>
    <div class="beside" id="beside"></div>
    <div id="profile" role="img" aria-label="The flight from the side"></div>
    <p class="hint" id="sideways"></p>
  </section>"""


Parts = dict[str, str]
"""Pieces of HTML by their places in the template."""


def filled(parts: Parts, drawn: dict[str, Any]) -> str:
    """Return the page with these parts, in HTML, whose scripts draw the data; what is not given is left empty."""
    from plotly.offline import get_plotlyjs

    here = files("skyverse.draw")
    more = ("survey",) if "survey" in parts else ()
    parts = (
        {"ends": "● start, ◆ target."}
        | parts
        | {
            "data": embedded(drawn),
            "layout": _layout(drawn),
            "maps": (_MAPS if drawn["mapped"] else "") + parts.get("survey", ""),
            "frame": drawn["frame"],
            "css": style_sheet() + "".join(here.joinpath(f"{name}.css").read_text("utf-8") for name in ("page", *more)),
            "js": "".join(
                here.joinpath(name).read_text("utf-8") for name in (*_SCRIPTS, *(f"{one}.js" for one in more))
            ),
            "plotly": get_plotlyjs(),
        }
    )
    template = here.joinpath("page.html").read_text("utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts.get(found[1], ""), template)


def _layout(drawn: dict[str, Any]) -> str:
    unplanned = "" if drawn.get("planned", True) else " unplanned"
    if not drawn["mapped"]:
        kind = unplanned.strip() or ("" if drawn["search"] else "direct")
        return f' class="{kind}"' if kind else ""
    (west, south, _), (east, north, _) = drawn["extent"]
    kind = "mapped" if drawn["search"] else "mapped direct"
    return f' class="{kind}{unplanned}" style="--tall: {(north - south) / (east - west):.4f}"'


def embedded(data: Any) -> str:
    """Return `data` as JSON in which no text can end the script element that contains it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False, ensure_ascii=True)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def told_frame(origin: Origin | None) -> str:
    """Say in HTML what x, y and z are, and above what z is counted."""
    said = "x is east, y north, z up"
    if origin is None:
        return f"{said} from the scenario's own zero."
    north, east = f"{abs(origin.latitude):.5f}&deg; {'SN'[origin.latitude >= 0]}", f"{abs(origin.longitude):.5f}&deg;"
    place = f"{north}, {east} {'WE'[origin.longitude >= 0]}"
    return f"{said} from {place}, where z = 0 is {origin.altitude:,.5g} m above mean sea level."


def scene_data(scene: Scene) -> dict[str, Any]:
    """Return the data that the page's scripts draw: traces, tracks, kinds of shapes, map and profiles."""
    makespan = scene.makespan or 0.0
    drawn = {
        "space": in_space(scene),
        "extent": [scene.world.low.tolist(), scene.world.high.tolist()],
        "frame": told_frame(scene.scenario.frame.origin),
        "stretch": scene.world.stretch,
        "crowded": sum(len(kind.shapes) for kind in scene.world.kinds) > MAX_EDGED_SHAPES,
        "mapped": scene.world.mapped,
        "kinds": [
            {
                "title": kind.title if scene.world.mapped else f"{kind.name.capitalize()}s",
                "hard": kind.hard,
                "colour": kind.colour,
                "solid": kind.solid,
            }
            for kind in scene.world.kinds
        ],
        "movers": mover_motions(scene),
        "active": active_zones(scene),
        "separations": [list(axes) for axes in scene.separations],
        "errors": [[track.error.horizontal, track.error.vertical] for track in scene.tracks],
        "makespan": makespan,
        "step": slider_step(makespan),
        "tracks": [
            {
                "name": track.name,
                "colour": track.colour,
                "start": list(track.start),
                "times": flat(track.times),
                "positions": [flat(track.positions[:, axis]) for axis in range(3)],
            }
            for track in scene.tracks
        ],
    }
    if scene.world.mapped:
        overview = first_view(scene.world, scene.tracks, scene.scenario.terrain)
        drawn |= {"map": from_above(scene), "profiles": from_the_side(scene), "overview": overview}
    if scene.surveys:
        drawn |= {"surveys": survey_data(scene)}
    return drawn


def slider_step(makespan: float) -> float:
    """Return the slider's step: a round number of seconds that divides the flight into about `SLIDER_STEPS` steps."""
    return float(f"{round_step(makespan / SLIDER_STEPS):.3g}") if makespan > 0 else 1.0


# ---- pieces of a page: numbers, tiles, tables, cards and facts ----
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


TONES = {Verdict.PROVEN: "good", Verdict.REFUTED: "bad", Verdict.UNDECIDED: "warn"}
"""The tone in which a verdict is told."""
SIGNS = {"good": "✓", "warn": "!", "bad": "✕", "note": "i"}
"""The sign of each tone."""


def card(tone: str, heading: str, body: str) -> str:
    """Return a card of a tone of `SIGNS`; heading and body in HTML."""
    return (
        f'<section class="verdict {tone}"><span class="sign" aria-hidden="true">{SIGNS[tone]}</span>'
        f"<div><h2>{heading}</h2>{body}</div></section>"
    )


def listed_sentences(sentences: Iterable[str]) -> str:
    """Return sentences as a list in HTML."""
    return f"<ul>{''.join(f'<li>{escape(in_words(one))}</li>' for one in sentences)}</ul>"


def verdict(tone: str, heading: str, said: str, findings: Sequence[SceneFinding] = (), told: str = "") -> Parts:
    """Return the parts of a page that say what was found: one banner, and the cards below the picture.

    `heading` and `said` are plain text. Of several `findings` the banner tells the first, and a card all; other cards,
    in HTML, are `told`.
    """
    lines = [finding_line(one) for one in findings[:MAX_SHOWN_FINDINGS]]
    first = f"<ul>{lines[0]}</ul>" if lines else ""
    if len(lines) > 1:
        rest = len(findings) - len(lines)
        more = f"<p>… and {rest:,} more.</p>" if rest else ""
        told = card("bad", "All that is wrong.", f"<ul>{''.join(lines)}</ul>{more}") + told
    below = '<p><a href="#told">More below the picture</a></p>' if told else ""
    return {"banner": card(tone, escape(heading), f"<p>{escape(said)}</p>{first}{below}"), "told": told}


def finding_line(finding: SceneFinding) -> str:
    """Return one finding as a list item, with a button that shows the scene at its time."""
    parts = [f'<span class="kind">{escape(finding.kind)}</span>']
    if finding.uavs:
        parts.append(f"<b>{escape(', '.join(finding.uavs))}</b>")
    parts.append(escape(finding.message))
    if finding.time is not None and math.isfinite(finding.time):
        t = finding.time
        clock = f" ({told_clock(t)} min)" if t >= 60 else ""
        parts.append(f'<button type="button" class="jump" data-time="{t:.6g}">show t = {t:.2f} s{clock}</button>')
    return f'<li class="{finding.severity}">{" ".join(parts)}</li>'


def facts_list(facts: dict[str, str]) -> str:
    """Return named facts for the foot of the page."""
    return "".join(f"<div><dt>{name}</dt><dd>{escape(fact)}</dd></div>" for name, fact in facts.items())
