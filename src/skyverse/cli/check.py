"""The verb ``check``: missions judged, those that skyverse planned and those that people have."""

import inspect
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.given_scenario import judging_scenario, without_way
from skyverse.cli.option_names import as_in, for_command_line
from skyverse.cli.option_types import SIGNED, AsJson, GivenMission, GivenScenario
from skyverse.cli.outputs import refuse_output
from skyverse.cli.places import numbers_of
from skyverse.cli.report import json_text, table, violation_data
from skyverse.cli.scenario import build_options, map_files, map_options, must_be_heeded, told, watched
from skyverse.errors import InputError
from skyverse.model.caution import Caution
from skyverse.model.short_lines import counted

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import BuildOptions, Note
    from skyverse.model.scenario import Scenario
    from skyverse.model.waypoints import Waypoints
    from skyverse.waypoints.fleet import CheckedFleet
    from skyverse.waypoints.flown import FlightSettings


@Parameter(name="*", group=Group("How the missions of autopilots are flown"))
@dataclass(frozen=True)
class FlownOptions:
    """What the files of missions may not say.

    Attributes
    ----------
    autopilot
        What flies the mission; that of the file, or else px4, when left out.
    home
        Where the vehicle takes off, latitude,longitude in place of the file's, as in `46.81,9.85`.
    speed
        m/s until the mission says another; the file's, or else the autopilot's usual one, when left out.
    altitude
        What altitudes are counted from in files that do not say it, as GPX: mean sea level, home, or the ground below.
    radius
        Metres from a waypoint at which the autopilot turns to the next, where the file leaves it open.
    return_altitude
        Metres above home at which the vehicle returns; the file's, or else the autopilot's usual one, when left out.
    clearance
        How far the vehicle must stay away from obstacles, metres, beyond its tracking error; 2 when left out.
    ground_clearance
        How far it must stay above ground, metres, beyond its tracking error; 2 when left out.
    max_height
        How high above the ground below it may fly; `120 m agl` when left out.
    """

    autopilot: Literal["px4", "ardupilot", "dji"] | None = None
    home: Annotated[str | None, SIGNED] = None
    speed: float | None = None
    altitude: Literal["amsl", "home", "agl"] | None = None
    radius: float = 2.0
    return_altitude: float | None = None
    clearance: float | None = None
    ground_clearance: float | None = None
    max_height: str | None = None


_FLOWN = FlownOptions()
NOT_OF_CHECK = (
    *("uav", "target", "area", "margin", "origin", "ceiling", "band", "band_weight", "lattice_step", "licence"),
    *("clearance", "ground_clearance", "max_height", "soft_zones", "voxel_size"),
)
"""Options of maps that missions leave no choice of, or that have other defaults here."""


def check(
    *missions: GivenMission,
    scenario: GivenScenario | None = None,
    as_json: AsJson = False,
    page: Path | None = None,
    how: FlownOptions = _FLOWN,
    **given: Any,
) -> int:
    """Judge missions: those of ground stations and apps as their autopilots fly them, and those of skyverse.

    QGroundControl .plan, Mission Planner .waypoints and .txt, DJI .kmz, Litchi .csv, and routes as .kml and .gpx, each
    a vehicle's mission: all that is flown between waypoints, take-off, landing, the way home, heights above ground,
    fences, limits, and whether vehicles that start together keep apart. They are judged over maps, or in a scenario.
    What is wrong is told by the numbers that ground stations show.

    A mission of skyverse (.json) is judged by the referee, whatever planned it: what is wrong, and what is proven of
    each UAV's flight and of the fleet.

    Examples: `skyverse check flight.plan --terrain dem.tif --vehicle camera`,
    `skyverse check one.plan two.plan --terrain dem.tif --zones zones.geojson --page check.html`,
    `skyverse check out/table-4.8.json --scenario table-4.8`

    Exit code: 0 when all is proven; 1 when anything is wrong or cannot be decided, or when a UAV has no way; 2 for bad
    input.

    Parameters
    ----------
    missions
        A mission of skyverse, or missions of autopilots, one for each vehicle.
    scenario
        The scenario in which missions are judged, a file or a built-in name. A mission of skyverse is judged by the
        scenario that it embeds when it is left out.
    as_json
        Print what is found as JSON.
    page
        A web page to write: the missions over the terrain, with what is wrong marked on map and profile.
    """
    if not missions:
        raise InputError("expected a mission to judge, found none", field="missions")
    import skyverse as sky
    from skyverse.waypoints.files import is_waypoint_file

    planned = [one for one in missions if not is_waypoint_file(one)]
    if planned:
        options = [f"--{name.replace('_', '-')}" for name in given]
        if len(missions) > 1 or options or page is not None or how != _FLOWN:
            said = "expected it alone, with --scenario at most, found more"
            raise InputError(f"{planned[0]}: a mission of skyverse: {said}")
        return check_planned(planned[0], scenario, as_json=as_json)
    if page is not None:
        refuse_output(page, *map(Path, missions), *map_files(given))
    with given_missions(missions, scenario, how, given) as (read, where):
        fleet = sky.check_waypoints(read, where, settings_of(how))
    if page is not None:
        from skyverse.atomic import write_text
        from skyverse.waypoints.page import check_page

        write_text(page, check_page(fleet))
    tell(fleet, as_json=as_json)
    if page is not None:
        print(page, file=sys.stderr if as_json else sys.stdout)
    return 0 if fleet.is_proven else FOUND_WRONG


