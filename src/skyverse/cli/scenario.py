"""The verb that makes a scenario of the user's own maps."""

import dataclasses
import inspect
import math
import re
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, get_args, get_origin

from cyclopts import App, Group, Parameter
from pydantic import TypeAdapter, ValidationError

from skyverse.cli.option_names import for_command_line, option_of
from skyverse.cli.option_types import OUTPUT, AsJson
from skyverse.cli.outputs import refuse_output
from skyverse.cli.places import (
    altitude_above_sea,
    altitude_of,
    height_above_ground,
    numbers_of,
    origin_of,
    places_of,
    tracking_error_of,
)
from skyverse.cli.report import json_text
from skyverse.cli.watch import console
from skyverse.errors import InputError
from skyverse.maps.assembly.options import BuildOptions, MapDetail, MapFiles, MapRegion
from skyverse.maps.georeference.reading import Raster, Reading
from skyverse.model.built_with import Words
from skyverse.model.caution import stands_out
from skyverse.model.short_lines import TIMES, counted, listed
from skyverse.model.vehicle_profiles import FleetLimits

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import Note
    from skyverse.model.scenario import Scenario


app = App(name="scenario", help="Make scenarios of maps.")

what = Group("What to read", sort_key=1)
fleet = Group("What the UAVs are", sort_key=1)
where = Group("What part of the world, and how", sort_key=2)
terrain_files = Group("How terrain files are to be read, where they do not say", sort_key=3)
other_files = Group("How files of buildings and zones are to be read, where they do not say", sort_key=4)


def _risk(word: str) -> tuple[str, float]:
    file, equals, text = word.rpartition("=")
    if not (file and equals and text):
        raise InputError(f"--soft-zones: expected FILE=RISK, as in zones.geojson=0.5, found {word!r}")
    try:
        return file, float(text)
    except ValueError:
        raise InputError(f"--soft-zones: expected a number after {file}=, found {text!r}") from None


def _licence(word: str) -> tuple[str, str]:
    file, equals, text = word.partition("=")
    if not (file and equals and text):
        raise InputError(f"--licence: expected FILE=TEXT, found {word!r}")
    return file, text


def _fill(text: str) -> float | str:
    try:
        return "nearest" if text == "nearest" else float(text)
    except ValueError:
        raise InputError(f"--fill-nodata: expected metres above sea level, or nearest, found {text!r}") from None


class _TextOption(NamedTuple):
    """An option whose value is written otherwise than the parameter that it stands for.

    Attributes
    ----------
    kind
        The type of what is written.
    form
        How it is written, or ``""`` where the type says enough.
    value
        Makes the parameter's value of what is written.
    settings
        What cyclopts must know besides.
    """

    kind: Any
    form: str = ""
    value: Callable[[Any], Any] = lambda written: written
    settings: Parameter = Parameter(allow_leading_hyphen=True)


_several = Parameter(consume_multiple=True)
_TEXTS = {
    "terrain": _TextOption(list[Path], settings=_several),
    "buildings": _TextOption(list[Path], settings=_several),
    "zones": _TextOption(list[Path], settings=_several),
    "voxels": _TextOption(list[Path], settings=_several),
    "fence": _TextOption(list[Path], settings=_several),
    "max_heights": _TextOption(list[Path], settings=_several),
    "soft_zones": _TextOption(list[str], "`FILE=RISK`", lambda words: list(map(_risk, words)), _several),
    "licence": _TextOption(list[str], "`FILE=TEXT`", lambda words: dict(map(_licence, words)), _several),
    "uav": _TextOption(
        list[str],
        "`46.81,9.85,60 m agl`, or `alpha=46.81,9.85,60 m agl` with a name; repeat --uav for more",
        lambda texts: places_of("--uav", "uav", texts),
    ),
    "target": _TextOption(
        list[str],
        "`46.806,9.845,60 m agl`; repeat --target for more",
        lambda texts: places_of("--target", "target", texts),
    ),
    "area": _TextOption(
        str, "`9.84,46.79,9.87,46.81`", lambda text: numbers_of("--area", "west,south,east,north in degrees", text, 4)
    ),
    "origin": _TextOption(str, "`46.81,9.85,1560 m amsl`", origin_of),
    "ground": _TextOption(str, "`0 m amsl`", lambda text: altitude_above_sea("--ground", text)),
    "ceiling": _TextOption(str, "`120 m agl`", lambda text: altitude_of("--ceiling", text)),
    "max_height": _TextOption(str, "`120 m agl`", lambda text: height_above_ground("--max-height", text)),
    "tracking_error": _TextOption(str, "`1.5,2`", tracking_error_of),
    "band": _TextOption(str, "`40,80`", lambda text: numbers_of("--band", "low,high in metres above ground", text, 2)),
    "fill_nodata": _TextOption(str, "`1550` or `nearest`", _fill),
    "terrain_unit": _TextOption(Literal["m", "ft", "us-ft"], settings=Parameter()),
    "nodata": _TextOption(float),
}
"""By the option's name; the values of all others are numbers and words, written as they are."""
_GROUPS = {
    MapFiles: what,
    FleetLimits: fleet,
    MapRegion: where,
    MapDetail: where,
    Raster: terrain_files,
    Reading: other_files,
}


def _name(owner: type, field: str) -> str:
    """Return the name of the option for a parameter, as ``terrain_crs`` for ``Raster.crs``."""
    return option_of(f"{owner.__name__}.{field}").removeprefix("--").replace("-", "_")


