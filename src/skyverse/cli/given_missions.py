"""Missions of autopilots as ``check`` and ``repair`` take them: how they are read, where they fly, what is told."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from cyclopts import Group

from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.map_options import MAPS, build_options, map_files, must_be_heeded, taking, told, values_of, watched
from skyverse.cli.outputs import refuse_output
from skyverse.cli.report import json_text, say, table
from skyverse.errors import InputError
from skyverse.model.flight_settings import FlightSettings

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import BuildOptions, Note
    from skyverse.model.scenario import Scenario
    from skyverse.model.waypoints import Waypoints
    from skyverse.waypoints import CheckedFleet

T = TypeVar("T")


@dataclass(frozen=True)
class KeptByMissions:
    """What missions that people have keep, and what their heights mean, where no option and no file says it.

    Attributes
    ----------
    altitude
        What altitudes are counted from in files that do not say it, as GPX: mean sea level, home, or the ground below.
    clearance
        How far the vehicle must stay away from obstacles, metres, beyond its tracking error; 2 when left out.
    ground_clearance
        How far it must stay above ground, metres, beyond its tracking error; 2 when left out.
    max_height
        How high above the ground below it may fly; `120 m agl` when left out.
    """

    altitude: Literal["amsl", "home", "agl"] | None = None
    clearance: float | None = None
    ground_clearance: float | None = None
    max_height: str | None = None


_USUAL = {"clearance": 2.0, "ground_clearance": 2.0, "max_height": "120 m agl"}
_how = Group("How the missions of autopilots are flown")
taking_missions = taking(
    {FlightSettings: _how, KeptByMissions: _how, **MAPS},
    (
        *(
            "uav",
            "target",
            "area",
            "around",
            "margin",
            "origin",
            "ceiling",
            "band",
            "band_weight",
            "lattice_step",
            "licence",
        ),
        *("soft_zones", "voxel_size"),
    ),
)
"""Lets a verb take all options but those of maps that missions leave no choice of."""


def refuse_outputs(outputs: Sequence[Path], missions: Sequence[str], given: dict[str, Any]) -> None:
    """Refuse files that cannot be written, that would replace what is read, or that are written twice."""
    for k, output in enumerate(outputs):
        refuse_output(output, *missions, *map_files(given))
        if output.resolve() in (other.resolve() for other in outputs[:k]):
            raise InputError(f"{output}: expected another file for each thing that is written, found it twice")


def judged(
    missions: Sequence[str],
    scenario: str | None,
    given: dict[str, Any],
    judge: "Callable[[list[Waypoints], Scenario | BuildOptions, FlightSettings], T]",
) -> T:
    """Return what a function makes of missions that are read, where they fly, and how.

    They fly in a scenario or over the maps that options name.
    """
    import skyverse as sky

    how = values_of(FlightSettings, given)
    maps = {name: value for name, value in given.items() if name not in how and name != "altitude"}
    if scenario is not None and maps:
        raise InputError(f"--{next(iter(maps)).replace('_', '-')}: expected it without --scenario, found both")
    world = None if scenario is None else sky.read_scenario(scenario)
    origin = None if world is None else world.frame.origin
    geoid = given.get("geoid") if origin is None else origin.geoid
    read = [sky.read_waypoints(one, altitude=given.get("altitude"), geoid=geoid) for one in missions]
    if world is not None:
        return judge(read, world, FlightSettings(**how))
    notes: list[Note] = []
    with watched(notes, missions) as on_note:
        found = judge(read, build_options("check", _USUAL | maps, on_note), FlightSettings(**how))
    say(*dict.fromkeys(map(told, filter(must_be_heeded, notes))), aside=True)  # maps may be read more than once
    return found


def tell(fleet: "CheckedFleet", page: Path | None, as_json: bool, more: Sequence[dict[str, Any]] = ()) -> int:
    """Print what is found of missions, and the files; write a page; return the exit code.

    What JSON has more of each mission are, among other things, the file `written` and that of `parameters` to load.
    """
    from skyverse.atomic import write_text
    from skyverse.waypoints.page import check_page
    from skyverse.waypoints.report import as_data, assumptions, check_table, finding_lines, verdict

    more = more or [{}] * len(fleet.missions)
    written = [one[key] for one in more for key in ("written", "parameters") if one.get(key) is not None]
    if page is not None:
        write_text(page, check_page(fleet))
        written.append(str(page))
    if as_json:
        print(json_text([one | found for one, found in zip(more, as_data(fleet), strict=True)]), end="")
    for number, mission in enumerate(() if as_json else fleet.missions):
        loaded = more[number].get("parameters")
        loading = "" if loaded is None else f", with {loaded} loaded"
        print(f"{more[number].get('written', mission.flown.waypoints.name)}: {verdict(mission)}{loading}")
        table(("what was judged", "found"), check_table(fleet, number))
        say(*finding_lines(fleet, number), *assumptions(fleet, number))
    say(*written, aside=as_json)
    return 0 if fleet.is_proven else FOUND_WRONG
