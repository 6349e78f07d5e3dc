"""The verb ``survey``: from the file of an area to a mission of photos that are proven to show it."""

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skyverse.cli.map_options import MAPS, build_options, map_files, must_be_heeded, taking, told, watched
from skyverse.cli.option_types import FLAG, SIGNED, WHOLE, GivenMission
from skyverse.cli.outputs import refuse_output
from skyverse.cli.places import numbers_of
from skyverse.cli.plan import BudgetOptions, FleetOptions, MissionOutput, PlannerOptions, WindOptions, plan_scenario
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.maps.assembly.options import BuildOptions, Note
    from skyverse.model.camera import Camera
    from skyverse.model.frame import Origin
    from skyverse.model.survey import Survey

_USUAL = {"vehicle": "camera", "max_height": "120 m agl"}
"""Options of maps and vehicles that surveys have where none are given."""


@Parameter(name="*", group=Group("What is to be seen, and how"))
@dataclass(frozen=True, kw_only=True)
class SeenOptions:
    """What a camera is to see.

    Parameters
    ----------
    camera
        The camera: a name such as mavic-3e, or a .yaml or .json file of its sensor, image, focal and min_interval.
    gsd
        The ground sample distance at most, as in "2 cm".
    height
        Metres from the camera to what it sees, instead.
    gsd_of
        Where the ground sample distance is kept: all over each photo, or in the photos nearest to each place.
    overlap
        Per cent that photos share along strips, and between strips, as in 80,70.
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

    camera: str
    gsd: str | None = None
    height: float | None = None
    gsd_of: Literal["photo", "place"] | None = None
    overlap: str | None = None
    pattern: Literal["strips", "cross", "oblique", "corridor", "facade", "viewpoints", "orbit"] = "strips"
    direction: float | None = None
    gimbal: Annotated[float | None, SIGNED] = None
    trigger: Literal["distance", "time", "point"] | None = None
    margin: float | None = None
    portrait: Annotated[bool, FLAG] = False
    width: float | None = None
    structure: list[str] | None = None


@Parameter(name="*", group=Group("Who flies it"))
@dataclass(frozen=True, kw_only=True)
class CrewOptions:
    """The UAVs of a survey.

    Parameters
    ----------
    drones
        How many UAVs fly it, at the same time.
    battery
        What one battery gives: minutes of hovering from full to empty, as in "20 min", or "77 Wh"; the vehicle's own
        when left out.
    launch
        Where UAVs start and land, as in 46.81,9.85; repeat for more. Others start beside it, or, where none is given,
        beside the area, nearest to its middle.
    """

    drones: Annotated[int, WHOLE] = 1
    battery: str | None = None
    launch: Annotated[list[str] | None, SIGNED] = None


_CREW, _SEARCH, _WIND, _WRITTEN = CrewOptions(), PlannerOptions(), WindOptions(), MissionOutput()


@taking(MAPS, ("uav", "target", "around", "margin", "battery", "licence", "band", "band_weight"))
def survey(
    *files: GivenMission,
    seen: SeenOptions,
    crew: CrewOptions = _CREW,
    criterion: Literal["min-sum", "min-max"] = "min-max",
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
    from skyverse.maps.assembly.build import build_scenario
    from skyverse.maps.assembly.launch_places import with_launches

    if (seen.pattern in ("facade", "viewpoints", "orbit")) == bool(files):
        expected = "--buildings and --structure, without a file of an area" if files else "a file of an area or a line"
        raise InputError(f"--pattern {seen.pattern}: expected {expected}, found {'one' if files else 'none'}")
    if not given.get("terrain") and "ground" not in given:
        raise InputError(
            "--terrain: expected a file of ground heights, or --ground '0 m amsl' for level ground, found none"
        )
    source = files[0] if files else "survey"
    if written.output is not None:
        refuse_output(written.output, *files, *map_files(given))
    places = [numbers_of("--launch", "latitude,longitude, as in 46.81,9.85", text, 2) for text in crew.launch or ()]
    surveys_of(files, seen, given.get("crs"))  # what is wrong with them is told before maps are read
    notes: list[Note] = []
    with watched(notes) as on_note:
        options = build_options(Path(written.output or source).stem, _USUAL | given, on_note)
        options = replace(options, around=[*files, *places], battery=energy_of(crew.battery, options))
        world = build_scenario(options)
        surveys = surveys_of(files, seen, given.get("crs"), world.frame.origin)
        asked = wind.of(with_launches(world, options, surveys, places, crew.drones))
    for said in dict.fromkeys(map(told, filter(must_be_heeded, notes))):
        print(said, file=sys.stderr)
    return plan_scenario(asked, source, (search, BudgetOptions(), FleetOptions(criterion=criterion)), written)


def surveys_of(
    files: Sequence[str], seen: SeenOptions, crs: str | None, origin: "Origin | None" = None
) -> "list[Survey]":
    """Return the surveys that options ask for, in a frame; without an origin, one about the file itself."""
    from skyverse.maps.readers.areas import corners_of, joined, read_area, read_lines
    from skyverse.model.frame import Origin
    from skyverse.model.survey import Survey

    own = {name: value for name, value in vars(seen).items() if value is not None}
    data = {name: value for name, value in own.items() if name not in ("camera", "portrait", "structure")}
    data["camera"] = _camera(seen.camera).model_copy(update={"portrait": seen.portrait})
    if seen.overlap is not None:
        data["overlap"] = numbers_of("--overlap", "per cent along and between strips, as in 80,70", seen.overlap, 2)
    if not files:
        return [Survey(structures=seen.structure or (), **data)]
    if origin is None:
        east, north = corners_of(files[0], crs)[0].tolist()
        origin = Origin(latitude=north, longitude=east, altitude=0.0)
    if seen.pattern == "corridor":
        return [Survey(line=line, **data) for file in files for line in read_lines(file, origin, crs=crs)]
    return [Survey(area=joined(part for file in files for part in read_area(file, origin, crs=crs)), **data)]


def _camera(given: str) -> "Camera":
    """Return the camera of a name, or of a file."""
    from skyverse.files.cameras import read_camera
    from skyverse.model.camera import camera_of

    if Path(given).suffix.lower() in (".yaml", ".yml", ".json"):
        return read_camera(Path(given))
    try:
        return camera_of(given)  # type: ignore[return-value]  # a name gives a camera
    except ValueError as error:
        raise InputError(str(error), field="camera") from None


def energy_of(text: str | None, options: "BuildOptions") -> float | None:
    """Read what one battery gives, Wh: minutes that the vehicle hovers, or an aeroplane flies, or watt-hours."""
    import numpy as np

    from skyverse.maps.assembly.build import outdoor_limits
    from skyverse.model.uav import UAV, with_limits

    match = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*(min|Wh)\s*", text or "")
    if text is None:
        return None
    if match is None or not float(match[1]) > 0:
        expected = "minutes of hovering or watt-hours, as in '20 min' or '77 Wh'"
        raise InputError(f"--battery: expected {expected}, found {text!r}")
    if match[2] == "Wh":
        return float(match[1])
    uav = with_limits(UAV(start=(0.0, 0.0, 0.0)), outdoor_limits(options))
    power = uav.power_model
    if power is None:
        raise InputError(f"--battery: {text}: the power of the vehicle is not known; give --vehicle camera, or '77 Wh'")
    flown = np.array([0.0 if uav.fixed_wing is None else uav.fixed_wing.speed])
    return float(power.at(flown, np.zeros(1), np.ones(1))[0]) * float(match[1]) / 60.0
