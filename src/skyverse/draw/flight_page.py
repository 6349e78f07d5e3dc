"""A flight as one web page that works offline: planned and flown motion, tracking errors, and the verdict."""

import math
from collections.abc import Callable
from html import escape
from typing import Any

import numpy as np

from skyverse.draw.margin_traces import told
from skyverse.draw.plotly_values import Trace, flat, plain, trace
from skyverse.draw.scenes import SAMPLE_STRIDE, MissionScene, flight_scene
from skyverse.draw.template import (
    MINUS,
    NO_VALUE,
    Parts,
    card,
    facts_list,
    filled,
    listed_sentences,
    scene_data,
    table,
    tiles,
    uav_row,
    verdict,
)
from skyverse.model.flight_record import Flight, Flown
from skyverse.model.replanned_flight import ReplannedFlight
from skyverse.model.short_lines import told_metres

FLIGHT_WORDS = {
    "layers": {"paths": "As planned", "trajectories": "As flown"},
    "seconds": "seconds into the mission",
    "iterations": "seconds into the mission",
    "value": "tracking error (m)",
    "log": False,
}
_COLUMNS: tuple[tuple[str, str, Callable[[Flown], str]], ...] = (
    ("Flight", "seconds flown", lambda flown: f"{flown.times[-1] - flown.times[0]:.2f} s"),
    ("RMS error", "root mean square of the tracking error", lambda flown: f"{flown.rms:,.3f} m"),
    ("Largest error", "largest tracking error", lambda flown: f"{flown.largest:,.3f} m"),
    ("Clearance", "smallest distance to an obstacle as given", lambda flown: metres(flown.clearance)),
    ("Above ground", "least height above the ground", lambda flown: metres(flown.above_ground)),
    ("Mean thrust", "share of the most", lambda flown: f"{flown.mean_thrust:.0%}"),
    ("Peak thrust", "share of the most", lambda flown: f"{flown.peak_thrust:.0%}"),
    ("Peak tilt", "degrees between thrust and the vertical", lambda flown: f"{flown.peak_tilt:.0f}°"),
    ("Energy", "mechanical work of the rotors", lambda flown: f"{flown.energy:,.0f} J"),
)
"""The columns of the table: what stands above them, the tooltip of that, and what is written of a UAV."""


def flight_page(flight: Flight) -> str:
    """Return the page of `flight`; every string of the user's is escaped."""
    drawn = flight_scene(flight)
    parts = {
        "title": f"{escape(drawn.scenario.name)}, flown",
        "description": escape(" ".join([drawn.scenario.description, _told(flight)])),
        "tiles": _tiles(flight),
        "space": "Flight",
        "still": "This mission has no trajectories; the paths are shown as planned.",
        "lines": f"Thick lines: as flown; thin lines: as planned. {told(drawn)}",
        "chart": "Tracking error",
        "curves": "Distance of each UAV from its trajectory, over time",
        "numbers": "As flown",
        "table": _table(flight, drawn),
        "footer": flown_footer(flight),
    } | flown_verdict(flight, drawn, _below(flight))
    return filled(parts, scene_data(drawn) | {"search": tracking_errors(flight, drawn), "words": FLIGHT_WORDS})


def _told(flight: Flight) -> str:
    return f"Flown in rotorpy with {flight.conditions.sentence}. {flight.vehicle_sentence}"


def _tiles(flight: Flight) -> str:
    flown = [f for f in flight.flown if f is not None]
    nearest = min(f.clearance for f in flown)
    closest = min((passing.nearness or 0.0 for passing in flight.passings), default=None)
    rms = math.sqrt(sum(f.rms**2 * len(f.times) for f in flown) / sum(len(f.times) for f in flown))
    heights = [f.above_ground for f in flown if f.above_ground is not None]
    low = [("Above ground", metres(min(heights)), "least height")] if heights else []
    shown = [
        ("Largest error", f"{flight.largest:,.3f} m", f"RMS {rms:,.3f} m"),
        ("Clearance", metres(nearest), "to an obstacle as given"),
        *low,
        ("Separation", NO_VALUE if closest is None else f"{closest:.2f}", "1 is the separation asked for"),
        ("Makespan", f"{flight.mission.makespan:.2f} s", "as planned"),
        ("Energy", f"{sum(f.energy for f in flown):,.0f} J", "mechanical work of the rotors"),
    ]
    return tiles(shown)


