"""Writes missions as files for ground stations, maps, robots and light shows; the suffix tells the format."""

from collections.abc import Callable, Iterator
from pathlib import Path

from skyverse.atomic import write_text
from skyverse.errors import InputError, Remedy
from skyverse.exports.file_names import (
    ALTITUDE_REFERENCES,
    OWN_SUFFIXES,
    ROBOT_SUFFIXES,
    ROUTE_SUFFIXES,
    SHOW_SUFFIX,
    export_suffix,
    file_for_each,
    file_stems,
    write_zip,
)
from skyverse.exports.geo_csv import geo_csv_text
from skyverse.exports.geojson import geojson_text
from skyverse.exports.global_positions import AltitudeReference, home_on_globe, require_reference, with_origin
from skyverse.exports.gpx import gpx_text
from skyverse.exports.kml import kml_text
from skyverse.exports.mavlink_items import End
from skyverse.exports.qgc_plan import plan_text
from skyverse.exports.ros import as_text, path_message, trajectory_message
from skyverse.exports.route import Route
from skyverse.exports.routes import routes, routes_apart
from skyverse.exports.sampling import sample_trajectories
from skyverse.exports.skybrush import show_csv
from skyverse.exports.wpl import waypoints_text
from skyverse.exports.wpml import wpml_parts
from skyverse.files import write
from skyverse.model.mission import Mission
from skyverse.model.scenario import Origin, Scenario
from skyverse.model.verdict import Verdict

SAMPLE_RATES = {".csv": 20.0, SHOW_SUFFIX: 4.0}
"""Samples a second by suffix; for others it is 10."""


def export(
    mission: Mission,
    path: str | Path,
    *,
    altitude: AltitudeReference = "amsl",
    origin: Origin | None = None,
    rate: float | None = None,
    radius: float = 2.0,
    takeoff: float = 3.0,
    end: End = "loiter",
    allow_close: bool = False,
    on_note: Callable[[str], object] = lambda note: None,
) -> list[Path]:
    """Write a mission as a file for other software; the suffix tells the format.

    Parameters
    ----------
    mission
        The mission.
    path
        ``.plan`` (QGroundControl), ``.waypoints`` (QGC WPL 110), ``.wpml.kmz`` (DJI), ``.kml``, ``.kmz``, ``.geojson``,
        ``.gpx``, ``.geo.csv``, ``.path.json``, ``.path.yaml``, ``.trajectory.json``, ``.trajectory.yaml`` (ROS),
        ``.skybrush.zip`` (light shows), or what `write` writes. Formats for one vehicle give a file for each UAV that
        flies: where there are several, ``city.plan`` becomes ``city-uav-1.plan`` and so on.
    altitude
        The reference of altitudes: ``"amsl"``, mean sea level; ``"home"``, the ground below the UAV's start (its
        `home`, or else the terrain, or else the start itself); ``"agl"``, the ground below the UAV, which needs a
        terrain.
    origin
        The place of the scenario's zero, instead of the scenario's own origin. Its geoid is needed for ``.geojson``,
        and for ``.wpml.kmz`` above the sea; if it has none, that of the scenario's own origin is
        taken where that is near.
    rate
        Samples a second of formats that are sampled; by default 20 in ``.csv``, 4 in light shows, 10 in others.
    radius
        The acceptance radius to begin with, metres: the distance from a waypoint at which an autopilot may turn to the
        next. It is halved until every leg and every cut corner is proven clear.
    takeoff
        The height above home, metres, to which the UAV first climbs vertically, in ``.plan`` and ``.waypoints``; less
        where an obstacle is in the way.
    end
        ``"loiter"``: the UAV stays at its target. ``"land"``: it lands below it, which is not proven to be safe.
    allow_close
        Whether waypoints are written even if UAVs come closer than their separation when they fly straight between
        waypoints on schedule.
    on_note
        Called with each sentence on what is proven of the waypoints.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the suffix is unknown, the format needs an origin and there is none, the reference of altitudes does not
        suit format or scenario, legs cannot be proven clear, or UAVs come too close.
    """
    path = Path(path)
    suffix = export_suffix(path)
    left = [uav.name for uav, flight in zip(mission.scenario.uavs, mission.trajectories, strict=True) if flight is None]
    if left:
        on_note(f"Left out, for want of a trajectory: {', '.join(left)}.")
    if suffix in OWN_SUFFIXES:
        write(mission, path, rate=SAMPLE_RATES[".csv"] if rate is None else rate)
        return [path]
    if suffix in ROUTE_SUFFIXES:
        scenario = with_origin(mission, origin, str(path))
        takeoff, stops = (0.0, True) if suffix == ".wpml.kmz" else (takeoff, False)
        flown = routes(mission, altitude=altitude, origin=origin, radius=radius, takeoff=takeoff, stops=stops)
        notes = [*_proofs(mission, scenario, flown, altitude, path, allow_close)]
        files = _write_routes(path, suffix, scenario, flown, altitude, end)
        for note in notes:
            on_note(note)
        return files
    flights = sample_trajectories(mission, SAMPLE_RATES.get(suffix, 10.0) if rate is None else rate)
    if not flights:
        raise InputError(f"{path}: expected a mission with a trajectory to export, found none")
    names = [flight.name for flight in flights]
    if suffix == SHOW_SUFFIX:
        last = max(float(flight.seconds[-1]) for flight in flights)
        shows = zip(file_stems(names), flights, strict=True)
        write_zip(path, {f"{name}.csv": show_csv(flight, last) for name, flight in shows})
        return [path]
    if suffix in ROBOT_SUFFIXES:
        files = file_for_each(path, suffix, names)
        message = path_message if suffix.startswith(".path") else trajectory_message
        for file, flight in zip(files, flights, strict=True):
            write_text(file, as_text(message(flight), file.suffix))
        return files
    require_reference(mission.scenario, altitude, ALTITUDE_REFERENCES[suffix], str(path))
    scenario = with_origin(mission, origin, str(path))
    texts: dict[str, Callable[[], str]] = {
        ".geojson": lambda: geojson_text(scenario, flights, str(path)),
        ".gpx": lambda: gpx_text(scenario, flights),
        ".geo.csv": lambda: geo_csv_text(scenario, flights, altitude),
    }
    text = texts.get(suffix, lambda: kml_text(scenario, flights, altitude))()
    if suffix == ".kmz":
        write_zip(path, {"doc.kml": text})
    else:
        write_text(path, text)
    return [path]


