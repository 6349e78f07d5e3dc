"""Writes missions that the referee does not refute as files for other software; the suffix tells the format."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from skyverse.atomic import write_text
from skyverse.errors import InputError, require_kind
from skyverse.exports.autopilots import AutopilotName
from skyverse.exports.flight_verdicts import write_export_page
from skyverse.exports.global_positions import AltitudeReference, with_origin
from skyverse.exports.map_formats import MAP_TEXTS
from skyverse.exports.mavlink_formats import End
from skyverse.exports.requirements import (
    ALTITUDE_REFERENCES,
    OWN_SUFFIXES,
    ROBOT_SUFFIXES,
    ROUTE_SUFFIXES,
    SHOW_SUFFIX,
    export_suffix,
    file_for_each,
    file_stems,
    require_format,
    require_no_movers,
    require_not_refuted,
    require_radius_and_takeoff,
    with_zones_always_active,
    write_zip,
)
from skyverse.exports.sampled_formats import as_text, path_message, sample_trajectories, show_csv, trajectory_message
from skyverse.exports.waypoint_files import ExportCertificate, WaypointOptions, export_waypoints
from skyverse.files import write
from skyverse.model.frame import Origin
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.space.mission_cautions import mission_cautions

SAMPLE_RATES = {".csv": 20.0, SHOW_SUFFIX: 4.0}
"""Samples a second by suffix; for others it is 10."""


def export(
    mission: Mission,
    path: str | Path,
    *,
    scenario: Scenario | None = None,
    altitude: AltitudeReference = "amsl",
    origin: Origin | None = None,
    rate: float | None = None,
    radius: float = 2.0,
    takeoff: float = 3.0,
    end: End = "loiter",
    return_altitude: float | None = None,
    autopilot: AutopilotName | None = None,
    apart_in_space: bool = False,
    allow_close: bool = False,
    page: str | Path | None = None,
    on_note: Callable[[str], object] = lambda note: None,
    on_certificate: Callable[[ExportCertificate], object] = lambda certificate: None,
) -> list[Path]:
    """Write a mission as a file for other software; the suffix tells the format.

    The referee judges the mission first, as `check` does: what it refutes is refused, and nothing is written. What it
    can neither prove nor refute is written, and `on_note` is told. `write` is for plain data: it writes ``.json`` and
    ``.csv`` of any mission, also of one that is refuted.

    Parameters
    ----------
    mission
        The mission.
    path
        ``.plan`` (QGroundControl), ``.waypoints`` (QGC WPL 110), ``.wpml.kmz`` (DJI), ``.kml``, ``.kmz``, ``.geojson``,
        ``.gpx``, ``.geo.csv``, ``.path.json``, ``.path.yaml``, ``.trajectory.json``, ``.trajectory.yaml`` (ROS),
        ``.skybrush.zip`` (light shows), or what `write` writes. Formats for one vehicle give a file for each UAV that
        flies: where there are several, ``city.plan`` becomes ``city-uav-1.plan`` and so on.
    scenario
        The scenario that the mission has to answer, if that is known from elsewhere: a mission that embeds another one
        is refuted. By default the mission is judged by the scenario that it embeds.
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
        ``"loiter"``: the UAV stays at its target. ``"land"``: it lands below it, on the ground or on a roof.
        ``"rtl"``: it returns, as it does by itself when something fails, and lands at home.
    return_altitude
        Metres above home at which UAVs return by themselves, unless they are higher. By default each UAV returns at
        another altitude, a separation apart, where there is room: at 30 m or the next that is proven.
    autopilot
        ``"px4"`` or ``"ardupilot"``, for which ``.plan`` and ``.waypoints`` are made; ``"dji"`` for ``.wpml.kmz``. By
        default ``.plan`` is for PX4, or for ArduPilot with altitudes above ground, and ``.waypoints`` for ArduPilot.
    apart_in_space
        Whether all paths must be apart in space, so that UAVs keep their separation whatever the timing. The acceptance
        radius is halved until they are.
    allow_close
        Whether to export even if UAVs come closer than their separation, as planned or when autopilots fly their
        waypoints on schedule.
    page
        A web page to write as well, for ``.plan``, ``.waypoints`` and ``.wpml.kmz``: the mission, the places where UAVs
        may land when they return, and all that is said of the waypoints.
    on_note
        Called with each sentence on what the referee has not proven of the mission, and on what is proven of waypoints.
    on_certificate
        Called with what is proven of waypoints: of each pair of UAVs, and of each UAV's way home.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the referee refutes the mission, the suffix is unknown, the format needs an origin and there is none, the
        reference of altitudes does not suit format or scenario, legs cannot be proven clear, UAVs come too close, or
        flights depend on the active times of zones.
    """
    require_kind(mission, Mission, "mission")
    require_kind(path, (str, Path), "path")
    path = Path(path)
    suffix = export_suffix(path)
    if suffix in ROUTE_SUFFIXES:
        require_no_movers(mission.scenario if scenario is None else scenario, str(path))
    if suffix in ALTITUDE_REFERENCES:
        placed = with_origin(mission, origin, str(path))
        require_format(mission, placed, suffix, altitude, autopilot, str(path))
    if page is not None and suffix not in ROUTE_SUFFIXES:
        raise InputError(
            f"expected a file of waypoints, {', '.join(ROUTE_SUFFIXES)}, to draw, found {path}", field="page"
        )
    if suffix in ROUTE_SUFFIXES:
        require_radius_and_takeoff(radius, takeoff)
    given = mission.scenario if scenario is None else scenario
    notes, judged = require_not_refuted(mission, given, path, allow_close=allow_close)
    for note in [*notes, *(caution.sentence for caution in mission_cautions(replace(mission, scenario=given)))]:
        on_note(note)
    left = [uav.name for uav, flight in zip(mission.scenario.uavs, mission.trajectories, strict=True) if flight is None]
    if left:
        on_note(f"Left out, for want of a trajectory: {', '.join(left)}.")
    if suffix in OWN_SUFFIXES:
        write(mission, path, rate=SAMPLE_RATES[".csv"] if rate is None else rate)
        return [path]
    if suffix in ROUTE_SUFFIXES:
        flown = with_zones_always_active(mission, str(path), judged.certificates)
        options = WaypointOptions(
            altitude,
            radius,
            takeoff,
            end,
            autopilot,
            apart_in_space=apart_in_space,
            allow_close=allow_close,
            return_altitude=return_altitude,
        )
        said, proven = list(notes), list[ExportCertificate]()
        files = export_waypoints(
            flown, with_origin(flown, origin, str(path)), path, suffix, options, said.append, proven.append
        )
        for certificate in proven:
            on_certificate(certificate)
        for note in said[len(notes) :]:
            on_note(note)
        if page is None:
            return files
        drawn = replace(judged, scenario=placed)
        write_export_page(Path(page), drawn, proven[0].flights, proven[0].returns, said)
        return [*files, Path(page)]
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
    text = MAP_TEXTS[suffix](placed, flights, altitude)
    if suffix == ".kmz":
        on_note(f"{path.name} is for Google Earth; aircraft of DJI fly files that end in .wpml.kmz.")
        write_zip(path, {"doc.kml": text})
    else:
        write_text(path, text)
    return [path]
