"""A mission as one web page that works offline: its flight in 3-D, convergence, numbers, and the verdict."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

from skyverse.draw.battery_traces import of_batteries
from skyverse.draw.margin_traces import told
from skyverse.draw.scene_traces import of_search
from skyverse.draw.scenes import MissionScene
from skyverse.draw.shape_geometry import below
from skyverse.draw.survey_page import survey_card, survey_tiles, survey_title
from skyverse.draw.template import (
    NO_VALUE,
    TONES,
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
from skyverse.draw.track import DrawnTrack
from skyverse.errors import in_words
from skyverse.model.caution import stands_out, urgency
from skyverse.model.flight_table import NO_VALUE as EMPTY
from skyverse.model.flight_table import (
    Column,
    battery_sentence,
    flight_columns,
    gaps_sentence,
    idle_sentence,
    measure_flight,
    search_columns,
    told_costs,
    told_energy,
    unit_sentence,
)
from skyverse.model.go_no_go import go_no_go
from skyverse.model.mission import PlannedFlight, planned_flights
from skyverse.model.quantities import short
from skyverse.model.result import NO_STOP, Status
from skyverse.model.short_lines import counted, told_gap, told_metres, told_seconds
from skyverse.model.timed_shapes import what_is_proven
from skyverse.model.verdict import Verdict
from skyverse.space.mission_cautions import nearest_obstacle
from skyverse.space.pads import pads_sentence
from skyverse.tour_table import sortie_columns, visit_columns

_AXIS = """
        <button type="button" data-axis="iterations" aria-pressed="true">Iterations</button>
        <button type="button" data-axis="paths" aria-pressed="false">Generated paths</button>
      """
_WORDS = {
    "layers": {"paths": "Paths", "trajectories": "Trajectories"},
    "iterations": "iteration",
    "paths": "generated paths",
    "value": "best cost so far",
    "log": True,
}
"""The labels of layers and axes in the page, and whether its chart may be logarithmic."""


def page(scene: MissionScene) -> str:
    """Return the page of `scene`, in which every string that a user gave is escaped."""
    order = "Numbers: the order of visits. " if scene.mission.visited and scene.mission.sorties else ""
    marks = f"{order}{told(scene)}{_squares(scene)}{_cut(scene)}"
    parts = {
        "title": escape(f"{scene.scenario.name}{survey_title(scene)}"),
        "description": escape(scene.scenario.description),
        "tiles": mission_tiles(scene),
        "space": "Flight",
        "still": "This mission has no trajectories; the paths are shown as planned.",
        "lines": f"Thick lines: trajectories; thin lines: the paths as planned. {marks}",
        "chart": "Convergence",
        "axis": _AXIS,
        "curves": "Best cost so far of each search",
        "dashed": f"Solid: best cost so far. Dashed: the {scene.bound}.",
        "numbers": "Flights",
        "table": flight_table(scene),
        "details": details(scene),
        "sheet": sheet(scene),
        "tours": tours(scene),
        "footer": footer(scene),
    } | found(scene)
    if scene.surveys:
        told_ends = {} if scene.scenario.targets else {"ends": "● home."}
        parts |= {"survey": survey_card(scene), **told_ends}
    drawn = scene_data(scene) | {"search": of_search(scene), "battery": of_batteries(scene), "words": _WORDS}
    return filled(parts, drawn)


def sheet(scene: MissionScene) -> str:
    """Return what whoever prepares the flights must know; with the verdict, it is what the page prints."""
    if not scene.sheet:
        return ""
    title = "Before the flight"
    bar = f'<div class="bar"><h2>{title}</h2><button type="button" id="print">Print the flight sheet</button></div>'
    told = [column for column in zip(*scene.sheet, strict=True) if {*column[1:]} - {EMPTY}]
    made = _word_table([*zip(*told, strict=True)])
    return f'<section class="card sheet" aria-label="{title}">{bar}{made}</section>'


def tours(scene: MissionScene) -> str:
    """Return batteries over time, and the tables of sorties and visits; nothing of a mission without either."""
    charged = any(one.battery is not None for one in scene.sorties)
    if not charged and not scene.mission.sorties:
        return ""
    chart = (
        '<div id="battery" role="img" aria-label="Batteries over time"></div>'
        '<p class="hint">What is left at least, in the stated wind with gusts at their worst. Dotted: a battery is '
        "changed. Cross: the point of no return, up to which the battery suffices for flying home the way that the UAV "
        "came; after it, for going on along the plan.</p>"
        if charged
        else ""
    )
    uavs = [one.uav for one in scene.sorties]
    shown = _region("sorties", _rows("", [scene.tracks[k] for k in uavs], _safe(sortie_columns(scene.mission)), 1))
    visited = [track for track in scene.tracks for _ in track.visits]
    if visited:
        shown += "<h2>Visits</h2>" + _region("visits", _rows("", visited, _safe(visit_columns(scene.mission)), 3))
    heading = "Batteries and sorties" if charged else "Sorties"
    return f'<section class="card tours" aria-label="{heading}"><h2>{heading}</h2>{chart}{shown}</section>'


def _region(name: str, rows: str) -> str:
    return f'<table aria-label="{name}">{rows}</table>'


def details(scene: MissionScene) -> str:
    """Return what costs and gaps are counted in and from, and a table of the searches that opens when asked for."""
    claim = "Paths called optimal are so as claimed by the planner." if _called_optimal(scene) else ""
    beside = (unit_sentence, gaps_sentence, battery_sentence, idle_sentence)
    sentences = (total_cost_sentence(scene), *(in_words(of(scene.mission)) for of in beside), claim)
    told = " ".join(filter(None, sentences))
    said = f'<p class="hint">{escape(told)}</p>' if told else ""
    heading = "How the paths were searched for: bounds, terms of the cost and effort"
    return f"{said}<details><summary>{heading}</summary>{_region('searches', search_table(scene))}</details>"


def _squares(scene: MissionScene) -> str:
    """Say what marks the places where UAVs may land, if there are any."""
    return (
        " Squares: where UAVs may land when they return; in space, the beginnings of their descents."
        if scene.landings
        else ""
    )


def _cut(scene: MissionScene) -> str:
    """Say that shapes are cut off at the top of the picture, if any are."""
    top = float(scene.world.high[2])
    cut = any(below(shape, top) is not shape for kind in scene.world.kinds for shape in kind.shapes)
    return f" What is higher than the picture is cut off at its top, z = {top:,.4g} m." if cut else ""


def found(scene: MissionScene) -> Parts:
    """Return the verdict on a mission, and below its picture what a pilot must heed and what the mission lacks."""
    one, told = go_no_go(scene.mission), ""
    doubts = [cell for _, *cells in scene.export_verdicts[1:] for cell in cells]  # neither the heads nor the names
    if scene.cautions:
        told += card("warn", "What a pilot must heed.", listed_sentences(scene.cautions))
    if scene.notes:
        tone, heading = ("note", "Some UAVs have no target.") if scene.complete else ("warn", "What the mission lacks.")
        told += card(tone, heading, listed_sentences(scene.notes))
    if scene.export_notes:
        warned = any(map(stands_out, [*scene.export_notes, *doubts]))
        heeded = sorted(filter(stands_out, scene.export_notes), key=urgency)
        proven = [note for note in scene.export_notes if not stands_out(note)]
        all_told = (
            f"<details><summary>All that is proven</summary>{listed_sentences(proven)}</details>" if proven else ""
        )
        exported = _word_table(scene.export_verdicts) if scene.export_verdicts else ""
        said = f"{exported}{listed_sentences(heeded) if heeded else ''}{all_told}"
        told += card("warn" if warned else "note", "What is exported, and the ways home.", said)
    if one.verdict is Verdict.PROVEN and any(map(stands_out, doubts)):
        one = replace(one, verdict=Verdict.UNDECIDED, sentence="Go, but not all of what is exported is proven.")
    return verdict(TONES[one.verdict], one.sentence, _what_is_proven(scene), scene.findings, told)


def _word_table(lines: Sequence[Sequence[str]]) -> str:
    """Return a head and rows of words as a table in which what is not proven stands out."""
    head, *rows = lines
    body = []
    for name, *cells in rows:
        marked = "".join(f'<td class="text{" doubt" * stands_out(cell)}">{escape(cell)}</td>' for cell in cells)
        body.append(f'<tr><th scope="row">{escape(name)}</th>{marked}</tr>')
    heads = [(escape(name[0].upper() + name[1:]), "") for name in head]
    return f"<table>{table('', heads, body, text_columns=len(heads))}</table>"


def _what_is_proven(scene: MissionScene) -> str:
    """Say what the referee proved of the flights, and what of the photos."""
    if not scene.judged and not scene.findings and not scene.mission.coverage:
        return "What a file says of itself is not believed; skyverse show and skyverse check judge it."
    covered = " ".join(f"{scene.scenario.surveys[one.survey].name}: {one.sentence}" for one in scene.mission.coverage)
    if not scene.proven:
        return covered
    if not any(track.arrival is not None for track in scene.tracks):
        return "There are no trajectories; the paths alone were judged."
    proven = f"Proven at every instant: {what_is_proven(scene.scenario, scene.mission.makespan)}."
    return " ".join(filter(None, [covered, proven, pads_sentence(scene.scenario, scene.pads)]))


def _called_optimal(scene: MissionScene) -> bool:
    return any(result is not None and result.status is Status.OPTIMAL for result in scene.mission.results)


def footer(scene: MissionScene) -> str:
    """Return the provenance of the answer, from which it can be repeated."""
    made = scene.mission.provenance
    searched = {} if made.stop == NO_STOP else {"Stop": made.stop}
    searched |= {} if made.seed is None else {"Seed": str(made.seed)}
    return facts_list(
        {
            "Scenario": f"{scene.scenario.name} ({short(scene.scenario.digest)})",
            "Planner": made.planner,
            **searched,
            "skyverse": made.skyverse,
            "Platform": made.platform,
        }
    )


def mission_tiles(scene: MissionScene) -> str:
    """Return the tiles with the numbers of the fleet."""
    flights = planned_flights(scene.mission)
    targeted = [one for one in flights if one.target is not None]
    reached = [one for one in targeted if one.result is not None and one.result.status.reached]
    flown = [one.summary.length for one in flights if one.summary is not None and one.trajectory is not None]
    measures = [measure_flight(one, scene.scenario.terrain) for one in scene.mission.trajectories if one is not None]
    energies = [one.summary.energy for one in flights if one.summary is not None and one.summary.energy is not None]
    near = nearest_obstacle(scene.mission)
    many, sorties = len(scene.scenario.targets), counted(len(scene.sorties), "sortie")
    visits = [("Targets visited", f"{len(scene.mission.visited)} of {many}", sorties)] if many else []
    shown = [
        *survey_tiles(scene),
        *(visits if scene.mission.sorties else []),
        *([("Paths found", f"{len(reached)} of {len(targeted)}", counted(len(flights), "UAV"))] if targeted else []),
        ("Flown", told_metres(sum(flown)) if flown else NO_VALUE, "all UAVs together"),
        ("Last arrival", NO_VALUE if scene.makespan is None else told_seconds(scene.makespan), "into the mission"),
    ]
    if measures:
        low, high = min(one.lowest for one in measures), max(one.highest for one in measures)
        name = "Altitude" if scene.scenario.terrain is None else "Above ground"
        shown.append((name, f"{low:,.1f} to {high:,.1f} m", "at least and at most"))
    if near is not None:
        shown.append(("Nearest obstacle", f"{near:,.2f} m", "about, to what stands still"))
    if energies:
        shown.append(("Energy", told_energy(max(energies)), "of the UAV that needs most"))
    return tiles(shown)


def total_cost_sentence(scene: MissionScene) -> str:
    """Return what all paths cost together, and how far that is from the least at most; nothing where a path lacks."""
    if not scene.mission.complete or not scene.mission.costs:
        return ""
    gap = scene.mission.gap
    above = "" if gap is None else f", at most {told_gap(gap)} above the {scene.bound}"
    return f"Total cost: {told_costs(scene.mission.costs)}{above}."


def flight_table(scene: MissionScene) -> str:
    """Return the table of flights."""
    flights = planned_flights(scene.mission)
    shown = [
        Column(column.head, column.meaning, tuple(map(_pill, flights))) if column.head == "status" else _escaped(column)
        for column in flight_columns(scene.mission)
    ]
    return _rows("", scene.tracks, shown, text_columns=3)


def search_table(scene: MissionScene) -> str:
    """Return the table of the searches that found the paths."""
    return _rows(_caption(scene), scene.tracks, _safe(search_columns(scene.mission)), text_columns=1)


def _rows(caption: str, tracks: Sequence[DrawnTrack], columns: Sequence[Column], text_columns: int) -> str:
    """Return columns in HTML, the first of which names the UAVs, as a table with the colours of the UAVs' tracks."""
    _, *others = columns
    rows = [
        uav_row(track.name, track.colour, cells[: text_columns - 1], cells[text_columns - 1 :])
        for track, *cells in zip(tracks, *(column.cells for column in others), strict=True)
    ]
    heads = [(escape(column.head[0].upper() + column.head[1:]), escape(column.meaning)) for column in columns]
    return table(caption, heads, rows, text_columns=text_columns)


