"""The verb ``survey``: from the file of an area to a mission of photos that are proven to show it."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skyverse.cli.map_options import MAPS, build_options, map_files, must_be_heeded, taking, told, watched
from skyverse.cli.option_types import FLAG, SIGNED, WHOLE, GivenMission
from skyverse.cli.outputs import refuse_output
from skyverse.cli.places import numbers_of, points_of
from skyverse.cli.plan import SEARCH, FleetOptions, MissionOutput, PlannerOptions, WindOptions, plan_scenario
from skyverse.cli.report import say
from skyverse.cli.watch import compile_with_bar
from skyverse.errors import InputError
from skyverse.numerics.compiling import before_compiling

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import Note
    from skyverse.model.camera import Camera

_USUAL = {"vehicle": "camera", "max_height": "120 m agl"}
"""Options of maps and vehicles that surveys have where none are given."""


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class AskedOptions:
    """What every survey is asked for, and who flies it.

    Parameters
    ----------
    camera
        The camera: a name such as mavic-3e, which `skyverse cameras` lists; a .yaml or .json file of its sensor, image,
        focal and min_interval; or its sensor, picture and focal length, as in "13.2x8.8 mm, 5472x3648 px, 8.8 mm", and
        perhaps the seconds between photos, as in ", 2.5 s"; 5 when left out.
    gsd
        The ground sample distance at most, as in "2 cm".
    overlap
        Per cent that photos share along strips, and between strips, as in 80,70.
    drones
        How many UAVs fly it, at the same time.
    battery
        What one battery gives: minutes of hovering from full to empty, as in "20 min", or "77 Wh"; the vehicle's own
        when left out.
    launch
        Where UAVs start and land, as in 46.81,9.85, or a file of points; repeat for more. Others start beside it, or,
        where none is given, beside the area, nearest to its middle.
    """

    camera: str
    gsd: str | None = None
    overlap: str | None = None
    drones: Annotated[int, WHOLE] = 1
    battery: str | None = None
    launch: Annotated[list[str] | None, SIGNED] = None


@Parameter(name="*", group=Group("What is to be seen, and how", sort_key=0))
@dataclass(frozen=True, kw_only=True)
class SeenOptions:
    """How a camera is to see it.

    Parameters
    ----------
    height
        Metres from the camera to what it sees, instead of a ground sample distance.
    gsd_of
        Where the ground sample distance is kept: all over each photo, or in the photos nearest to each place.
    pattern
        Strips; strips in two directions; strips straight down and slanting; strips along a line; layers around
        structures; as few photos of them as possible; circles around them.
    direction
        Of strips, degrees clockwise from north; the best when left out.
    gimbal
        Degrees above the horizon at which the camera looks, as in -90.
    trigger
        What autopilots take photos by.
    margin
        Metres beyond the area that are seen as well.
    portrait
        The width of pictures lies along the flight, not across it.
    width
        How broad the ground along a line is that is to be seen, metres, with --pattern corridor.
    structure
        The name of a building that is to be seen; repeat for more.
    """

    height: float | None = None
    gsd_of: Literal["photo", "place"] | None = None
    pattern: Literal["strips", "cross", "oblique", "corridor", "facade", "viewpoints", "orbit"] = "strips"
    direction: float | None = None
    gimbal: Annotated[float | None, SIGNED] = None
    trigger: Literal["distance", "time", "point"] | None = None
    margin: float | None = None
    portrait: Annotated[bool, FLAG] = False
    width: float | None = None
    structure: list[str] | None = None


_SEEN, _SEARCH, _WIND, _WRITTEN = SeenOptions(), PlannerOptions(), WindOptions(), MissionOutput()


@taking(MAPS, ("uav", "target", "around", "margin", "battery", "licence", "band", "band_weight"))
def survey(
    *files: GivenMission,
    asked: AskedOptions,
    seen: SeenOptions = _SEEN,
    criterion: Annotated[Literal["min-sum", "min-max"], Parameter(group=SEARCH)] = "min-max",
    search: PlannerOptions = _SEARCH,
    wind: WindOptions = _WIND,
    written: MissionOutput = _WRITTEN,
    **given: Any,
) -> int:
    """Plan a survey: photos that show an area, a line or buildings as finely as asked, proven over the terrain.

    Areas and lines are read from KML, KMZ, GeoJSON, Shapefile and GeoPackage, as Google Earth, QGIS and ground stations
    write them. UAVs start and land beside the area, and change batteries as often as they need.

    Examples: `skyverse survey field.kml --terrain dem.tif --zones zones.geojson --camera mavic-3e --gsd "2 cm"
    --overlap 80,70 --drones 3 --battery "20 min" -o out/field.json`, `skyverse survey road.kml --terrain dem.tif
    --pattern corridor --width 60 --camera phantom-4-rtk --height 80`, `skyverse survey --buildings town.geojson
    --structure tower --pattern facade --terrain dem.tif --camera mavic-3e --gsd "1 cm"`

    Exit code: 0 when the mission is complete and all is proven, the coverage too; 1 when not; 2 for bad input.

    Parameters
    ----------
    files
        The area, or the line, all polygons or lines of each file.
    criterion
        What is least: the sum of all flights, or the longest, so that UAVs finish together.
    """
    import skyverse as sky

    if (seen.pattern in ("facade", "viewpoints", "orbit")) == bool(files):
        expected = "--buildings and --structure, without a file of an area" if files else "a file of an area or a line"
        raise InputError(f"--pattern {seen.pattern}: expected {expected}, found {'one' if files else 'none'}")
    before_compiling(partial(compile_with_bar, ["mission", "survey", "Cheapest"]))
    source = files[0] if files else "survey"
    if written.output is not None:
        refuse_output(written.output, *files, *map_files(given))
    form, places = "latitude,longitude, as in 46.81,9.85", list[tuple[float, float]]()
    for text in asked.launch or ():
        found = points_of("--launch", text, "0 m agl")
        places += [numbers_of("--launch", form, text, 2)] if found is None else [one[:2] for one in found.values()]
    notes: list[Note] = []
    with watched(notes) as on_note:
        options = replace(
            build_options(Path(written.output or source).stem, _USUAL | given, on_note), battery=asked.battery
        )
        scenario = sky.build_survey(files, options, uavs=asked.drones, launch=places, **fields_of(asked, seen))
        scenario = wind.of(scenario)
    say(*dict.fromkeys(map(told, filter(must_be_heeded, notes))), aside=True)
    return plan_scenario(scenario, source, written, search, FleetOptions(criterion=criterion))


def fields_of(asked: AskedOptions, seen: SeenOptions) -> dict[str, Any]:
    """Return the fields of a `Survey` that options give."""
    data = {"gsd": asked.gsd} | vars(seen) | {"portrait": None, "structure": None, "structures": seen.structure}
    data["camera"] = _camera(asked.camera).model_copy(update={"portrait": seen.portrait})
    if asked.overlap is not None:
        data["overlap"] = numbers_of("--overlap", "per cent along and between strips, as in 80,70", asked.overlap, 2)
    return {name: value for name, value in data.items() if value is not None}


def _camera(given: str) -> "Camera":
    """Return the camera of a name or of its numbers, or of a file."""
    from skyverse.files.cameras import read_camera
    from skyverse.model.camera import camera_of

    if Path(given).suffix.lower() in (".yaml", ".yml", ".json"):
        return read_camera(Path(given))
    try:
        return camera_of(given)  # type: ignore[return-value]  # text gives a camera
    except ValueError as error:
        raise InputError(str(error), field="camera") from None
