"""Missions as files that ground stations, maps, robots and light shows open: one file a format, told by its suffix."""

import csv
import io
import math
import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from skyverse.atomic import whole_file, write_text
from skyverse.errors import InputError, Remedy
from skyverse.exports.geojson import geojson_text
from skyverse.exports.global_positions import AltitudeReference, global_positions, home, require_kind, with_origin
from skyverse.exports.gpx import gpx_text
from skyverse.exports.kml import kml_text
from skyverse.exports.leg_clearance import require_home
from skyverse.exports.mavlink_items import End
from skyverse.exports.qgc_plan import plan_text
from skyverse.exports.ros import as_text, path_message, trajectory_message
from skyverse.exports.route import Route, route
from skyverse.exports.sampling import SampledTrajectory, sample_trajectories
from skyverse.exports.skybrush import show_csv
from skyverse.exports.wpl import waypoints_text
from skyverse.exports.wpml import wpml_parts
from skyverse.files import write
from skyverse.model.mission import Mission
from skyverse.model.scenario import Origin, Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Certificate, Verdict
from skyverse.referee import certify

__all__ = ["Route", "export", "routes", "routes_apart"]

ROUTE_SUFFIXES = (".plan", ".waypoints", ".wpml.kmz")
MAP_SUFFIXES = (".kml", ".kmz", ".geojson", ".gpx", ".geo.csv")
ROBOT_SUFFIXES = (".path.json", ".path.yaml", ".trajectory.json", ".trajectory.yaml")
SHOW_SUFFIX = ".skybrush.zip"
OWN_SUFFIXES = (".waypoints.csv", ".csv", ".json")
EXPORT_SUFFIXES = (*ROUTE_SUFFIXES, *MAP_SUFFIXES, *ROBOT_SUFFIXES, SHOW_SUFFIX, *OWN_SUFFIXES)
SAMPLE_RATES = {".csv": 20.0, SHOW_SUFFIX: 4.0}
"""Samples a second by suffix; 10 where nothing is said."""
ALTITUDE_REFERENCES: dict[str, tuple[AltitudeReference, ...]] = {
    **dict.fromkeys(ROUTE_SUFFIXES, ("amsl", "home", "agl")),
    **dict.fromkeys(MAP_SUFFIXES, ("amsl",)),
    **dict.fromkeys((".kml", ".kmz"), ("amsl", "agl")),
    ".geo.csv": ("amsl", "home", "agl"),
}