_own = [one for one in inspect.signature(check).parameters.values() if one.kind is not inspect.Parameter.VAR_KEYWORD]
check.__signature__ = inspect.Signature([*_own, *map_options(NOT_OF_CHECK)])  # type: ignore[attr-defined]


@contextmanager
def given_missions(
    missions: Sequence[str], scenario: str | None, how: FlownOptions, given: dict[str, Any]
) -> "Iterator[tuple[list[Waypoints], Scenario | BuildOptions]]":
    """Yield missions that were read, and where they are flown: a scenario, or the maps that options name."""
    import skyverse as sky

    usual = {"clearance": 2.0, "ground_clearance": 2.0, "max_height": "120 m agl"}
    own = {name: getattr(how, name) for name in usual if getattr(how, name) is not None}
    if scenario is not None and given | own:
        option = f"--{next(iter(given | own)).replace('_', '-')}"
        raise InputError(f"{option}: expected it without --scenario, found both")
    world = None if scenario is None else sky.read_scenario(scenario)
    origin = None if world is None else world.frame.origin
    geoid = given.get("geoid") if origin is None else origin.geoid
    read = [sky.read_waypoints(one, altitude=how.altitude, geoid=geoid) for one in missions]
    if world is not None:
        yield read, world
        return
    notes: list[Note] = []
    with watched(notes) as on_note:
        yield read, build_options("check", given | usual | own, on_note)
    for note in filter(must_be_heeded, notes):
        print(told(note), file=sys.stderr)


def settings_of(how: FlownOptions) -> "FlightSettings":
    """Return how missions are flown."""
    import skyverse as sky

    home = None if how.home is None else numbers_of("--home", "latitude,longitude in degrees", how.home, 2)
    return sky.FlightSettings(how.autopilot, home, how.speed, how.radius, how.return_altitude)


def tell(fleet: "CheckedFleet", *, as_json: bool) -> None:
    """Print what is found of missions."""
    from skyverse.waypoints.report import as_data, assumptions, check_table, finding_line

    if as_json:
        print(json_text(as_data(fleet)), end="")
        return
    for number, mission in enumerate(fleet.missions):
        verdict = "proven" if mission.is_proven else counted(sum(one.wrong for one in mission.findings), "fault")
        table((mission.flown.waypoints.name, verdict), check_table(fleet, number))
        for finding in mission.findings:
            print(("" if finding.wrong else f"{Caution.WARNING}: ") + finding_line(fleet, number, finding))
        for said in assumptions(fleet, number):
            print(said)


def check_planned(mission: str, scenario: str | None, *, as_json: bool) -> int:
    """Let the referee judge a mission of skyverse, and print what is wrong and what is proven."""
    import skyverse as sky
    from skyverse.referee import judge
    from skyverse.space.mission_cautions import mission_cautions

    judged = sky.read_mission(mission)
    world, judged_by = judging_scenario(judged, scenario)
    violations, certificates = judge(world, judged)
    if as_json:
        print(json_text([violation_data(v) for v in violations]), end="")
    else:
        for violation in violations:
            print(f"{violation.fault.value}: {violation.message}")
        print(f"{counted(len(violations), 'violation')} found." if violations else "The referee found nothing wrong.")
    aside = sys.stderr if as_json else sys.stdout
    print(judged_by, file=aside)
    apart = certificates.apart if len(world.uavs) > 1 else None
    for certificate in (*certificates.trajectories, apart):
        if certificate is not None and certificate.verdict is sky.Verdict.PROVEN:
            print(f"proven: {certificate.sentence}", file=aside)
    with as_in("show"):  # a mission of skyverse takes none of the options of maps
        for caution in mission_cautions(replace(judged, scenario=world)):
            print(for_command_line(caution.sentence), file=aside)
    if any(result is not None and result.status is sky.Status.OPTIMAL for result in judged.results):
        print("Where a path is called optimal, it is so as claimed by the planner.", file=aside)
    if not judged.complete:
        print(without_way(judged), file=sys.stderr)
    return FOUND_WRONG if violations or not judged.complete else 0