def _proofs(
    mission: Mission, scenario: Scenario, flown: list[Route], altitude: AltitudeReference, path: Path, allow_close: bool
) -> Iterator[str]:
    """Yield sentences on what is proven of the routes, or raise `InputError` where UAVs come too close on them."""
    for one in flown:
        yield one.sentence(scenario)
    if altitude == "home":
        for one in flown:
            yield _home_note(scenario, one.uav)
    if len(flown) > 1:
        apart = routes_apart(mission, flown)
        if apart.verdict is Verdict.REFUTED and not allow_close:
            raise InputError(
                f"{path}: UAVs that fly straight from waypoint to waypoint come too close: {apart.sentence}",
                give=[Remedy("allow_close", True, "to write them all the same")],
            )
        yield f"Between waypoints, on schedule: {apart.sentence}"


def _home_note(scenario: Scenario, uav: int) -> str:
    at = round(home_on_globe(scenario, uav)[2], 2)
    return (
        f"{scenario.uavs[uav].name}: its heights are counted from home at {at + 0.0:.2f} m above mean sea level; where "
        "it arms lower than that, it flies as much lower."
    )


def _write_routes(
    path: Path, suffix: str, scenario: Scenario, flown: list[Route], altitude: AltitudeReference, end: End
) -> list[Path]:
    files = file_for_each(path, suffix, [scenario.uavs[one.uav].name for one in flown])
    for file, one in zip(files, flown, strict=True):
        if suffix == ".plan":
            write_text(file, plan_text(scenario, one, altitude, end))
        elif suffix == ".waypoints":
            write_text(file, waypoints_text(scenario, one, altitude, end))
        else:
            write_zip(file, wpml_parts(scenario, one, altitude, end))
    return files