def _safe(columns: Sequence[Column]) -> list[Column]:
    return list(map(_escaped, columns))


def _escaped(column: Column) -> Column:
    return Column(column.head, column.meaning, tuple(map(escape, column.cells)))


def _pill(flight: PlannedFlight) -> str:
    """Return how the search for a UAV's path ended, in a colour that says whether that is well."""
    if flight.result is None:
        return f'<span class="pill">{flight.status}</span>'
    status = flight.result.status
    tone = "good" if status.reached else "warn" if status is Status.INCOMPLETE else "bad"
    return f'<span class="pill {tone}" title="{escape(in_words(status.sentence))}">{status.value}</span>'


def _caption(scene: MissionScene) -> str:
    """Return what a cost consists of."""
    weights = scene.scenario.objective
    terms = {term for result in scene.mission.results if result is not None for term in result.terms}
    units = " or ".join(scene.mission.costs) or weights.unit  # off the lattice, paths are in metres in any case
    said = [
        f"{weights.fuel:g} &times; fuel ({units})",
        f"{weights.divergence:g} &times; turns",
        f"{weights.end:g} &times; metres short of the target",
    ]
    if weights.altitude is not None and "altitude" in terms:
        band = weights.altitude
        said.append(f"{band.weight:g} &times; metres outside {band.low:g} to {band.high:g} m, a metre flown")
    if "risk" in terms:
        said.append(f"{weights.risk:g} &times; the zones' risk, a metre flown inside")
    if weights.climb is not None and "climb" in terms:
        said.append(f"{weights.climb.weight:g} &times; radians above {weights.climb.angle:g}&deg;, a metre flown")
    return f"Cost = {' + '.join(said)}"
