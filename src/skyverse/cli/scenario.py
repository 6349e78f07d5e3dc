"""The verb that makes a scenario of the user's own maps."""

import inspect
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin

from cyclopts import App, Parameter
from pydantic import TypeAdapter, ValidationError

from skyverse.cli.map_options import (
    MAPS,
    build_options,
    map_files,
    must_be_heeded,
    options_of,
    taking,
    told,
    watched,
)
from skyverse.cli.option_names import for_command_line
from skyverse.cli.option_types import OUTPUT, AsJson
from skyverse.cli.outputs import refuse_output
from skyverse.cli.places import written_places
from skyverse.cli.report import json_text, say
from skyverse.errors import InputError
from skyverse.model.built_with import Words
from skyverse.model.short_lines import TIMES, counted, listed

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import Note
    from skyverse.model.scenario import Scenario


app = App(name="scenario", help="Make scenarios of maps.")


@app.command
@taking(MAPS)
def build(
    *,
    output: Annotated[Path, OUTPUT],
    again: Annotated[str | None, Parameter(name="--from")] = None,
    name: str | None = None,
    mission: Path | None = None,
    as_json: AsJson = False,
    **given: Any,
) -> None:
    """Make a scenario of terrain, buildings and no-fly zones: crop, bring to local metres, simplify, write.

    Altitudes say what they are counted from: `60 m agl` (the ground), `1250 m amsl` (mean sea level), `0 m home`
    (the ground below a UAV's start). Places are latitude,longitude in WGS84 degrees.
    Several files may follow one option.

    Examples: `skyverse scenario build --terrain davosdorf.tif --uav "46.81,9.85,60 m agl" --target
    "46.806,9.845,60 m agl" --vehicle camera -o davos.yaml`, `skyverse scenario build --buildings delft.city.json -o
    delft.yaml`, `skyverse scenario build --terrain dem.tif --zones zones.geojson --area 9.84,46.79,9.87,46.81
    --ceiling "120 m agl" -o valley.yaml`

    Parameters
    ----------
    output
        The scenario file, .yaml or .json; large grids are put beside it.
    again
        A scenario that was built before: all options that it was built with are given again, but for those that are
        given now.
    name
        The scenario's name; the file's when left out.
    mission
        A mission of a ground station: its area, its first and its last place and its speed are taken, where no options
        give them. A plan of the scenario says how much better its way is than the mission's.
    as_json
        Print what was done as JSON.
    """
    from skyverse.files import BUILTIN_NAMES, options_built_with, write
    from skyverse.maps.assembly.build import build_scenario

    if output.suffix.lower() not in (".yaml", ".yml", ".json"):
        raise InputError(f"--output: expected a file ending in .yaml, .yml or .json, found {str(output)!r}")
    if again is not None:
        kept = () if again in BUILTIN_NAMES else options_built_with(Path(again))
        if not kept:
            raise InputError(f"--from: {again}: expected a scenario of skyverse scenario build, found no options in it")
        own = inspect.signature(build).parameters["mission"]
        given = given_again(again, kept, {one.name: one for one in (own, *options_of(MAPS))}) | given
        mission = given.pop("mission", None) if mission is None else mission
    given |= {end: written_places(f"--{end}", given[end]) for end in ("uav", "target") if end in given}
    words = kept_words(given if mission is None else given | {"mission": mission})
    refuse_output(output, *map_files(given), *([] if mission is None else [mission]))
    notes: list[Note] = []
    with watched(notes) as on_note:
        options = build_options(name or output.stem, given, on_note)
        if mission is None:
            made = build_scenario(options)
        else:
            from skyverse.orders.files import read_waypoints
            from skyverse.waypoints.site import options_of_mission, with_mission

            read = read_waypoints(mission, geoid=options.geoid)
            made = with_mission(build_scenario(options_of_mission(read, options)), read)
        made = made.model_copy(update={"built_with": words})
        write(made, output)
    _report(made, notes, output, as_json)


