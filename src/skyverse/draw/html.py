"""A mission as one web page that works offline: flight in 3-D, convergence, costs and gaps, verdict."""

import json
import math
import re
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from skyverse.atomic import write_text
from skyverse.draw import table
from skyverse.draw.encoded import flat
from skyverse.draw.map_traces import from_above
from skyverse.draw.profile_traces import from_the_side
from skyverse.draw.scene import Finding, Scene, scene
from skyverse.draw.traces import in_space, of_search
from skyverse.model.mission import Mission

SHOWN_FINDINGS = 200
SLIDER_STEPS = 250
CROWDED = 300
"""More shapes than this have thinner edges."""


def write_html(mission: Mission, path: Path) -> None:
    """Write `mission` as one self-contained page.

    Raises
    ------
    InputError
        Where the folder does not exist or the file cannot be written.
    """
    write_text(Path(path), page(scene(mission)))


_AXIS = """
        <button type="button" data-axis="iterations" aria-pressed="true">Iterations</button>
        <button type="button" data-axis="paths" aria-pressed="false">Generated paths</button>
      """
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
_WORDS = {
    "layers": {"paths": "Paths", "trajectories": "Trajectories"},
    "iterations": "iteration",
    "paths": "generated paths",
    "value": "best cost so far",
    "log": True,
}
"""What the page's script calls layers and axes, and whether its chart may be logarithmic."""


def page(scene: Scene) -> str:
    """Return the page of `scene`; every string of the user's is escaped."""
    parts = {
        "title": escape(scene.scenario.name),
        "description": escape(scene.scenario.description),
        "tiles": table.tiles(scene),
        "banner": banner(scene),
        "lines": "Thick lines: trajectories; thin lines: the paths as planned.",
        "chart": "Convergence",
        "axis": _AXIS,
        "curves": "Best cost so far of each search",
        "dashed": f"Solid: best cost so far. Dashed: the {scene.bound}.",
        "numbers": "Costs and gaps",
        "table": table.table(scene),
        "footer": footer(scene),
    }
    return filled(parts, data(scene) | {"search": of_search(scene), "words": _WORDS})


def filled(parts: dict[str, str], drawn: dict[str, Any]) -> str:
    """Return the page of those parts, in HTML, that draws this data."""
    from plotly.offline import get_plotlyjs

    here = files("skyverse.draw")
    parts = parts | {
        "data": embedded(drawn),
        "layout": _layout(drawn),
        "maps": _MAPS if drawn["mapped"] else "",
        "css": here.joinpath("page.css").read_text("utf-8"),
        "js": "".join(here.joinpath(name).read_text("utf-8") for name in ("motion.js", "maps.js", "page.js")),
        "plotly": get_plotlyjs(),
    }
    template = here.joinpath("page.html").read_text("utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], template)


def _layout(drawn: dict[str, Any]) -> str:
    if not drawn["mapped"]:
        return ""
    (west, south, _), (east, north, _) = drawn["extent"]
    kind = "mapped" if drawn["search"] else "mapped direct"
    return f' class="{kind}" style="--tall: {(north - south) / (east - west):.4f}"'


def embedded(data: Any) -> str:
    """Return JSON that no text in it can break out of a script element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False, ensure_ascii=True)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def data(scene: Scene) -> dict[str, Any]:
    """Return what the page's script draws in space."""
    makespan = scene.totals.makespan or 0.0
    drawn = {
        "space": in_space(scene),
        "extent": [scene.world.low.tolist(), scene.world.high.tolist()],
        "stretch": scene.world.stretch,
        "crowded": sum(len(kind.shapes) for kind in scene.world.kinds) > CROWDED,
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
        drawn |= {"map": from_above(scene), "profiles": from_the_side(scene)}
    return drawn


def slider_step(makespan: float) -> float:
    """Return a round number of seconds that divides the flight into about `SLIDER_STEPS` steps."""
    if makespan <= 0:
        return 1.0
    raw = makespan / SLIDER_STEPS
    decade = 10.0 ** math.floor(math.log10(raw))
    return float(next(f"{n * decade:.3g}" for n in (1, 2, 5, 10) if n * decade >= raw * (1 - 1e-9)))


def banner(scene: Scene) -> str:
    """Return the referee's verdict, then what is missing from the mission."""
    found = scene.findings
    if not found:
        verdict = card("good", "✓", "The referee found nothing wrong.", _what_was_judged(scene))
    else:
        tone = "bad" if any(finding.severity == "error" for finding in found) else "warn"
        things = "1 thing" if len(found) == 1 else f"{len(found):,} things"
        lines = "".join(line(finding) for finding in found[:SHOWN_FINDINGS])
        rest = len(found) - SHOWN_FINDINGS
        more = f"<p>… and {rest:,} more in the mission's file.</p>" if rest > 0 else ""
        verdict = card(
            tone,
            "✕" if tone == "bad" else "!",
            f"The referee found {things} wrong.",
            f"<ul>{lines}</ul>{more}",
        )
    if scene.interrupted:
        verdict += card("warn", "❚❚", "This mission was interrupted.", "<p>What was found until then is shown.</p>")
    if scene.notes:
        lines = "".join(f"<li>{escape(note)}</li>" for note in scene.notes)
        if scene.complete:
            verdict += card("note", "i", "Some UAVs have no target.", f"<ul>{lines}</ul>")
        else:
            verdict += card("warn", "!", "The mission is not complete.", f"<ul>{lines}</ul>")
    return verdict


def _what_was_judged(scene: Scene) -> str:
    flights = sum(track.arrival is not None for track in scene.tracks)
    if flights == 0:
        return "<p>There are no trajectories; it judged the paths alone.</p>"
    things = "1 trajectory" if flights == 1 else f"{flights} trajectories"
    proven = " At every instant they are clear of obstacles, in bounds, within limits and apart: this is proven."
    return f"<p>It judged {things}, not only the paths.{proven if scene.proven else ''}</p>"


def card(tone: str, sign: str, heading: str, body: str) -> str:
    """Return a card above the picture: ``good``, ``warn``, ``bad`` or ``note``; heading and body in HTML."""
    return (
        f'<section class="verdict {tone}"><span class="sign" aria-hidden="true">{sign}</span>'
        f"<div><h2>{heading}</h2>{body}</div></section>"
    )


def line(finding: Finding) -> str:
    """Return one finding, with a button that shows its instant."""
    parts = [f'<span class="kind">{escape(finding.kind)}</span>']
    if finding.uavs:
        parts.append(f"<b>{escape(', '.join(finding.uavs))}</b>")
    parts.append(escape(finding.message))
    if finding.time is not None and math.isfinite(finding.time):
        t = finding.time
        parts.append(f'<button type="button" class="jump" data-time="{t:.6g}">show t = {t:.2f} s</button>')
    return f'<li class="{finding.severity}">{" ".join(parts)}</li>'


def footer(scene: Scene) -> str:
    """Return where the answer came from: enough to make it again."""
    made = scene.provenance
    return listed(
        {
            "Scenario": scene.scenario.name,
            "Planner": made.planner,
            "Stop": made.stop,
            "Seed": "none" if made.seed is None else str(made.seed),
            "skyverse": made.skyverse,
            "Platform": made.platform,
        }
    )


def listed(facts: dict[str, str]) -> str:
    """Return facts by name for the foot of the page."""
    return "".join(f"<div><dt>{name}</dt><dd>{escape(fact)}</dd></div>" for name, fact in facts.items())