def _documentation(options: type) -> dict[str, str]:
    """Return the documentation of each attribute of an options class, those of its bases first."""
    found: dict[str, str] = {}
    for base in reversed(options.__mro__[:-1]):
        _, _, entries = inspect.cleandoc(base.__doc__ or "").partition("Attributes\n----------\n")
        found |= dict(re.findall(r"^(\w+)\n((?: .*\n?)+)", entries, re.MULTILINE))
    return {name: inspect.cleandoc(text) for name, text in found.items()}


def map_options(without: Collection[str] = ()) -> Iterator[inspect.Parameter]:
    """Yield an option for each parameter of the classes in `_GROUPS`, with the documentation that it has there."""
    for owner, group in _GROUPS.items():
        documented = _documentation(owner)
        for field in dataclasses.fields(owner):
            name = _name(owner, field.name)
            if name == "path" or name in without:  # the path of a raster: these are the files of --terrain
                continue
            said = re.sub(r'``"?(.*?)"?``', r"`\1`", " ".join(documented.get(field.name, "").split()))
            text = _TEXTS.get(name, _TextOption(None, settings=Parameter()))
            yield inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=field.default if text.kind is None else None,
                annotation=Annotated[
                    field.type if text.kind is None else text.kind | None,
                    text.settings,
                    Parameter(group=group, help=f"{said} Written as {text.form}." if text.form else said),
                ],
            )


def _values(owner: type, given: dict[str, Any]) -> dict[str, Any]:
    """Return the values of those parameters of a class whose options are given."""
    names = {field.name: _name(owner, field.name) for field in dataclasses.fields(owner)}
    return {
        field: _TEXTS[name].value(given[name]) if name in _TEXTS else given[name]
        for field, name in names.items()
        if name in given
    }


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
        given = given_again(again, kept, {one.name: one for one in (own, *map_options())}) | given
        mission = given.pop("mission", None) if mission is None else mission
    words = kept_words(given if mission is None else given | {"mission": mission})
    refuse_output(output, *map_files(given), *([] if mission is None else [mission]))
    notes: list[Note] = []
    with watched(notes) as on_note:
        options = build_options(name or output.stem, given, on_note)
        if mission is None:
            made = build_scenario(options)
        else:
            from skyverse.waypoints.files import read_waypoints
            from skyverse.waypoints.site import options_of_mission, with_mission

            read = read_waypoints(mission, geoid=options.geoid)
            made = with_mission(build_scenario(options_of_mission(read, options)), read)
        made = made.model_copy(update={"built_with": words})
        write(made, output)
    _report(made, notes, output, as_json)


def map_files(given: Mapping[str, Any]) -> list[Path]:
    """Return all files that options of maps name."""
    soft = (Path(path) for path, _ in map(_risk, given.get("soft_zones", ())))
    return [
        *(
            path
            for kind in ("terrain", "buildings", "zones", "fence", "max_heights", "voxels")
            for path in given.get(kind, ())
        ),
        *soft,
    ]


def build_options(name: str, given: dict[str, Any], on_note: "Callable[[Note], object]") -> BuildOptions:
    """Return the options of a scenario from those of the command line."""
    files, raster = _values(MapFiles, given), _values(Raster, given)
    files["terrain"] = [Raster(path, **raster) for path in files.get("terrain", ())]
    return BuildOptions(
        name,
        **files,
        **_values(FleetLimits, given),
        **_values(MapRegion, given),
        **_values(MapDetail, given),
        reading=Reading(**_values(Reading, given)),
        on_note=on_note,
    )


_own = [one for one in inspect.signature(build).parameters.values() if one.kind is inspect.Parameter.KEYWORD_ONLY]
build.__signature__ = inspect.Signature([*_own, *map_options()])  # type: ignore[attr-defined]
app.command(build)


@contextmanager
def watched(notes: "list[Note]") -> "Iterator[Callable[[Note], None]]":
    """Yield a function that keeps notes, and shows the last one when a person watches.

    Where that ends in a refusal, all notes are printed, as they may explain it.
    """
    try:
        with _shown(notes) as on_note:
            yield on_note
    except InputError:
        for note in notes:
            print(told(note), file=sys.stderr)
        raise


@contextmanager
def _shown(notes: "list[Note]") -> "Iterator[Callable[[Note], None]]":
    if not sys.stderr.isatty():
        yield notes.append
        return
    with console().status("reading maps") as status:

        def keep(note: "Note") -> None:
            notes.append(note)
            status.update(f"{Path(note.file).name} {note.text}"[:100])

        yield keep


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
    for note in done:
        print(told(note))
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
    print(output)
    if heed:
        print("Before you fly, heed:")
    for note in heed:
        print(f"  {told(note)}")


def must_be_heeded(note: "Note") -> bool:
    """Tell whether a pilot must heed a note."""
    return note.heed or stands_out(note.text)


def told(note: "Note") -> str:
    """Return a note as it is printed."""
    text = for_command_line(note.text)
    return f"{Path(note.file).name}: {text}" if note.file else text


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
    for name, *told in words:
        if name not in options or not told:
            raise InputError(f"{source}: built_with: expected options of scenario build, found {name!r:.60}")
        kind = options[name].annotation
        kind = get_args(kind)[0] if get_origin(kind) is Annotated else kind
        several = any(get_origin(one) is list for one in (kind, *get_args(kind)))
        try:
            given[name] = TypeAdapter(kind).validate_python(told if several else told[0])
        except ValidationError:
            raise InputError(f"{source}: built_with: {name}: found {told!r:.100}, which it does not take") from None
    return given