def _report(scenario: "Scenario", notes: "list[Note]", output: Path, as_json: bool) -> None:
    """Print what was done, what the scenario holds, and where it is."""
    low, high = scenario.bounds.min, scenario.bounds.max
    origin = scenario.frame.origin
    assert origin is not None
    sides = zip(low, high, scenario.lattice.step, strict=True)
    nodes = math.prod(int((b - a) / step + 1e-9) + 1 for a, b, step in sides)
    done, heed = ([note for note in notes if must_be_heeded(note) is kind] for kind in (False, True))
    if as_json:
        summary = {
            "file": str(output),
            "done": [{"file": note.file, "text": for_command_line(note.text)} for note in done],
            "heed": [{"file": note.file, "text": for_command_line(note.text)} for note in heed],
            "bounds": {"min": low, "max": high},
            "origin": origin.model_dump(),
            "obstacles": len(scenario.obstacles),
            "zones": len(scenario.zones),
            "uavs": len(scenario.uavs),
            "targets": len(scenario.targets),
            "lattice": {"step": scenario.lattice.step, "nodes": nodes},
            "sources": [source.model_dump() for source in scenario.sources],
        }
        print(json_text(summary), end="")
        return
    say(*map(told, done))
    for source in scenario.sources:
        more = "".join(f", {one}" for one in (source.crs, source.licence) if one)
        print(f"{source.file}: {source.gives}{more}")
    unknown = [source.file for source in scenario.sources if not source.licence and source.flown is None]
    if unknown:
        print(f"licence unknown: {listed(unknown)}; say it with --licence FILE=TEXT")
    zones = [obstacle for obstacle in scenario.obstacles if not obstacle.solid]
    print(
        f"{high[0] - low[0]:g} m by {high[1] - low[1]:g} m by {high[2] - low[2]:g} m around "
        f"{origin.latitude:g}, {origin.longitude:g}, zero at {origin.altitude:g} m amsl; "
        f"{counted(len(scenario.obstacles) - len(zones), 'solid obstacle')}, {counted(len(zones), 'no-fly zone')}, "
        f"{counted(len(scenario.zones), 'zone')} that may be entered, "
        f"{counted(len(scenario.uavs), 'UAV')}, {counted(len(scenario.targets), 'target')}; "
        f"{_kept(scenario)}; lattice of {counted(nodes, 'node')}, "
        f"{TIMES.join(f'{step:g}' for step in scenario.lattice.step)} m apart"
    )
    say(output, *(["Before you fly, heed:"] if heed else []), *(f"  {told(note)}" for note in heed))


def _kept(scenario: "Scenario") -> str:
    """Return what UAVs keep from obstacles and ground, in words."""
    ground = "" if scenario.terrain is None else f" and {scenario.ground_clearance:g} m above ground"
    most = "" if scenario.max_height is None else f", at most {scenario.max_height:g} m above it"
    return f"UAVs keep {scenario.clearance:g} m from obstacles{ground}{most}"


def kept_words(given: Mapping[str, Any]) -> Words:
    """Return options as words."""
    return tuple(
        (name, *map(str, value if isinstance(value, list | tuple) else [value])) for name, value in given.items()
    )


def given_again(source: str, words: Words, options: Mapping[str, inspect.Parameter]) -> dict[str, Any]:
    """Return the options that a scenario's file keeps, as the command line gives them."""
    given: dict[str, Any] = {}
    for name, *values in words:
        if name not in options or not values:
            raise InputError(f"{source}: built_with: expected options of scenario build, found {name!r:.60}")
        kind = options[name].annotation
        kind = get_args(kind)[0] if get_origin(kind) is Annotated else kind
        several = any(get_origin(one) is list for one in (kind, *get_args(kind)))
        try:
            given[name] = TypeAdapter(kind).validate_python(values if several else values[0])
        except ValidationError:
            raise InputError(f"{source}: built_with: {name}: found {values!r:.100}, which it does not take") from None
    return given