def _silent(note: str) -> None:
    """Say nothing."""


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
    on_note: Callable[[str], object] = _silent,
) -> list[Path]:
    """Write a mission as a file that other software opens; its suffix tells which.

    Parameters
    ----------
    mission
        What was planned.
    path
        ``.plan`` (QGroundControl), ``.waypoints`` (QGC WPL 110), ``.wpml.kmz`` (DJI), ``.kml``, ``.kmz``, ``.geojson``,
        ``.gpx``, ``.geo.csv``, ``.path.json``, ``.path.yaml``, ``.trajectory.json``, ``.trajectory.yaml`` (ROS),
        ``.skybrush.zip`` (light shows), or what `write` writes. Of formats for one vehicle there is a file for each UAV
        that flies: ``city.plan`` becomes ``city-uav-1.plan`` ... where there are several.
    altitude
        What altitudes are counted from: ``"amsl"``, mean sea level; ``"home"``, the ground below the UAV's start (its
        `home`, or the terrain, or the start itself where there is neither); ``"agl"``, the ground below the UAV, which
        needs a terrain.
    origin
        Where the scenario's zero lies, in place of its own. Its geoid is needed for ``.geojson``, and for ``.wpml.kmz``
        above the sea; it is the scenario's where it says none and is near.
    rate
        Samples a second of what is sample_trajectories; 20 in ``.csv``, 4 in light shows, 10 in others when left out.
    radius
        The acceptance radius to begin with, metres: how near to a waypoint an autopilot may turn to the next. It is
        halved until every leg and every cut corner is proven clear.
    takeoff
        Metres above home to climb straight up to before anything else, in ``.plan`` and ``.waypoints``; less where
        there is no room.
    end
        Whether the mission ends by staying at the target, or by landing below it, which is not proven.
    allow_close
        Whether waypoints are written of UAVs that come closer than their separation when they fly straight between
        them on schedule.
    on_note
        Called with each sentence on what is proven of waypoints.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the suffix is unknown, the scenario has no origin and the format needs one, altitudes cannot be counted so,
        legs cannot be proven, or UAVs come too close.
    """
    path = Path(path)
    suffix = _suffix(path)
    left = [uav.name for uav, flight in zip(mission.scenario.uavs, mission.trajectories, strict=True) if flight is None]
    if left:
        on_note(f"Left out, for want of a trajectory: {', '.join(left)}.")
    if suffix in OWN_SUFFIXES:
        write(mission, path, rate=SAMPLE_RATES[".csv"] if rate is None else rate)
        return [path]
    if suffix in ROUTE_SUFFIXES:
        scenario = with_origin(mission, origin, str(path))
        flown = routes(
            mission,
            altitude=altitude,
            origin=origin,
            radius=radius,
            takeoff=0.0 if suffix == ".wpml.kmz" else takeoff,
            stops=suffix == ".wpml.kmz",
        )
        notes = [one.sentence(scenario) for one in flown]
        if altitude == "home":
            notes += [_home_note(scenario, one.uav) for one in flown]
        if len(flown) > 1:
            apart = routes_apart(mission, flown)
            if apart.verdict is Verdict.REFUTED and not allow_close:
                raise InputError(
                    f"{path}: UAVs that fly straight from waypoint to waypoint come too close: {apart.sentence}",
                    give=[Remedy("allow_close", True, "to write them all the same")],
                )
            notes.append(f"Between waypoints, on schedule: {apart.sentence}")
        files = _each(path, suffix, scenario, flown, altitude, end)
        for note in notes:
            on_note(note)
        return files
    flights = sample_trajectories(mission, SAMPLE_RATES.get(suffix, 10.0) if rate is None else rate)
    if not flights:
        raise InputError(f"{path}: expected a mission with a trajectory to export, found none")
    if suffix == SHOW_SUFFIX:
        names = _names([flight.name for flight in flights])
        last = max(float(flight.seconds[-1]) for flight in flights)
        parts = {f"{name}.csv": show_csv(flight, last) for name, flight in zip(names, flights, strict=True)}
        _write_zip(path, parts)
        return [path]
    if suffix in ROBOT_SUFFIXES:
        files = _files(path, suffix, [flight.name for flight in flights])
        make = path_message if suffix.startswith(".path") else trajectory_message
        for file, flight in zip(files, flights, strict=True):
            write_text(file, as_text(make(flight), file.suffix))
        return files
    require_kind(mission.scenario, altitude, ALTITUDE_REFERENCES[suffix], str(path))
    scenario = with_origin(mission, origin, str(path))
    if suffix in (".kml", ".kmz"):
        text = kml_text(scenario, flights, altitude)
        if suffix == ".kmz":
            _write_zip(path, {"doc.kml": text})
            return [path]
    elif suffix == ".geojson":
        text = geojson_text(scenario, flights, str(path))
    elif suffix == ".gpx":
        text = gpx_text(scenario, flights)
    else:
        text = _table(scenario, flights, altitude)
    write_text(path, text)
    return [path]


def routes(
    mission: Mission,
    *,
    altitude: AltitudeReference = "amsl",
    origin: Origin | None = None,
    radius: float = 2.0,
    takeoff: float = 3.0,
    stops: bool = False,
) -> list[Route]:
    """Return the waypoints of every UAV that flies, proven as an autopilot flies them; see `export`.

    Parameters
    ----------
    mission, altitude, origin, radius, takeoff
        As for `export`.
    stops
        Whether the UAV stops at every waypoint, and so cuts no corner.

    Raises
    ------
    InputError
        As for `export`.
    """
    scenario = with_origin(mission, origin, "waypoints")
    require_kind(scenario, altitude, get_args(AltitudeReference), "waypoints")
    if altitude == "home":
        for k, trajectory in enumerate(mission.trajectories):
            if trajectory is not None and scenario.uavs[k].fixed_wing is None:
                require_home(scenario, k)
    for noun, value, least, most in (("radius", radius, 0.05, 1000.0), ("takeoff", takeoff, 0.0, math.inf)):
        if not (math.isfinite(value) and least <= value <= most):
            until = f"to {most:g}" if most < math.inf else "on"
            raise InputError(f"{noun}: expected metres from {least:g} {until}, found {value!r}")
    found = [
        route(scenario, k, trajectory, altitude, radius=radius, takeoff=_climb(scenario, k, takeoff), stops=stops)
        for k, trajectory in enumerate(mission.trajectories)
        if trajectory is not None
    ]
    if not found:
        raise InputError("expected a mission with a trajectory to export, found none")
    return found


