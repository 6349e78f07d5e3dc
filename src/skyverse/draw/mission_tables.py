"""The numbers of a mission's page: tiles with those of the fleet, a table of flights, and one of the searches."""

from collections.abc import Sequence
from html import escape

from skyverse.draw.page_parts import NO_VALUE, table, tiles, uav_row
from skyverse.draw.scene import MissionScene
from skyverse.errors import in_words
from skyverse.model.flight_measures import measure_flight
from skyverse.model.flight_table import Column, flight_columns, search_columns, told_costs, told_energy
from skyverse.model.gaps import told_gap
from skyverse.model.planned_flights import PlannedFlight, planned_flights
from skyverse.model.result import Status
from skyverse.model.seconds import told_seconds
from skyverse.model.short_lines import counted, told_metres
from skyverse.space.nearest_obstacle import nearest_obstacle


def mission_tiles(scene: MissionScene) -> str:
    """Return the tiles with the numbers of the fleet."""
    flights = planned_flights(scene.mission)
    targeted = [one for one in flights if one.target is not None]
    reached = [one for one in targeted if one.result is not None and one.result.status.reached]
    flown = [one.summary.length for one in flights if one.summary is not None and one.trajectory is not None]
    measures = [measure_flight(one, scene.scenario.terrain) for one in scene.mission.trajectories if one is not None]
    energies = [one.summary.energy for one in flights if one.summary is not None and one.summary.energy is not None]
    near = nearest_obstacle(scene.mission)
    shown = [
        ("Paths found", f"{len(reached)} of {len(targeted)}", counted(len(flights), "UAV")),
        ("Flown", told_metres(sum(flown)) if flown else NO_VALUE, "all UAVs together"),
        ("Last arrival", NO_VALUE if scene.makespan is None else told_seconds(scene.makespan), "into the mission"),
    ]
    if measures:
        low, high = min(one.lowest for one in measures), max(one.highest for one in measures)
        name = "Altitude" if scene.scenario.terrain is None else "Above ground"
        shown.append((name, f"{low:,.1f} to {high:,.1f} m", "at least and at most"))
    if near is not None:
        shown.append(("Nearest obstacle", f"{near:,.1f} m", "of what stands still"))
    if energies:
        shown.append(("Energy", told_energy(max(energies)), "of the UAV that needs most"))
    return tiles(shown)


def total_cost_sentence(scene: MissionScene) -> str:
    """Return what all paths cost together, and how far that is from the least at most; nothing where a path lacks."""
    if not scene.mission.complete:
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
    return _table("", scene, shown, text_columns=3)


def search_table(scene: MissionScene) -> str:
    """Return the table of the searches that found the paths."""
    return _table(_caption(scene), scene, list(map(_escaped, search_columns(scene.mission))), text_columns=1)


def _table(caption: str, scene: MissionScene, columns: Sequence[Column], *, text_columns: int) -> str:
    """Return columns in HTML, the first of which names the UAVs, as a table with the colours of the UAVs."""
    _, *others = columns
    rows = [
        uav_row(track.name, track.colour, cells[: text_columns - 1], cells[text_columns - 1 :])
        for track, *cells in zip(scene.tracks, *(column.cells for column in others), strict=True)
    ]
    heads = [(escape(column.head[0].upper() + column.head[1:]), escape(column.meaning)) for column in columns]
    return table(caption, heads, rows, text_columns=text_columns)


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
