"""Which formats there are, and what each needs of a mission: the referee must not refute it, whatever the format."""

import re
import zipfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import get_args

import numpy as np

from skyverse.atomic import whole_file
from skyverse.errors import (
    InputError,
    Remedy,
    is_number,
    require_choice,
    require_flag,
    require_kind,
    require_number,
    shown,
)
from skyverse.exports.autopilots import DJI_SUFFIXES, MIN_ACCEPTANCE_RADIUS, AutopilotName, End, autopilot_for
from skyverse.exports.global_positions import AltitudeReference, geoid_of, home, require_reference
from skyverse.model.caution import Caution
from skyverse.model.frame import Origin
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted, listed
from skyverse.model.timed_shapes import temporary_zones, told_zone, with_zones_active
from skyverse.model.verdict import Certificate, Fault, Verdict, Violation
from skyverse.referee import certify, judged
from skyverse.referee.clearance import judge_segments
from skyverse.referee.world import referee_world

ROUTE_SUFFIXES = (".plan", ".waypoints", *DJI_SUFFIXES)
ALTITUDE_REFERENCES: dict[str, tuple[AltitudeReference, ...]] = {
    **dict.fromkeys((*ROUTE_SUFFIXES, ".geo.csv"), ("amsl", "home", "agl")),
    ".litchi.csv": ("home", "agl"),
    **dict.fromkeys((".kml", ".kmz"), ("amsl", "agl")),
    **dict.fromkeys((".geojson", ".gpx"), ("amsl",)),
}
"""What altitudes may be counted from, in formats in degrees; all others are in local metres."""
EXPORT_SUFFIXES = (
    *ALTITUDE_REFERENCES,
    *(".path.json", ".path.yaml", ".trajectory.json", ".trajectory.yaml"),
    *(".skybrush.zip", ".waypoints.csv", ".csv", ".json"),
)


@dataclass(frozen=True)
class ExportOptions:
    """How a mission is exported; each format heeds what concerns it.

    Attributes
    ----------
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
        ``"loiter"``: the UAV stays at its target; one that ends at home lands there. ``"land"``: it lands below its
        target, on the ground or on an obstacle. ``"rtl"``: it returns, as it does by itself when something fails, and
        lands at home.
    return_altitude
        Metres above home at which UAVs return by themselves, unless they are higher. By default each UAV returns at
        another altitude, a separation apart, where there is room: at 30 m or the next that is proven.
    autopilot
        ``"px4"`` or ``"ardupilot"``, for which ``.plan`` and ``.waypoints`` are made; ``"dji"`` for ``.wpml.kmz``
        and ``.litchi.csv``. By default ``.plan`` is for PX4, or for ArduPilot with altitudes above ground, and
        ``.waypoints`` for ArduPilot.
    apart_in_space
        Whether all paths must be apart in space, so that UAVs keep their separation whatever the timing. The acceptance
        radius is halved until they are.
    allow_close
        Whether to export even if UAVs come closer than their separation, as planned or when autopilots fly their
        waypoints on schedule.
    survey_item
        Whether ``.plan`` files have the photos of a survey of an area in QGroundControl's own survey item, which shows
        them as a survey; who edits it there puts other waypoints, which nobody has proven, in their place.
    """

    altitude: AltitudeReference = "amsl"
    origin: Origin | None = None
    rate: float | None = None
    radius: float = 2.0
    takeoff: float = 3.0
    end: End = "loiter"
    return_altitude: float | None = None
    autopilot: AutopilotName | None = None
    apart_in_space: bool = False
    allow_close: bool = False
    survey_item: bool = False

    def __post_init__(self) -> None:
        require_choice(self.altitude, get_args(AltitudeReference), "altitude")
        require_choice(self.end, get_args(End), "end")
        if self.autopilot is not None:
            require_choice(self.autopilot, get_args(AutopilotName), "autopilot")
        if self.origin is not None:
            require_kind(self.origin, Origin, "origin")
        if self.rate is not None and not (is_number(self.rate) and self.rate > 0):
            raise InputError(f"expected samples a second above 0, found {shown(self.rate)}", field="rate")
        require_number(self.radius, "radius", "metres", MIN_ACCEPTANCE_RADIUS, 1000.0)
        require_number(self.takeoff, "takeoff", "metres", 0.0)
        if self.return_altitude is not None:
            require_number(self.return_altitude, "return_altitude", "metres above home", 0.0)
        require_flag(self.apart_in_space, "apart_in_space")
        require_flag(self.allow_close, "allow_close")
        require_flag(self.survey_item, "survey_item")


def export_suffix(path: Path) -> str:
    """Return which of `EXPORT_SUFFIXES` a path has, or raise `InputError`."""
    name = path.name.lower()
    for suffix in sorted(EXPORT_SUFFIXES, key=len, reverse=True):
        if name.endswith(suffix) and len(name) > len(suffix):
            return suffix
    found = path.suffix or "no suffix"
    raise InputError(f"{path}: a mission is written as {', '.join(EXPORT_SUFFIXES)}, not as {found!r}")