def _home_note(scenario: Scenario, uav: int) -> str:
    at = round(float(global_positions(scenario, uav, home(scenario, uav)[None], "amsl").altitude[0]), 2)
    return (
        f"{scenario.uavs[uav].name}: its heights are counted from home at {at + 0.0:.2f} m above mean sea level; where "
        "it arms lower than that, it flies as much lower."
    )


def _climb(scenario: Scenario, uav: int, takeoff: float) -> float:
    """Return how far a UAV is to climb from its start on; an aeroplane is in flight there."""
    vehicle = scenario.uavs[uav]
    return 0.0 if vehicle.fixed_wing else max(takeoff - (vehicle.start[2] - float(home(scenario, uav)[2])), 0.0)


def routes_apart(mission: Mission, flown: list[Route]) -> Certificate:
    """Let the referee say whether UAVs are apart that fly straight from waypoint to waypoint, each leg on schedule.

    Autopilots hold speeds, not schedules: what is proven here holds as far as they do.

    Parameters
    ----------
    mission
        What was planned.
    flown
        Its routes, from `routes`.
    """
    trajectories: list[Trajectory | None] = [None] * len(mission.scenario.uavs)
    for one in flown:
        stays = one.holds > 0
        times = np.sort(np.r_[one.times, (one.times + one.holds)[stays]])
        points = np.repeat(one.points, 1 + stays, axis=0)
        pace = np.diff(points, axis=0) / np.diff(times)[:, None]
        trajectories[one.uav] = Trajectory(times, np.stack([points[:-1], pace], axis=1))
    return certify(mission.scenario, replace(mission, trajectories=tuple(trajectories))).apart


def _each(
    path: Path, suffix: str, scenario: Scenario, flown: list[Route], altitude: AltitudeReference, end: End
) -> list[Path]:
    files = _files(path, suffix, [scenario.uavs[one.uav].name for one in flown])
    for file, one in zip(files, flown, strict=True):
        if suffix == ".plan":
            write_text(file, plan_text(scenario, one, altitude, end))
        elif suffix == ".waypoints":
            write_text(file, waypoints_text(scenario, one, altitude, end))
        else:
            _write_zip(file, wpml_parts(scenario, one, altitude, end))
    return files


def _suffix(path: Path) -> str:
    name = path.name.lower()
    for suffix in sorted(EXPORT_SUFFIXES, key=len, reverse=True):
        if name.endswith(suffix) and len(name) > len(suffix):
            return suffix
    raise InputError(
        f"{path}: a mission is written as {', '.join(EXPORT_SUFFIXES)}, not as {path.suffix or 'no suffix'!r}"
    )


def _files(path: Path, suffix: str, names: list[str]) -> list[Path]:
    """Return a file for each UAV: the path itself where there is one."""
    if len(names) == 1:
        return [path]
    stem, ending = path.name[: -len(suffix)], path.name[-len(suffix) :]
    return [path.with_name(f"{stem}-{name}{ending}") for name in _names(names)]


def _names(names: list[str]) -> list[str]:
    """Return what files may be called after UAVs, on every system, all different."""
    made: list[str] = []
    for number, name in enumerate(names, 1):
        safe = re.sub(r"[^A-Za-z0-9_.-]+", "_", name).strip("._-")[:60] or f"uav-{number}"
        taken = {one.lower() for one in made}
        made.append(safe if safe.lower() not in taken else f"{safe}-{number}")
    return made


def _write_zip(path: Path, parts: dict[str, str]) -> None:
    with whole_file(path) as beside, zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in parts.items():
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED)


def _table(scenario: Scenario, flights: list[SampledTrajectory], altitude: AltitudeReference) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["uav", "t", "latitude", "longitude", f"altitude_{altitude}", "x", "y", "z"])
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, altitude)
        table = np.column_stack([flight.seconds, at.latitude, at.longitude, at.altitude, flight.position])
        for t, latitude, longitude, up, *local in table.tolist():
            row = [f"{t:.6f}", f"{latitude:.9f}", f"{longitude:.9f}", f"{up:.4f}", *(f"{v:.4f}" for v in local)]
            writer.writerow([flight.name, *row])
    return out.getvalue()
