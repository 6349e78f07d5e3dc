"""Writes missions that the referee does not refute as files for other software; the suffix tells the format."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from skyverse.errors import InputError, path_of, require_kind
from skyverse.exports.global_positions import with_origin
from skyverse.exports.map_formats import geo_csv_text, geojson_text, gpx_text, kml_text
from skyverse.exports.report import export_page
from skyverse.exports.requirements import (
    ALTITUDE_REFERENCES,
    ROUTE_SUFFIXES,
    Contents,
    ExportOptions,
    export_suffix,
    file_for_each,
    file_stems,
    require_format,
    require_no_movers,
    require_not_refuted,
    require_survey_items,
    with_zones_always_active,
    write_files,
)
from skyverse.exports.sampled_formats import (
    SampledTrajectory,
    as_text,
    path_message,
    sample_trajectories,
    show_csv,
    trajectory_message,
)
from skyverse.exports.verdicts import ExportCertificate
from skyverse.exports.waypoint_files import waypoint_files
from skyverse.files import write
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario
from skyverse.space.mission_cautions import mission_cautions

USUAL = ExportOptions()


class Sampled(NamedTuple):
    """What a format of sampled trajectories is written of: the file, its suffix, the scenario, the flights, and how."""

    path: Path
    suffix: str
    scenario: Scenario
    flights: list[SampledTrajectory]
    options: ExportOptions


def export(
    mission: Mission,
    path: str | Path,
    options: ExportOptions = USUAL,
    *,
    scenario: Scenario | None = None,
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
        ``.plan`` (QGroundControl), ``.waypoints`` (QGC WPL 110), ``.wpml.kmz`` (DJI), ``.litchi.csv`` (Litchi, for
        DJI), ``.kml``, ``.kmz``, ``.geojson``, ``.gpx``, ``.geo.csv``, ``.path.json``, ``.path.yaml``,
        ``.trajectory.json``, ``.trajectory.yaml`` (ROS), ``.skybrush.zip`` (light shows), or what
        `write` writes. Formats for one vehicle give a file for each UAV that flies: where there are several,
        ``city.plan`` becomes ``city-uav-1.plan`` and so on, and
        waypoints of a UAV with several sorties ``city-uav-1-sortie-1.plan`` and so on.
    options
        Altitudes, origin, samples, and how waypoints are flown.
    scenario
        The scenario that the mission has to answer, if that is known from elsewhere: a mission that embeds another one
        is refuted. By default the mission is judged by the scenario that it embeds.
    page
        A web page to write as well, for ``.plan``, ``.waypoints``, ``.wpml.kmz`` and ``.litchi.csv``: the mission, the
        places where UAVs may land when they return, and all that is said of the waypoints.
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
    require_kind(options, ExportOptions, "options")
    if scenario is not None:
        require_kind(scenario, Scenario, "scenario")
    path = path_of(path)
    page = None if page is None else path_of(page, "page")
    suffix = export_suffix(path)
    given = mission.scenario if scenario is None else scenario
    placed = mission.scenario
    if suffix in ROUTE_SUFFIXES:
        require_no_movers(given, str(path))
    elif page is not None:
        said = f"expected a file of waypoints, {', '.join(ROUTE_SUFFIXES)}, to draw, found {path}"
        raise InputError(said, field="page")
    if options.survey_item:
        require_survey_items(given, suffix)
    if suffix in ALTITUDE_REFERENCES:
        placed = with_origin(mission, options.origin, str(path))
        require_format(mission, placed, suffix, options, str(path))
    notes, judged = require_not_refuted(mission, given, path, allow_close=options.allow_close)
    for note in [
        *notes,
        *(caution.sentence for caution in mission_cautions(replace(mission, scenario=given, coverage=judged.coverage))),
    ]:
        on_note(note)
    left = [uav.name for uav, flight in zip(mission.scenario.uavs, mission.trajectories, strict=True) if flight is None]
    if left:
        on_note(f"Left out, for want of a trajectory: {', '.join(left)}.")
    if suffix in SAMPLED:
        if suffix == ".kmz":
            on_note(f"{path.name} is for Google Earth; aircraft of DJI fly files that end in .wpml.kmz.")
        made_of, rate = SAMPLED[suffix]
        flights = sample_trajectories(mission, rate if options.rate is None else options.rate)
        if not flights:
            raise InputError(f"{path}: expected a mission with a trajectory to export, found none")
        contents = made_of(Sampled(path, suffix, placed, flights, options))
        write_files(contents)
        return list(contents)
    if suffix not in ROUTE_SUFFIXES:
        write(mission, path, rate=CSV_RATE if options.rate is None else options.rate)
        return [path]
    flown = with_zones_always_active(mission, str(path), judged.certificates)
    flown = replace(flown, scenario=with_origin(flown, options.origin, str(path)))
    contents, files, certificate, told, sheet = waypoint_files(flown, path, suffix, options)
    if page is not None:
        contents[page] = export_page(replace(judged, scenario=placed), certificate, [*notes, *told], sheet)
        files.append(page)
    write_files(contents)
    on_certificate(certificate)
    for note in told:
        on_note(note)
    return files


def _map_file(text: Callable[..., str], of: Sampled) -> Contents:
    """Return one file of all UAVs; text in an archive for ``.kmz``."""
    made = text(of.scenario, of.flights, of.options.altitude)
    return {of.path: {"doc.kml": made} if of.suffix == ".kmz" else made}


def _message_files(message: Callable[[SampledTrajectory], dict[str, Any]], of: Sampled) -> Contents:
    """Return a file for each UAV, for robots."""
    files = file_for_each(of.path, of.suffix, [flight.name for flight in of.flights])
    return {file: as_text(message(flight), file.suffix) for file, flight in zip(files, of.flights, strict=True)}


def _show_file(of: Sampled) -> Contents:
    """Return an archive with a table for each UAV, for a light show."""
    last = max(float(flight.seconds[-1]) for flight in of.flights)
    names = file_stems([flight.name for flight in of.flights])
    return {of.path: {f"{name}.csv": show_csv(one, last) for name, one in zip(names, of.flights, strict=True)}}


CSV_RATE = 20.0
"""Samples a second of plain tables."""
SAMPLED: dict[str, tuple[Callable[[Sampled], Contents], float]] = {
    ".kml": (partial(_map_file, kml_text), 10.0),
    ".kmz": (partial(_map_file, kml_text), 10.0),
    ".geojson": (partial(_map_file, geojson_text), 10.0),
    ".gpx": (partial(_map_file, gpx_text), 10.0),
    ".geo.csv": (partial(_map_file, geo_csv_text), 10.0),
    ".path.json": (partial(_message_files, path_message), 10.0),
    ".path.yaml": (partial(_message_files, path_message), 10.0),
    ".trajectory.json": (partial(_message_files, trajectory_message), 10.0),
    ".trajectory.yaml": (partial(_message_files, trajectory_message), 10.0),
    ".skybrush.zip": (_show_file, 4.0),
}
"""What makes each format of sampled trajectories, and its samples a second."""
