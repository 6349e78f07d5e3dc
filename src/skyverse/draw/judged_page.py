"""Missions of autopilots that were judged, as one web page: what is wrong, where, and what was judged."""

from dataclasses import dataclass
from html import escape

from skyverse._version import __version__
from skyverse.draw.margin_traces import told
from skyverse.draw.scenes import Scene
from skyverse.draw.template import (
    Parts,
    card,
    facts_list,
    filled,
    listed_sentences,
    scene_data,
    table,
    tiles,
    verdict,
)
from skyverse.model.caution import stands_out
from skyverse.model.short_lines import counted

_LINES = (
    "Numbers: items, as ground stations count them. Red: legs that fail, with a dot where that is worst. Amber: from "
    "where no return is proven. Rings: what else is wrong. Squares: where it lands when it returns."
)
_MEND = "Where a greater height helps, it is told. skyverse repair mends what it can."
_WORDS = {"layers": {"trajectories": "Flights"}, "iterations": "", "value": "", "log": False}


@dataclass(frozen=True, eq=False, kw_only=True)
class JudgedScene(Scene):
    """All that a picture of judged missions shows.

    The `verdict` says in words what is found of all. The `verdicts` are the heads and rows of the table of what was
    judged, a column for each mission. The `cautions` are what a pilot must heed; the `notes` are what was taken for
    granted. The `figures` are a name, a value and what it is about each.
    """

    verdict: str
    verdicts: tuple[tuple[str, ...], ...]
    cautions: tuple[str, ...]
    notes: tuple[str, ...]
    figures: tuple[tuple[str, str, str], ...]


def judged_page(scene: JudgedScene) -> str:
    """Return the page of judged missions, in which every string that a user gave is escaped."""
    _, *rows = scene.verdicts
    body = [f'<tr><th scope="row">{escape(name)}</th>{"".join(map(_cell, cells))}</tr>' for name, *cells in rows]
    heads = [(escape(head), "") for head in scene.verdicts[0]]
    names = ", ".join(track.name for track in scene.tracks)
    parts = {
        "title": escape(names),
        "description": "Judged as its autopilot flies it."
        if len(scene.tracks) == 1
        else "Judged as autopilots fly them.",
        "tiles": tiles((escape(name), escape(value), escape(note)) for name, value, note in scene.figures),
        "space": "Flight",
        "ends": "● home.",
        "lines": f"{_LINES} {told(scene)}",
        "numbers": "What was judged",
        "table": table("", heads, body, text_columns=len(heads)),
        "footer": facts_list({"skyverse": __version__}),
    } | _found(scene)
    return filled(parts, scene_data(scene) | {"search": [], "words": _WORDS})


def _cell(said: str) -> str:
    return f'<td class="text{" doubt" if stands_out(said) else ""}">{escape(said)}</td>'


def _found(scene: JudgedScene) -> Parts:
    found, told = scene.findings, ""
    if scene.cautions:
        told += card("warn", "What a pilot must heed.", listed_sentences(scene.cautions))
    if scene.notes:
        told += card("note", "What the files do not say.", listed_sentences(scene.notes))
    if found:
        said = f"No go: {counted(len(found), 'thing')} {'is' if len(found) == 1 else 'are'} wrong."
        return verdict("bad", said, _MEND, found, told)
    tone = "good" if scene.verdict == "proven" else "warn"
    return verdict(tone, f"Go: {scene.verdict}.", "What is proven is so at every place between waypoints.", (), told)
