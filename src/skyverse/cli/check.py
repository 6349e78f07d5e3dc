"""The verb ``check``: missions judged, those that skyverse planned and those that people have."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from skyverse.cli.check_photos import PhotoOptions, check_photos
from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.given_missions import judged, refuse_outputs, taking_missions, tell
from skyverse.cli.given_scenario import judging_scenario, without_way
from skyverse.cli.option_names import as_in
from skyverse.cli.option_types import AsJson, GivenMission, GivenScenario
from skyverse.cli.report import json_text, say, told_violations, violation_data
from skyverse.errors import InputError, require_file
from skyverse.model.short_lines import counted

_PHOTOS = PhotoOptions()


@taking_missions
def check(
    *missions: GivenMission,
    scenario: GivenScenario | None = None,
    as_json: AsJson = False,
    page: Path | None = None,
    photos: PhotoOptions = _PHOTOS,
    **given: Any,
) -> int:
    """Judge missions: those of ground stations and apps as their autopilots fly them, and those of skyverse.

    QGroundControl .plan, Mission Planner .waypoints and .txt, DJI .kmz, Litchi .csv, and routes as .kml and .gpx, each
    a vehicle's mission: all that is flown between waypoints, take-off, landing, the way home, heights above ground,
    fences, limits, and whether vehicles that start together keep apart. They are judged over maps, or in a scenario.
    What is wrong is told by the numbers that ground stations show.

    A mission of skyverse (.json) is judged by the referee, whatever planned it: what is wrong, and what is proven of
    each UAV's flight and of the fleet.

    Photos that were taken (.csv of exiftool, geo.txt) are judged by the survey that they are of.

    Examples: `skyverse check flight.plan --terrain dem.tif --vehicle camera`,
    `skyverse check one.plan two.plan --terrain dem.tif --zones zones.geojson --page check.html`,
    `skyverse check out/table-4.8.json --scenario table-4.8`,
    `skyverse check flown.csv --survey field.json --reflight again.json`

    Exit code: 0 when all is proven but for what the verdict names; 1 when anything is wrong or cannot be decided, or
    when a UAV has no way; 2 for bad input.

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
    if photos.survey is not None:
        altitude = given.pop("altitude", None)
        if given or scenario is not None or page is not None:
            raise InputError("--survey: expected --reflight, --position-error and --altitude at most, found more")
        return check_photos(missions, photos.survey, photos, altitude, as_json=as_json)
    if photos != _PHOTOS:
        raise InputError("--reflight and --position-error: expected --survey and photos, found none")
    import skyverse as sky

    planned = [one for one in missions if Path(one).suffix.lower() in ("", ".json")]
    if planned:
        if len(missions) > 1 or given or page is not None:
            require_file(Path(planned[0]))
            said = "expected it alone, with --scenario at most, found more"
            raise InputError(f"{planned[0]}: a mission of skyverse: {said}")
        return check_planned(planned[0], scenario, as_json=as_json)
    refuse_outputs([] if page is None else [page], missions, given)
    return tell(judged(missions, scenario, given, sky.check_waypoints), page, as_json)


def check_planned(mission: str, scenario: str | None, *, as_json: bool) -> int:
    """Let the referee judge a mission of skyverse, and print what is wrong and what is proven."""
    import skyverse as sky
    from skyverse import referee
    from skyverse.model.go_no_go import go_no_go
    from skyverse.space.mission_cautions import mission_cautions

    planned = sky.read_mission(mission)
    world, judged_by = judging_scenario(planned, scenario)
    planned = referee.judged(world, planned)
    violations, found = planned.violations, go_no_go(planned)
    if as_json:
        print(json_text([violation_data(v) for v in violations]), end="")
    else:
        found_wrong = f"{counted(len(violations), 'violation')} found."
        say(*told_violations(violations), found_wrong if violations else "The referee found nothing wrong.")
    aside = sys.stderr if as_json else sys.stdout
    print(judged_by, file=aside)
    apart = planned.apart if len(world.uavs) > 1 else None
    for certificate in (*planned.certificates, apart, *planned.coverage):
        if certificate is not None and certificate.verdict is sky.Verdict.PROVEN:
            print(f"proven: {certificate.sentence}", file=aside)
    # what was told when it was planned is told no more, but what comes after the instant until which proofs hold
    told = [one for one in mission_cautions(replace(planned, coverage=())) if one.kind != "comes later"]
    with as_in("show"):  # a mission of skyverse takes none of the options of maps
        new = (one for one in mission_cautions(replace(planned, scenario=world)) if one not in told)
        say(*(caution.sentence for caution in new), aside=as_json)
    if any(result is not None and result.status is sky.Status.OPTIMAL for result in planned.results):
        print("Where a path is called optimal, it is so as claimed by the planner.", file=aside)
    if not planned.complete:
        print(without_way(planned), file=sys.stderr)
    print(found.sentence, file=aside)
    return 0 if found.go else FOUND_WRONG