def file_for_each(path: Path, suffix: str, names: list[str]) -> list[Path]:
    """Return a path for each of the named UAVs: `path` itself where there is only one."""
    if len(names) == 1:
        return [path]
    stem, ending = path.name[: -len(suffix)], path.name[-len(suffix) :]
    return [path.with_name(f"{stem}-{name}{ending}") for name in file_stems(names)]


def file_stems(names: list[str]) -> list[str]:
    """Return a file name for each UAV, without suffix; all are different, and valid on every system."""
    made: list[str] = []
    for number, name in enumerate(names, 1):
        safe = re.sub(r"[^A-Za-z0-9_.-]+", "_", name).strip("._-")[:60] or f"uav-{number}"
        taken = {one.lower() for one in made}
        made.append(safe if safe.lower() not in taken else f"{safe}-{number}")
    return made


Contents = dict[Path, str | dict[str, str]]
"""What files are to hold: a text, or an archive of texts, given by their names in it."""


def write_files(contents: Contents) -> None:
    """Write all files, or none where one cannot be written; equal contents give equal bytes.

    Whenever the program is killed, no new file stands beside an old one of the set: some may be missing.
    """
    with ExitStack() as stack:
        for path, held in contents.items():
            part = stack.enter_context(whole_file(path))
            if isinstance(held, str):
                part.write_text(held, encoding="utf-8", newline="\n")
                continue
            with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
                for name, text in held.items():
                    archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED)
        for path in contents if len(contents) > 1 else ():
            path.unlink(missing_ok=True)


HOME_TOLERANCE = 0.1
"""Metres: a home may be so much lower than any ground that the scenario knows, as files and grids round both."""


def require_format(mission: Mission, scenario: Scenario, suffix: str, options: ExportOptions, what: str) -> None:
    """Raise `InputError` where a format in degrees cannot hold a mission, whatever is proven of it.

    `scenario` is the mission's with an origin; `what` is what messages call the output.
    """
    altitude = options.altitude
    require_reference(scenario, altitude, ALTITUDE_REFERENCES[suffix], what)
    if suffix in ROUTE_SUFFIXES:
        autopilot_for(suffix, altitude, options.autopilot)
        flying = zip(scenario.uavs, mission.trajectories, strict=True)
        planes = [uav.name for uav, flight in flying if flight is not None and uav.fixed_wing is not None]
        if suffix in DJI_SUFFIXES and planes:
            raise InputError(f"{', '.join(planes)}: files for DJI are for multirotors, not for aeroplanes")
    if suffix == ".geojson" or (suffix == ".wpml.kmz" and altitude == "amsl"):
        geoid_of(scenario, what if suffix == ".geojson" else "DJI's waylines, above the sea")
    if suffix in ROUTE_SUFFIXES or altitude == "home":
        require_plausible_homes(scenario)


def require_survey_items(scenario: Scenario, suffix: str) -> None:
    """Raise `InputError` where QGroundControl's own survey item cannot hold the surveys of a file."""
    if suffix != ".plan":
        raise InputError(f"expected a .plan, which alone has survey items, found {suffix}", field="survey_item")
    for survey in scenario.surveys:
        if len(survey.area) > 1 or any(part.holes for part in survey.area):
            raise InputError(
                f"{survey.name}: expected an area of one part without holes, as QGroundControl's survey items have, "
                f"found {counted(len(survey.area), 'part')} and "
                f"{counted(sum(len(part.holes) for part in survey.area), 'hole')}",
                field="survey_item",
            )


def require_plausible_homes(scenario: Scenario) -> None:
    """Raise `InputError` for a home where there can be no ground to stand on.

    A home may be as low as the bounds, or as the lowest ground that the terrain may have there, which can be lower.
    """
    for number, uav in enumerate(scenario.uavs):
        if uav.home is None:
            continue
        lowest, noun = scenario.bounds.min[2], "the bounds"
        if scenario.terrain is not None:
            ground = float(scenario.terrain.lowest_ground.height(uav.start[:2]))
            if ground < lowest:
                lowest, noun = ground, "the lowest ground there"
        if uav.home < lowest - HOME_TOLERANCE:
            raise InputError(
                f"uavs[{number}].home ({uav.name}): expected the ground below the start, at z = {lowest:.6g} m or "
                f"higher, found {uav.home:.6g} m, which is below {noun}"
            )


def require_no_movers(scenario: Scenario, what: str) -> None:
    """Raise `InputError` for a scenario with movers; `what` is what would be made of it."""
    if scenario.movers:
        raise InputError(
            f"{what}: scenario {scenario.name!r} has movers, and no autopilot keeps a schedule exactly enough to be "
            "proven clear of them; formats that keep the times of the flight hold it, such as .csv, .geojson and ROS's"
        )


