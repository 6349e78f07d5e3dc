"""A replanned flight as one web page that works offline: what was seen, held and committed to, and every answer."""

from html import escape
from typing import Any

import numpy as np

from skyverse.draw.flight_page import FLIGHT_WORDS, flown_footer, flown_verdict, metres, tracking_errors
from skyverse.draw.margin_traces import told
from skyverse.draw.plotly_values import NOWHERE, Trace, columns, flat, mesh, plain, trace
from skyverse.draw.replanned_scene import CommittedWay, ReplannedScene
from skyverse.draw.shape_geometry import DrawnShape, footprint, outline, surface
from skyverse.draw.template import (
    NO_VALUE,
    card,
    filled,
    scene_data,
    table,
    tiles,
    uav_row,
)
from skyverse.model.replanned_flight import Prediction, ReplannedFlight
from skyverse.model.shapes import Voxels
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
        "space": "Flight",
        "still": "Nothing was flown.",
        "lines": "Coloured: flown so far; grey, dotted: as planned. Ahead of a UAV: the way that it is committed to, "
        f"and, dotted, its way out, on which it brakes to rest. {told(scene)}",
        "chart": "Tracking error",
        "curves": "Distance of each UAV from what was commanded, over time",
        "numbers": "As flown",
        "table": _table(drawn),
        "footer": flown_footer(
            flight.flight,
            {
                "Sensor": flight.sensor.sentence,
                "Lead": f"{flight.lead:g} s",
                "Horizon": f"{flight.horizon:.3g} s",
            },
        ),
    }
    proven = flight.certificate is None or flight.certificate.verdict is Verdict.PROVEN
    below = card("note" if proven else "warn", "What was commanded", f"<p>{escape(flight.proof_sentence)}</p>")
    parts |= flown_verdict(flight, scene, below, proven=proven)
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


def _table(drawn: ReplannedScene) -> str:
    flight, rows = drawn.flight, []
    for uav, (track, flown) in enumerate(zip(drawn.scene.tracks, flight.flown, strict=True)):
        answers = [step.answers[uav] for step in flight.steps]
        near = [one.distance for one in flight.approaches if one.uavs == (uav,)]
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


PAGE_STRIDE = 2
"""One sample of a committed way in this many is written."""
LETTERS = {"kept": "k", "replaced": "r", "no way out": "n"}


def replanned_in_space(drawn: ReplannedScene) -> list[Trace]:
    """Return the traces of what was planned and unknown, and empty ones that the page fills in."""
    planned = [
        trace("scatter3d", "lines", f"{plain(name)}: as planned", columns(line), None, role, line={})
        for uav, (name, line) in enumerate(drawn.planned)
        if len(line) and (role := {"role": "planned", "uav": uav})
    ]
    unknown = [each for wall, when in zip(drawn.unknown, drawn.seen, strict=True) for each in _unknown(wall, when)]
    names = {"doubt": "Where movers may be", "committed": "Committed way", "out": "Way out"}
    names |= {"sensor": "Sensor range"} if drawn.flight.sensor.range else {}
    moving = [trace("scatter3d", "lines", name, NOWHERE, None, {"role": role}, line={}) for role, name in names.items()]
    return [*planned, *unknown, *moving]


def replans_data(drawn: ReplannedScene) -> dict[str, Any]:
    """Return what the page moves: observations, predictions, committed ways, answers and unknown obstacles.

    A prediction is a row: the mover's number, the instant of its last sighting, its place (3) and velocity (3) then,
    and its doubt's radius, growth and acceleration, and for how many seconds it accelerates.
    """
    steps = drawn.flight.steps
    return {
        "horizon": drawn.flight.horizon,
        "range": drawn.flight.sensor.range,
        "arrivals": flat(drawn.arrivals),
        "predictions": [[_row(one) for one in step.predictions] for step in steps],
        "ways": [[_way(way) for way in own] for own in drawn.committed],
        "ticks": ["".join(LETTERS[tick] for _, tick in own) for own in drawn.ticks],
        "sentences": [[answer.sentence for answer in step.answers] for step in steps],
        "seen": list(drawn.seen),
        "unknown": [[np.round(ring, 3).tolist() for ring in footprint(wall)] for wall in drawn.unknown],
    }


def _unknown(wall: DrawnShape, when: float | None) -> list[Trace]:
    """Return the edges of an obstacle that nobody knew of, and its faces, which are shown once it is seen."""
    corners, triangles = surface(wall)
    faces = mesh("Unknown obstacle", corners, triangles, {"role": "unknown", "seen": when})
    if isinstance(wall, Voxels):
        return [faces]
    edges = trace("scatter3d", "lines", "Unknown obstacle", columns(outline(wall)), None, {"role": "ghost"}, line={})
    return [edges, faces]


def _row(one: Prediction) -> list[float | None]:
    points, times = np.array(one.motion.points), one.motion.times
    velocity = (points[-1] - points[0]) / (times[-1] - times[0]) if len(times) > 1 else np.zeros(3)
    doubt = one.doubt
    grows = (doubt.radius, doubt.growth, doubt.acceleration, doubt.accelerating_for if doubt.acceleration else 0.0)
    return [one.mover, *flat([times[0], *points[0], *velocity, *grows])]


def _way(way: CommittedWay) -> dict[str, Any]:
    kept = np.unique(np.r_[0 : len(way.times) : PAGE_STRIDE, len(way.times) - 1])
    return {
        "since": way.since,
        "brakes": way.brakes,
        "times": flat(way.times[kept]),
        "positions": [flat(column) for column in way.places[kept].T],
    }
