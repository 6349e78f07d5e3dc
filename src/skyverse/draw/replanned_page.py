"""A replanned flight as one web page that works offline: what was seen, held and committed to, and every answer."""

from html import escape
from typing import Any

from skyverse.draw.flight_page import FLIGHT_WORDS, metres, tracking_errors
from skyverse.draw.margin_traces import told
from skyverse.draw.page import filled, scene_data
from skyverse.draw.page_parts import (
    MAX_SHOWN_FINDINGS,
    NO_VALUE,
    card,
    facts_list,
    finding_line,
    table,
    tiles,
    uav_row,
)
from skyverse.draw.plotly_values import Trace
from skyverse.draw.replanned_scene import ReplannedScene
from skyverse.draw.replanned_traces import replanned_in_space, replans_data
from skyverse.model.disturbances import told_weather
from skyverse.model.replanned_flight import ReplannedFlight
from skyverse.model.verdict import Verdict

MARKS = 2
"""Traces that stand last in space: the trail and the UAVs, which nothing may hide."""
_HEADS = (
    ("UAV", ""),
    ("Target", ""),
    ("Arrival", "seconds into the mission"),
    ("Replaced", "answers that replaced what was being flown"),
    ("No way out", "answers without a proven way out"),
    ("Largest error", "largest distance from what was commanded"),
    ("To obstacles", "smallest distance, as flown, to an obstacle as given"),
    ("To movers", "smallest distance, as flown, to a mover as it truly was"),
)


def replanned_page(flight: ReplannedFlight) -> str:
    """Return the page of a replanned flight; every string of the user's is escaped."""
    drawn = ReplannedScene(flight)
    scene = drawn.scene
    parts = {
        "title": f"{escape(scene.scenario.name)}, replanned in flight",
        "description": escape(" ".join([flight.sensor.sentence, flight.flight.vehicle_sentence])),
        "tiles": _tiles(flight),
        "banner": _banner(drawn),
        "space": "Flight",
        "still": "Nothing was flown.",
        "lines": "Coloured: flown so far; grey, dotted: as planned. Ahead of a UAV: the way that it is committed to, "
        f"and, dotted, its way out, on which it brakes to rest. {told(scene)}",
        "chart": "Tracking error",
        "axis": "",
        "curves": "Distance of each UAV from what was commanded, over time",
        "dashed": "",
        "numbers": "As flown",
        "table": _table(drawn),
        "details": "",
        "footer": _footer(flight),
    }
    data: dict[str, Any] = scene_data(scene)
    traces: list[Trace] = data["space"]
    data["space"] = [*traces[:-MARKS], *replanned_in_space(drawn), *traces[-MARKS:]]
    for profile in data.get("profiles", ()):  # worlds of plain boxes have none
        for line in profile["traces"]:
            if line["meta"]["role"] == "planned":
                line["name"] = line["name"].replace("as planned", "as commanded")
    words = FLIGHT_WORDS | {"layers": {"paths": "As commanded", "trajectories": "As flown"}}
    data |= {"replans": replans_data(drawn), "search": tracking_errors(flight.flight, scene), "words": words}
    return filled(parts, data)


def _tiles(flight: ReplannedFlight) -> str:
    nearest, last = flight.nearest, max((end for end in flight.arrivals if end is not None), default=None)
    shown = [
        ("Arrival", NO_VALUE if last is None else f"{last:.2f} s", f"planned: {flight.mission.makespan:.2f} s"),
        ("Answers", f"{sum(len(step.answers) for step in flight.steps):,}", f"{flight.replanned:,} replaced"),
        ("No way out", f"{flight.without_way_out:,}", "answers without a proven one"),
        ("To movers", NO_VALUE if nearest is None else metres(nearest.distance), "least, as flown"),
        ("To obstacles", metres(min(one.clearance for one in flight.flown if one is not None)), "least, as flown"),
        ("Largest error", metres(flight.flight.largest), "from what was commanded"),
    ]
    return tiles(shown)


def _banner(drawn: ReplannedScene) -> str:
    flight = drawn.flight
    if flight.flight.stands_in:
        verdict = card("note", "i", "Another vehicle was flown.", f"<p>{escape(flight.sentence)}</p>")
    elif flight.safe:
        said = flight.sentence.removeprefix("Safe as flown: ")
        verdict = card("good", "✓", "Safe as flown.", f"<p>{escape(said[:1].upper() + said[1:])}</p>")
    else:
        lines = "".join(finding_line(finding) for finding in drawn.scene.findings[:MAX_SHOWN_FINDINGS])
        verdict = card("bad", "✕", "This flight is not safe.", f"<ul>{lines}</ul>")
    found = flight.certificate
    if found is None:
        return verdict + card("note", "i", "What was commanded", f"<p>{escape(flight.proof_sentence)}</p>")
    tone, sign = ("good", "✓") if found.verdict is Verdict.PROVEN else ("warn", "!")
    return verdict + card(tone, sign, "What was commanded", f"<p>{escape(flight.proof_sentence)}</p>")


def _table(drawn: ReplannedScene) -> str:
    flight, rows = drawn.flight, []
    for uav, (track, flown) in enumerate(zip(drawn.scene.tracks, flight.flown, strict=True)):
        answers = [step.answers[uav] for step in flight.steps]
        near = [one.distance for one in flight.approaches if one.uav == uav]
        arrival = flight.arrivals[uav]
        cells = [
            NO_VALUE if arrival is None else f"{arrival:.2f} s",
            f"{sum(not answer.kept for answer in answers):,}",
            f"{sum(not answer.proven for answer in answers):,}",
            metres(None if flown is None else flown.largest),
            metres(None if flown is None else flown.clearance),
            metres(min(near, default=None)),
        ]
        target = NO_VALUE if track.target_name is None else escape(track.target_name)
        rows.append(uav_row(track.name, track.colour, (target,), cells))
    return table(escape(flight.replans_sentence), _HEADS, rows, text_columns=2)


def _footer(flight: ReplannedFlight) -> str:
    made, flown = flight.mission.provenance, flight.flight
    return facts_list(
        {
            "Scenario": flight.truth.name,
            "Planner": made.planner,
            "Vehicle": flown.vehicle,
            "Weather": told_weather(flown.wind, flown.noise, flown.disturbances, flown.seed),
            "Sensor": flight.sensor.sentence,
            "Lead": f"{flight.lead:g} s",
            "Horizon": f"{flight.horizon:.3g} s",
            "skyverse": made.skyverse,
            "Platform": made.platform,
        }
    )