def require_homes(scenario: Scenario, uavs: Sequence[int]) -> None:
    """Raise `InputError` if an obstacle lies between a UAV's home and its start, as where it starts on a building."""
    ways = [(uav, home(scenario, uav), np.array(scenario.uavs[uav].start)) for uav in uavs]
    ways = [way for way in ways if way[1][2] < way[2][2]]
    if not ways:
        return
    bare = referee_world(derived(scenario, clearance=0.0, terrain=None))
    below, starts = (np.array([way[k] for way in ways]) for k in (1, 2))
    incursion = judge_segments(bare, below, starts).incursion
    if incursion is not None:
        named = scenario.obstacles[incursion.obstacle].name
        raise InputError(
            f"{scenario.uavs[ways[incursion.segment][0]].name}: its home, the ground below its start, cannot be risen "
            f"from: obstacle {incursion.obstacle}{f' ({named})' if named else ''} lies between; "
            "count altitudes from the sea (amsl)"
        )


TOO_CLOSE = (Fault.SEPARATION, Fault.GIVEN)
"""What is wrong between two UAVs, which a caller may allow."""


def require_not_refuted(
    mission: Mission, scenario: Scenario, path: Path, *, allow_close: bool
) -> tuple[list[str], Mission]:
    """Let the referee judge a mission; return in sentences what it has not proven, and the mission with its verdict.

    Parameters
    ----------
    mission
        What is to be exported. The certificates and violations that it carries are not believed.
    scenario
        What it is judged by.
    path
        The file to write, which messages name.
    allow_close
        Whether UAVs may come too close to each other.

    Raises
    ------
    InputError
        If the referee refutes the mission.
    """
    found = judged(scenario, mission)
    violations = found.violations
    close = [one for one in violations if one.fault in TOO_CLOSE]
    doubtful = [one for one in violations if one.fault is Fault.UNDECIDED]
    wrong = [one for one in violations if one.fault not in (*TOO_CLOSE, Fault.UNDECIDED)]
    if wrong or (close and not allow_close):
        remedy = Remedy("allow_close", True, "to export it all the same")
        said = f"{path}: the referee refutes this mission: {_told(wrong + close)}; skyverse check tells all of it"
        raise InputError(said, give=[] if wrong else [remedy])
    notes = [f"{Caution.NOT} apart, as the referee finds: {_told(close)}."] if close else []
    notes += [f"{Caution.NOT} proven by the referee: {_told(doubtful)}."] if doubtful else []
    return notes, found


def _told(violations: Sequence[Violation]) -> str:
    """Return the message of the first violation, without its full stop, and how many more there are."""
    more = f" (and {len(violations) - 1} more)" if len(violations) > 1 else ""
    return violations[0].message.removesuffix(".") + more


def with_zones_always_active(
    mission: Mission, what: str, certificates: Sequence[Certificate | None] | None = None
) -> Mission:
    """Return a mission in whose scenario all zones are active at all times, to prove legs and returns in.

    The zones of that scenario have other numbers, or are obstacles: what is said of the mission as given is said first.

    Parameters
    ----------
    mission
        The mission as given.
    what
        What would be made of it.
    certificates
        What the referee proves of each UAV's trajectory as given, if it has been asked; the mission's own are not
        believed.

    Raises
    ------
    InputError
        If a flight keeps clear of a zone, or to its speed limit, by its schedule alone.
    """
    given = mission.scenario
    numbers = temporary_zones(given)
    if not numbers:
        return mission
    lasting = replace(mission, scenario=with_zones_active(given, numbers))
    now = certify(given, mission).trajectories if certificates is None else certificates
    always = certify(lasting.scenario, lasting)
    for uav, (before, after) in enumerate(zip(now, always.trajectories, strict=True)):
        if before is None or after is None or before.verdict is not Verdict.PROVEN:
            continue
        if after.verdict is not Verdict.PROVEN:
            zones = listed([told_zone(given, number) for number in numbers if not _keeps_to(mission, uav, number)])
            raise InputError(
                f"{what}: {given.uavs[uav].name} keeps to the rules of {zones} by its schedule alone, and no autopilot "
                "keeps a schedule exactly enough; formats that keep the times of the flight hold it, such as .csv, "
                ".geojson and ROS's"
            )
    return replace(lasting, certificates=always.trajectories, apart=always.apart)


def _keeps_to(mission: Mission, uav: int, zone: int) -> bool:
    """Tell whether it is proven that a UAV would keep to the rules of a zone if that were always active."""
    scenario = with_zones_active(mission.scenario, {zone})
    certificate = certify(scenario, replace(mission, scenario=scenario)).trajectories[uav]
    return certificate is not None and certificate.verdict is Verdict.PROVEN
