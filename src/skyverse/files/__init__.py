"""Scenarios, missions and flights are read from files and written to them; the suffix tells the format."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, overload

from skyverse.atomic import whole_file, write_text
from skyverse.errors import InputError, is_number, path_of, require_file
from skyverse.files.builtin import BUILTIN_NAMES, BuiltinName, builtin
from skyverse.files.document import parse, read_text
from skyverse.files.grid_archive import GridArchive
from skyverse.files.missions import (
    FLIGHTS,
    MISSIONS,
    REPLANNED_FLIGHTS,
    mission_from_data,
    replanned_flight_from_data,
    trajectories_csv,
    waypoints_csv,
)
from skyverse.files.scenarios import course_map, options_built_with, scenario_from_data, scenario_schema, scenario_text
from skyverse.maps.readers import local_worlds
from skyverse.maps.readers.local_worlds import is_rotorpy_world, rotorpy_world
from skyverse.maps.readers.voxel_grid import Unknown
from skyverse.model.flight_record import Flight
from skyverse.model.mission import Mission
from skyverse.model.replanned_flight import ReplannedFlight
from skyverse.model.scenario import Scenario

__all__ = [
    "BUILTIN_NAMES",
    "options_built_with",
    "read",
    "read_flight",
    "read_mission",
    "read_scenario",
    "scenario_schema",
    "write",
]


@overload
def read(source: BuiltinName) -> Scenario: ...
@overload
def read(source: str | Path, *, unknown: Unknown | None = None) -> Scenario | Mission: ...
def read(source: str | Path, *, unknown: Unknown | None = None) -> Scenario | Mission:
    """Read a scenario or a mission.

    Parameters
    ----------
    source
        A built-in scenario's name (``map1``, ``table-4.8`` ...), or a file: a scenario as ``.yaml``, ``.yml`` or
        ``.json``; a mission as ``.json``; a flight gives the mission that was flown, a replanned one the mission as it
        was planned. Maps give scenarios without UAVs: the course's ``.txt``, rotorpy's ``.json``, MovingAI's
        ``.3dmap``, OctoMap's ``.bt`` and ``.ot``, point clouds and meshes, ``.las``, ``.laz``, ``.pcd``, ``.ply``,
        ``.stl``, ``.obj``. A type checker knows that a built-in name gives a scenario; of a file, `read_scenario` and
        `read_mission` tell it which of the two is meant.
    unknown
        What an OctoMap's unknown space is taken for, ``"occupied"`` or ``"free"``. When left out it is occupied, but
        free where the map does not record what is free.

    Raises
    ------
    InputError
        If there is no such scenario or file, or it cannot be used; the message names file and field.
    """
    path = path_of(source, "source")
    if unknown is not None and path.suffix.lower() not in local_worlds.OCTOMAP_SUFFIXES:
        suffixes = ", ".join(local_worlds.OCTOMAP_SUFFIXES)
        raise InputError(f"expected it for an OctoMap ({suffixes}) only, found it for {source}", field="unknown")
    if str(source) in BUILTIN_NAMES:
        return builtin(str(source))
    suffix = path.suffix.lower()
    require_file(path, BUILTIN_NAMES)
    if suffix == ".txt":
        return course_map(path, read_text(path))
    if suffix in local_worlds.VOXEL_SUFFIXES:
        return local_worlds.voxel_scenario(path, unknown=unknown)
    if suffix not in (".yaml", ".yml", ".json"):
        known = ", ".join((".yaml", ".yml", ".json", ".txt", *local_worlds.VOXEL_SUFFIXES))
        raise InputError(f"{path}: expected a file ending in {known}, found {suffix or 'no ending'!r}")
    data = parse(path, read_text(path))
    if suffix == ".json" and is_rotorpy_world(data):
        return rotorpy_world(path, data)
    for kind in (MISSIONS, FLIGHTS, REPLANNED_FLIGHTS):
        kind.require_name(path, data)
    if MISSIONS.is_of(data):
        return mission_from_data(path, data)
    if FLIGHTS.is_of(data):
        return FLIGHTS.from_data(path, data).mission
    if REPLANNED_FLIGHTS.is_of(data):
        return replanned_flight_from_data(path, data).mission
    return scenario_from_data(path, data)


def read_scenario(source: str | Path, *, unknown: Unknown | None = None) -> Scenario:
    """Read a scenario; a mission gives the scenario that it embeds. See `read`."""
    found = read(source, unknown=unknown)
    return found.scenario if isinstance(found, Mission) else found


def read_mission(source: str | Path) -> Mission:
    """Read a mission; see `read`. A scenario is refused with `InputError`."""
    if str(source) not in BUILTIN_NAMES:
        require_file(path_of(source, "source"))  # scenarios may be built in, missions not
    found = read(source)
    if isinstance(found, Mission):
        return found
    raise InputError(f"{source}: expected a mission (its 'format' is {MISSIONS.name!r}), found a scenario")


def read_flight(path: str | Path) -> Flight | ReplannedFlight:
    """Read a flight, or one that was replanned, from its file, or raise `InputError`."""
    path = path_of(path)
    require_file(path)
    data = parse(path, read_text(path))
    for kind in (FLIGHTS, REPLANNED_FLIGHTS):
        kind.require_name(path, data)
    if FLIGHTS.is_of(data):
        return FLIGHTS.from_data(path, data)
    if REPLANNED_FLIGHTS.is_of(data):
        return replanned_flight_from_data(path, data)
    names = f"{FLIGHTS.name!r} or {REPLANNED_FLIGHTS.name!r}"
    raise InputError(f"{path}: expected a flight (its 'format' is {names}), found something else")


def write(what: Scenario | Mission | Flight | ReplannedFlight, path: str | Path, *, rate: float = 20.0) -> None:
    """Write a scenario, a mission or a flight, replanned or not; the file appears whole or not at all.

    Parameters
    ----------
    what
        A scenario goes to ``.yaml``, ``.yml`` or ``.json``. A mission goes to ``.json``, its waypoints to
        ``.waypoints.csv``, its sampled trajectories to any other ``.csv``. A flight goes to ``.json``.
    path
        The file; its folder must exist.
    rate
        Samples a second in a CSV of trajectories.

    Raises
    ------
    InputError
        If the suffix does not fit, or the file cannot be written.
    """
    path = path_of(path)
    suffix = path.suffix.lower()
    if isinstance(what, Scenario):
        if suffix not in (".yaml", ".yml", ".json"):
            raise InputError(f"{path}: a scenario is written as .yaml, .yml or .json, not as {suffix or 'no suffix'!r}")
        _write(path, partial(scenario_text, what, suffix))
    elif isinstance(what, Flight | ReplannedFlight):
        if suffix != ".json":
            raise InputError(f"{path}: a flight is written as .json, not as {suffix or 'no suffix'!r}")
        if isinstance(what, Flight):
            _write(path, partial(FLIGHTS.text, what))
        else:
            _write(path, partial(REPLANNED_FLIGHTS.text, what))
    elif not isinstance(what, Mission):
        raise InputError(f"expected a Scenario, a Mission, a Flight or a ReplannedFlight to write, got {what!r:.60}")
    elif suffix == ".json":
        _write(path, partial(MISSIONS.text, what))
    elif path.name.lower().endswith(".waypoints.csv"):
        write_text(path, waypoints_csv(what))
    elif suffix == ".csv":
        if not (is_number(rate) and rate > 0):
            raise InputError(f"expected samples a second above 0, found {rate!r}", field="rate")
        write_text(path, trajectories_csv(what, rate))
    else:
        raise InputError(
            f"{path}: a mission is written as .json, .waypoints.csv (waypoints) or .csv (trajectories), "
            f"not as {suffix or 'no suffix'!r}"
        )


def _write(path: Path, text: Callable[[dict[str, Any]], str]) -> None:
    """Write a file, and the archive beside it that holds its large arrays; an error leaves both as they were."""
    archive = GridArchive(path)
    whole = text(archive.context)
    if not archive:
        write_text(path, whole)
    else:
        with whole_file(path) as beside:
            beside.write_text(whole, encoding="utf-8", newline="\n")
            with whole_file(archive.path) as file:
                archive.write_to(file)
