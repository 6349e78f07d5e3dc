"""The verb that makes a scenario of the user's own maps."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Group, Parameter

from skyverse.cli.report import json_text
from skyverse.cli.words import origin_of, refuse_output
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.maps.assembly.build import Note
    from skyverse.maps.assembly.places import Place
    from skyverse.model.scenario import Scenario

app = App(name="scenario", help="Make scenarios of maps.")

what = Group("What to read", sort_key=1)
terrain_files = Group("How terrain files are to be read, where they do not say", sort_key=3)
other_files = Group("How files of buildings and zones are to be read, where they do not say", sort_key=4)
room = Group("What part of the world, and how", sort_key=2)
Files = Annotated[list[Path] | None, Parameter(group=what, consume_multiple=True)]
FileWords = Annotated[list[str] | None, Parameter(group=what, consume_multiple=True)]
Places = Annotated[list[str] | None, Parameter(group=what, allow_leading_hyphen=True)]
Metres = Annotated[float | None, Parameter(group=room)]


@app.command
def build(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    name: str | None = None,
    terrain: Files = None,
    buildings: Files = None,
    zones: Files = None,
    soft_zones: FileWords = None,
    voxels: Files = None,
    uav: Places = None,
    target: Places = None,
    licence: FileWords = None,
    area: Annotated[str | None, Parameter(group=room, allow_leading_hyphen=True)] = None,
    margin: Metres = None,
    origin: Annotated[str | None, Parameter(group=room, allow_leading_hyphen=True)] = None,
    geoid: Annotated[float | None, Parameter(group=room)] = None,
    ground: Annotated[str | None, Parameter(group=room, allow_leading_hyphen=True)] = None,
    ceiling: Annotated[str | None, Parameter(group=room)] = None,
    clearance: Annotated[float, Parameter(group=room)] = 2.0,
    ground_clearance: Metres = None,
    band: Annotated[str | None, Parameter(group=room)] = None,
    band_weight: Annotated[float, Parameter(group=room)] = 0.1,
    lattice_step: Metres = None,
    terrain_step: Metres = None,
    voxel_size: Metres = None,
    tolerance: Annotated[float, Parameter(group=room)] = 0.5,
    fill_nodata: Annotated[str | None, Parameter(group=room, allow_leading_hyphen=True)] = None,
    terrain_crs: Annotated[str | None, Parameter(group=terrain_files)] = None,
    terrain_band: Annotated[int | None, Parameter(group=terrain_files)] = None,
    terrain_unit: Annotated[Literal["m", "ft", "us-ft"] | None, Parameter(group=terrain_files)] = None,
    nodata: Annotated[float | None, Parameter(group=terrain_files, allow_leading_hyphen=True)] = None,
    altitudes: Annotated[Literal["agl", "amsl"] | None, Parameter(group=other_files)] = None,
    unit: Annotated[Literal["m", "ft"] | None, Parameter(group=other_files)] = None,
    building_height: Annotated[float | None, Parameter(group=other_files)] = None,
    height_field: Annotated[str | None, Parameter(group=other_files)] = None,
    buffer: Annotated[float | None, Parameter(group=other_files)] = None,
    crs: Annotated[str | None, Parameter(group=other_files)] = None,
    lod: Annotated[str | None, Parameter(group=other_files)] = None,
    as_json: Annotated[bool, Parameter(name="--json", negative="")] = False,
) -> None:
    """Make a scenario of terrain, buildings and no-fly zones: crop, bring to local metres, simplify, write.

    Altitudes say what they are counted from: `60 m agl` (the ground), `1250 m amsl` (mean sea level), `0 m home`
    (the ground below a UAV's start). Places are latitude,longitude in WGS84 degrees.

    Examples: `skyverse scenario build --terrain davosdorf.tif --uav "46.81,9.85,60 m agl" --target
    "46.806,9.845,60 m agl" -o davos.yaml`, `skyverse scenario build --buildings delft.city.json -o delft.yaml`,
    `skyverse scenario build --terrain dem.tif --zones zones.geojson --area 9.84,46.79,9.87,46.81 --ceiling "120 m agl"
    -o valley.yaml`

    Parameters
    ----------
    output
        The scenario file, .yaml or .json; large grids are put beside it.
    name
        The scenario's; the file's by default.
    terrain
        A raster of ground heights: GeoTIFF, ASCII grid, .hgt and others; or several.
    buildings
        A file of buildings: CityJSON, OpenStreetMap, GeoJSON, KML, Shapefile, GeoPackage; or several.
    zones
        A file of zones that must not be entered; or several.
    soft_zones
        FILE=RISK: zones that may be flown through, and the risk of a metre inside, unless a field `risk` says it;
        or several.
    voxels
        A point cloud, .las or .laz, taken from the air: it and all below is occupied; or several.
    uav
        Where a UAV starts: latitude,longitude,altitude, with a name as in `alpha=46.81,9.85,60 m agl`; repeat
        --uav for more.
    target
        Where one must get to, alike.
    licence
        FILE=TEXT: a file's licence, kept in the scenario, where the file does not say; or several.
    area
        west,south,east,north in degrees; what lies outside is dropped.
    margin
        Without an area: what is kept around UAVs and targets, metres; 250 when left out.
    origin
        latitude,longitude,altitude (amsl) of the frame's zero; the middle at its lowest ground when left out.
    geoid
        How far mean sea level lies above the WGS84 ellipsoid, metres; some exports need it.
    ground
        Without a terrain: level ground at this altitude, as in `0 m amsl`.
    ceiling
        How high the bounds reach. `120 m agl` is above the highest ground, and more than that above all other ground,
        where --band is what keeps UAVs low; 30 m above all that is there when left out.
    clearance
        From obstacles, metres.
    ground_clearance
        Above ground, metres; the clearance when left out.
    band
        low,high: metres above ground to keep to, if it pays.
    band_weight
        The price of a metre flown a metre outside the band.
    lattice_step
        Of lattice planners, metres; chosen for at most two million nodes when left out.
    terrain_step
        Between ground heights, metres; about that of the finest file when left out.
    voxel_size
        Of point clouds, metres; at least 2 when left out, and longer than gaps between points.
    tolerance
        By how much outlines may grow to lose corners, metres; 0 for as they are.
    fill_nodata
        METRES (amsl) or nearest: what stands for the ground where files have none.
    terrain_crs
        Coordinates, as in EPSG:4326.
    terrain_band
        Which band holds the heights, from 1 on.
    terrain_unit
        Of the heights.
    nodata
        The number that stands for no data; nan where none does, and every number is a height.
    altitudes
        What bare altitudes are counted from.
    unit
        Of limits of zones without one; metres when left out.
    building_height
        Of buildings that no height is given of, metres.
    height_field
        The field that holds the height above ground.
    buffer
        How far around lines and points is forbidden, metres.
    crs
        Coordinates, as in EPSG:2056.
    lod
        The level of detail taken from CityJSON; the highest when left out.
    as_json
        Print what was done as JSON.
    """
    from skyverse.files import write
    from skyverse.maps.assembly.build import build_scenario
    from skyverse.maps.georeference.choices import Reading
    from skyverse.maps.readers.raster import Raster

    if output.suffix.lower() not in (".yaml", ".yml", ".json"):
        raise InputError(f"--output: expected a file ending in .yaml, .yml or .json, found {str(output)!r}")
    risky = [_pair("--soft-zones", word, float) for word in soft_zones or ()]
    refuse_output(output, *(terrain or ()), *(buildings or ()), *(zones or ()), *(voxels or ()), *(f for f, _ in risky))
    notes: list[Note] = []
    with _watched(notes) as on_note:
        made = build_scenario(
            name or output.stem,
            terrain=[Raster(path, terrain_crs, terrain_band, terrain_unit, nodata) for path in terrain or ()],
            buildings=buildings or (),
            zones=zones or (),
            soft_zones=risky,
            voxels=voxels or (),
            uavs=_places("--uav", "uav", uav or []),
            targets=_places("--target", "target", target or []),
            origin=None if origin is None else origin_of(origin),
            area=None if area is None else _numbers("--area", "west,south,east,north in degrees", area, 4),
            margin=margin,
            ceiling=None if ceiling is None else _altitude("--ceiling", ceiling),
            ground=_sea("--ground", ground),
            clearance=clearance,
            ground_clearance=ground_clearance,
            lattice_step=lattice_step,
            terrain_step=terrain_step,
            voxel_size=voxel_size,
            fill_nodata=_fill(fill_nodata),
            band=None if band is None else _numbers("--band", "low,high in metres above ground", band, 2),
            band_weight=band_weight,
            tolerance=tolerance,
            reading=Reading(altitudes, unit, building_height, height_field, buffer, crs, lod),
            licences=dict(_pair("--licence", word, str) for word in licence or ()),
            geoid=geoid,
            on_note=on_note,
        )
        write(made, output)
    _report(made, notes, output, as_json)


def _pair(option: str, word: str, kind: Callable[[str], Any]) -> tuple[str, Any]:
    file, equals, text = word.rpartition("=") if kind is float else word.partition("=")
    if not (file and equals and text):
        expected = "FILE=RISK, as in zones.geojson=0.5" if kind is float else "FILE=TEXT"
        raise InputError(f"{option}: expected {expected}, found {word!r}")
    try:
        return file, kind(text)
    except ValueError:
        raise InputError(f"{option}: expected a number after {file}=, found {text!r}") from None


def _numbers(option: str, expected: str, text: str, count: int) -> Any:
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != count:
        raise InputError(f"{option}: expected {expected}, found {text!r}")
    return numbers


def _altitude(option: str, text: str) -> Any:
    from skyverse.model.altitude import parse_altitude

    try:
        return parse_altitude(text)
    except ValueError as error:
        raise InputError(f"{option}: {error}") from None


def _sea(option: str, text: str | None) -> Any:
    from skyverse.model.altitude import AboveSea

    if text is None:
        return None
    altitude = _altitude(option, text)
    if not isinstance(altitude, AboveSea):
        raise InputError(f"{option}: expected an altitude above mean sea level, as in '12 m amsl', found {text!r}")
    return altitude


def _place(option: str, text: str) -> "Place":
    words = text.split(",", 2)
    try:
        latitude, longitude = float(words[0]), float(words[1])
    except (ValueError, IndexError):
        words = []
    if len(words) != 3:
        raise InputError(f"{option}: expected latitude,longitude,altitude, as in '46.81,9.85,60 m agl', found {text!r}")
    return latitude, longitude, _altitude(f"{option} {text}", words[2])


def _places(option: str, kind: str, texts: list[str]) -> "dict[str, Place]":
    places: dict[str, Place] = {}
    for number, text in enumerate(texts, 1):
        name, equals, rest = text.partition("=")
        key = name.strip() if equals else f"{kind}-{number}"
        if key in places:
            raise InputError(f"{option}: expected names that differ, found {key!r} twice")
        places[key] = _place(option, rest if equals else text)
    return places


def _fill(text: str | None) -> Any:
    if text is None or text == "nearest":
        return text
    try:
        return float(text)
    except ValueError:
        raise InputError(f"--fill-nodata: expected metres above sea level, or nearest, found {text!r}") from None


@contextmanager
def _watched(notes: "list[Note]") -> "Iterator[Callable[[Note], None]]":
    """Yield what keeps the notes, and shows the last while it works, when a person watches."""
    if not sys.stderr.isatty():
        yield notes.append
        return
    from rich.console import Console

    with Console(stderr=True).status("reading maps") as status:

        def keep(note: "Note") -> None:
            notes.append(note)
            status.update(f"{Path(note.file).name} {note.text}"[:100])

        yield keep


def _report(scenario: "Scenario", notes: "list[Note]", output: Path, as_json: bool) -> None:
    low, high = scenario.bounds.min, scenario.bounds.max
    origin = scenario.frame.origin
    assert origin is not None
    nodes = 1
    for a, b, step in zip(low, high, scenario.lattice.step, strict=True):
        nodes *= int((b - a) / step + 1e-9) + 1
    if as_json:
        summary = {
            "file": str(output),
            "done": [{"file": note.file, "text": note.text} for note in notes],
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
    for note in notes:
        print(f"{Path(note.file).name}: {note.text}" if note.file else note.text)
    for source in scenario.sources:
        licence = source.licence or "licence unknown; say it with --licence FILE=TEXT"
        print(f"{source.file}: {source.gives}{f', {source.crs}' if source.crs else ''}; {licence}")
    print(
        f"{high[0] - low[0]:g} m by {high[1] - low[1]:g} m by {high[2] - low[2]:g} m around "
        f"{origin.latitude:g}, {origin.longitude:g}, zero at {origin.altitude:g} m amsl; "
        f"{len(scenario.obstacles):,} obstacles, {len(scenario.zones):,} zones, {len(scenario.uavs)} UAVs, "
        f"{len(scenario.targets)} targets; lattice of {nodes:,} nodes, {scenario.lattice.step[0]:g} m apart"
    )
    print(output)
