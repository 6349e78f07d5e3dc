"""Scenarios of surveys: maps, what is to be seen from files of areas and lines, and UAVs that start beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from skyverse.errors import InputError, Remedy, require_kind, require_row, require_whole
from skyverse.maps.assembly.build import build_scenario
from skyverse.maps.assembly.launch_places import with_launches
from skyverse.maps.assembly.options import BuildOptions, Note
from skyverse.maps.readers.areas import corners_of, joined, read_area, read_lines
from skyverse.maps.readers.polygons import Tell
from skyverse.model.frame import Origin
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey


def build_survey(
    files: Sequence[str | Path],
    options: BuildOptions,
    *,
    uavs: int = 1,
    launch: Sequence[tuple[float, float]] = (),
    **asked: Any,
) -> Scenario:
    """Build a scenario of maps, of what is to be photographed, and of UAVs that do it, for `plan_mission`.

    Parameters
    ----------
    files
        Of an area, all of whose polygons are one survey, or, with the pattern ``"corridor"``, of lines, each of which
        is one: KML, KMZ, GeoJSON, Shapefile, GeoPackage. None where structures are to be seen.
    options
        The maps, and what the UAVs are and can do; it has a `terrain`, or level `ground`.
    uavs
        How many UAVs there are.
    launch
        Latitude and longitude, degrees, where UAVs start and land, in their order. Others start beside the last of
        these, or, where there is none, beside what is to be seen, at the free place nearest to its middle.
    **asked
        What is asked for: fields of a `Survey`, such as `camera`, `gsd` and `overlap`, but `area` and `line`.

    Returns
    -------
    Scenario
        In the frame of the maps, whose UAVs end at home.

    Raises
    ------
    InputError
        If a file, a map or a field cannot be used, or there are not so many free places to start at.
    """
    for name, rows in (("files", files), ("launch", launch)):
        require_kind(rows, (list, tuple), name)
    require_kind(options, BuildOptions, "options")
    require_whole(uavs, "uavs", 1)
    for number, place in enumerate(launch):
        require_row(place, 2, f"launch[{number}]")
    if not options.terrain and options.ground is None:
        level = [Remedy("ground", None, "for level ground")]
        raise InputError("expected a file of ground heights, found none", field="terrain", give=level)
    crs = None if options.reading is None else options.reading.crs
    _surveys(files, crs, None, asked)  # what is wrong with them is told before maps are read
    options = replace(options, around=[*options.around, *files, *launch])
    world = build_scenario(options)

    def tell(said: str) -> None:
        options.on_note(Note("", said, heed=True))

    return with_launches(world, options, _surveys(files, crs, world.frame.origin, asked, tell), launch, uavs)


def _surveys(
    files: Sequence[str | Path],
    crs: str | None,
    origin: Origin | None,
    asked: Mapping[str, Any],
    tell: Tell = lambda said: None,
) -> list[Survey]:
    """Return the surveys of files, in a frame; without an origin, one about the first file itself."""
    if not files:
        return [Survey(**asked)]
    if origin is None:
        east, north = corners_of(files[0], crs)[0].tolist()
        origin = Origin(latitude=north, longitude=east, altitude=0.0)
    if asked.get("pattern") == "corridor":
        return [Survey(line=line, **asked) for file in files for line in read_lines(file, origin, crs=crs, tell=tell)]
    parts = (part for file in files for part in read_area(file, origin, crs=crs, tell=tell))
    return [Survey(area=joined(parts), **asked)]
