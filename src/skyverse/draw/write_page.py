"""Missions and scenarios written as web pages."""

import math
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from skyverse._version import __version__
from skyverse.atomic import write_text
from skyverse.draw.mission_page import page
from skyverse.draw.scenes import Scene, scenario_scene, scene
from skyverse.draw.template import (
    Parts,
    facts_list,
    filled,
    number,
    scene_data,
    table,
    tiles,
    uav_row,
    verdict,
)
from skyverse.draw.track import Point
from skyverse.errors import require_kind
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.quantities import short
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.model.timed_shapes import temporary_zones


def write_html(mission: Mission | Scenario, path: str | Path) -> None:
    """Write a mission as one self-contained web page, or a scenario before anything is planned.

    The page of a scenario shows its obstacles, zones, ground, starts and targets, and marks those that are not safe.

    Raises
    ------
    InputError
        If it is neither, the folder does not exist or the file cannot be written.
    """
    require_kind(mission, (Mission, Scenario), "mission")
    require_kind(path, (str, Path), "path")
    text = scenario_page(scenario_scene(mission)) if isinstance(mission, Scenario) else page(scene(mission))
    write_text(Path(path), text)


_WORDS = {"layers": {}, "iterations": "", "value": "", "log": False}
TIMES = " \N{MULTIPLICATION SIGN} "


def scenario_page(drawn: Scene) -> str:
    """Return the page of a scenario's scene, in which every string that a user gave is escaped."""
    scenario = drawn.scenario
    parts = {
        "title": escape(scenario.name),
        "description": escape(scenario.description),
        "tiles": _tiles(scenario),
        "space": "Space",
        "still": "Nothing is planned yet.",
        "lines": "Rings mark starts and targets that are not safe." if drawn.findings else "",
        "numbers": "Starts and targets",
        "table": _table(drawn),
        "footer": _footer(scenario),
    } | _found(drawn)
    return filled(parts, scene_data(drawn) | {"search": [], "words": _WORDS, "planned": False})


def _tiles(scenario: Scenario) -> str:
    low, high, step = scenario.bounds.min, scenario.bounds.max, scenario.lattice.step
    sizes = [b - a for a, b in zip(low, high, strict=True)]
    nodes = math.prod(int(size / one + 1e-9) + 1 for size, one in zip(sizes, step, strict=True))
    ground = "no terrain" if scenario.terrain is None else "over a terrain"
    shown = [
        ("UAVs", f"{len(scenario.uavs):,}", counted(len(scenario.targets), "target")),
        ("Obstacles", f"{len(scenario.obstacles):,}", f"kept away from by {scenario.clearance:g} m"),
        ("Zones", f"{len(scenario.zones):,}", "may be entered, at a risk, slowly or at times"),
        ("Bounds", TIMES.join(f"{size:,.6g}" for size in sizes), f"metres, {ground}"),
        ("Lattice", f"{nodes:,}", f"nodes, {TIMES.join(f'{one:g}' for one in step)} m apart"),
    ]
    return tiles(shown)


def _found(drawn: Scene) -> Parts:
    """Return the parts that say whether all starts and targets are safe, and how each of the others is not."""
    found = drawn.findings
    ends = len(drawn.scenario.uavs) + len(drawn.scenario.targets)
    if found:
        said = f"{len(found):,} of {ends:,} starts and targets {'is' if len(found) == 1 else 'are'} not safe."
        return verdict("bad", said, "", found)
    if not ends:
        return verdict("note", "There are no UAVs and no targets.", "They can be given when it is planned.")
    said = f"They are in bounds and {drawn.scenario.clearance:g} m or more from every obstacle."
    if temporary_zones(drawn.scenario):
        said += " Zones with active times were not looked at: the referee judges flights and stays among them."
    return verdict("good", "All starts and targets are safe.", said)


def _table(drawn: Scene) -> str:
    scenario = drawn.scenario
    unsafe = {(finding.kind, finding.uavs) for finding in drawn.findings}
    ends = [("start", track.name, track.colour, track.start) for track in drawn.tracks]
    ends += [("target", target.name, drawn.spare_colour, target.position) for target in scenario.targets]
    columns: list[tuple[str, str]] = [("x", "east, metres"), ("y", "north, metres"), ("z", "up, metres")]
    columns += [("Above ground", "height above the terrain")] if scenario.terrain is not None else []
    columns += (
        [("Latitude, longitude", "WGS84"), ("Altitude", "above sea")] if scenario.frame.origin is not None else []
    )
    rows = [
        uav_row(name, colour, (kind, _pill((kind, (name,)) not in unsafe)), _cells(scenario, place))
        for kind, name, colour, place in ends
    ]
    heads = [("Name", ""), ("What", ""), ("Safe", ""), *columns]
    return table("Metres in the local frame: x is east, y north, z up.", heads, rows, text_columns=3)


def _cells(scenario: Scenario, place: Point) -> Sequence[str]:
    cells = [number(value) for value in place]
    if scenario.terrain is not None:
        cells.append(f"{number(place[2] - float(scenario.terrain.height(np.array(place[:2]))), 1)} m")
    if scenario.frame.origin is not None:
        latitude, longitude, altitude = to_wgs84(scenario.frame.origin, [place])[0]
        cells += [f"{number(latitude, 6)}, {number(longitude, 6)}", f"{number(altitude, 1)} m"]
    return cells


def _pill(safe: bool) -> str:
    return f'<span class="pill {"good" if safe else "bad"}">{"safe" if safe else "not safe"}</span>'


def _footer(scenario: Scenario) -> str:
    sources = "; ".join(
        f"{source.file} ({source.gives}; {source.licence or 'licence unknown'})" for source in scenario.sources
    )
    facts = {
        "Scenario": f"{scenario.name} ({short(scenario.digest)})",
        "Clearance": f"{scenario.clearance:g} m, above ground {scenario.ground_clearance:g} m",
        "skyverse": __version__,
    }
    if scenario.max_height is not None:
        facts["Ceiling"] = f"{scenario.max_height:g} m above ground"
    return facts_list(facts | ({"Sources": sources} if sources else {}))
