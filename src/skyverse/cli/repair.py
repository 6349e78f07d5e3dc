"""``skyverse repair``: missions of autopilots mended, judged again, and written as they were read."""

from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from skyverse.cli.given_missions import judged, refuse_outputs, taking_missions, tell
from skyverse.cli.option_types import FLAG, OUTPUT, AsJson, GivenMission, GivenScenario
from skyverse.errors import InputError
from skyverse.model.short_lines import counted

if TYPE_CHECKING:
    from skyverse.waypoints.repair import RepairedFleet


@taking_missions
def repair(
    *missions: GivenMission,
    output: Annotated[Path, OUTPUT],
    scenario: GivenScenario | None = None,
    lift_only: Annotated[bool, FLAG] = False,
    as_json: AsJson = False,
    page: Path | None = None,
    **given: Any,
) -> int:
    """Mend missions of ground stations and apps so that they are proven, and write them as they were read.

    The waypoints, what is done at them, their order and their speeds stay. Places that are not safe are moved least,
    legs are led over or around what they meet, corners are cut less, and vehicles that come too close start later. What
    was not changed is in the new file as it was. What is written is judged again.

    Examples: `skyverse repair flight.plan --terrain dem.tif --vehicle camera -o fixed.plan`,
    `skyverse repair one.plan two.plan --terrain dem.tif -o fixed/`

    Exit code: 0 when all is proven; 1 when something could not be mended, which is told; 2 for bad input.

    Parameters
    ----------
    missions
        Missions of autopilots, one for each vehicle.
    output
        The file to write, of the same format; a folder where there are several missions.
    scenario
        The scenario in which missions are judged, a file or a built-in name, in place of maps.
    lift_only
        Change nothing but heights.
    as_json
        Print what was changed and what is found now as JSON.
    page
        A web page to write: the mended missions over the terrain.
    """
    import skyverse as sky
    from skyverse.atomic import write_text
    from skyverse.orders.files import require_same_format

    if not missions:
        raise InputError("expected a mission to mend, found none", field="missions")
    sources = list(map(Path, missions))
    several = len(sources) > 1 or output.is_dir()
    files = [output / source.name for source in sources] if several else [output]
    refuse_outputs(files if page is None else [*files, page], missions, given)
    for source, file in zip(sources, files, strict=True):
        require_same_format(source, file)
    mended = judged(missions, scenario, given, partial(sky.repair_waypoints, lift_only=lift_only))
    if several:
        output.mkdir(parents=True, exist_ok=True)
    parameters = [*_parameters(mended, files)]
    for loaded in filter(None, parameters):  # whenever this is killed, no mission has parameters of another
        loaded[0].unlink(missing_ok=True)
    for one, file in zip(mended.missions, files, strict=True):
        sky.write_waypoints(one, file)
    for loaded in filter(None, parameters):
        write_text(*loaded)
    for source, changes in zip(() if as_json else sources, mended.changes, strict=False):
        print(f"{source}: {counted(len(changes), 'change')}")
        for change in changes:
            print(f"  {'-'.join(map(str, change.items)) + ': ' if change.items else ''}{change.said}")
    more = [
        {"written": str(file), "parameters": loaded and str(loaded[0]), "changes": [asdict(one) for one in changes]}
        for file, loaded, changes in zip(files, parameters, mended.changes, strict=True)
    ]
    return tell(mended.checked, page, as_json, more)


def _parameters(mended: "RepairedFleet", files: list[Path]) -> Iterator[tuple[Path, str] | None]:
    """Yield the file and the text of the parameters of each mission that returns at another altitude now."""
    from skyverse.exports.parameters import parameter_file, parameters_text

    for mission, file in zip(mended.checked.missions, files, strict=True):
        plan, back = mission.flown.plan, mission.back
        own = parameter_file(file, file.suffix, plan)
        told = mission.flown.waypoints
        if own is None or back is None or not (told.retraces or told.return_altitude is not None):
            yield None
            continue
        yield own, parameters_text(plan, mended.checked.scenario.uavs[plan.route.uav], back)