def flown_verdict(flight: Flight | ReplannedFlight, drawn: MissionScene, told: str, *, proven: bool = True) -> Parts:
    """Return the parts that say whether a flight was safe, and, if it was, whether what was commanded is `proven`."""
    if (flight.flight if isinstance(flight, ReplannedFlight) else flight).stands_in:
        return verdict("note", "Another vehicle was flown.", flight.sentence, told=told)
    if not flight.safe:
        return verdict("bad", "This flight is not safe.", "", drawn.findings, told)
    said = flight.sentence.partition(": ")[2]
    heading = "This flight is safe." if proven else "This flight is safe, but what was commanded is not all proven."
    return verdict("good" if proven else "warn", heading, said[:1].upper() + said[1:], told=told)


def _below(flight: Flight) -> str:
    told = ""
    if flight.rounds:
        told += card("note", "The mission was made easier until it was safe.", listed_sentences(flight.rounds))
    fleet = zip(flight.mission.scenario.uavs, flight.flown, flight.mission.trajectories, strict=True)
    left = [uav.name for uav, flown, trajectory in fleet if flown is None and trajectory is not None]
    if left:
        told += card("note", "Not flown:", f"<p>{escape(', '.join(left))}, as an aeroplane; shown as planned.</p>")
    return told


def _table(flight: Flight, drawn: MissionScene) -> str:
    level = drawn.scenario.terrain is None
    shown = [column for column in _COLUMNS if not (level and column[0] == "Above ground")]
    rows = []
    for track, flown in zip(drawn.tracks, flight.flown, strict=True):
        target = NO_VALUE if track.target_name is None else escape(track.target_name)
        cells = [NO_VALUE if flown is None else written(flown) for _, _, written in shown]
        rows.append(uav_row(track.name, track.colour, (target,), cells))
    heads = [("UAV", ""), ("Target", ""), *((title, tooltip) for title, tooltip, _ in shown)]
    caption = "Errors: distance from where the trajectory is at the same time. Thrust: share of the vehicle's most."
    return table(caption, heads, rows, text_columns=2)


def metres(value: float | None) -> str:
    """Return a distance as it stands on pages; a dash for ``None`` and infinity."""
    return NO_VALUE if value is None or value == math.inf else told_metres(value).replace("-", MINUS)


def tracking_errors(flight: Flight, drawn: MissionScene) -> list[Trace]:
    """Return the traces of the chart: each UAV's tracking error over time."""
    traces: list[Trace] = []
    for track, flown in zip(drawn.tracks, flight.flown, strict=True):
        if flown is not None:
            times: Any = flat(flown.times[::SAMPLE_STRIDE])
            errors = np.linalg.norm(flown.positions - flown.commanded, axis=1)[::SAMPLE_STRIDE]
            hover = "%{fullData.name}<br>%{y:.3f} m at %{x:.2f} s<extra></extra>"
            points, meta = {"x": times, "y": flat(errors)}, {"role": "error", "iterations": times}
            line = {"color": track.colour, "width": 1.5}
            traces.append(trace("scatter", "lines", plain(track.name), points, hover, meta, line=line))
    return traces


def flown_footer(flight: Flight, more: dict[str, str] | None = None) -> str:
    """Return what a flight was made with, and what `more` is to be told of that."""
    made = flight.mission.provenance
    facts = {
        "Scenario": flight.mission.scenario.name,
        "Planner": made.planner,
        "Vehicle": flight.vehicle,
        "Weather": flight.conditions.told(flight.seed),
    }
    return facts_list(facts | (more or {}) | {"skyverse": made.skyverse, "Platform": made.platform})
