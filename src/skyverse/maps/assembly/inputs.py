"""The files of buildings, zones and point clouds that a scenario is built of, their licences, and what is told."""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from skyverse.errors import InputError, Sentence
from skyverse.maps.assembly.options import BuildOptions, Note
from skyverse.maps.georeference.feature import ABOVE_PERMITTED, Feature, Fields, Rectangle
from skyverse.maps.georeference.reading import Choices, Reading
from skyverse.maps.readers.aerial_point_cloud import WHY_LEFT_OUT, AerialCloud, aerial_cloud, aerial_voxels
from skyverse.model.caution import Caution
from skyverse.model.frame import Origin
from skyverse.model.scenario import Source
from skyverse.model.shapes import FENCE, Terrain, Voxels
from skyverse.model.short_lines import counted

MAX_SENTENCES = 5
"""Sentences told of one file at most."""


class FeatureFile(NamedTuple):
    """A file of buildings, zones, a fence or permitted heights, and which of these words tells what it gives."""

    path: str
    features: list[Feature]
    gives: str


def read_feature_files(options: BuildOptions) -> list[FeatureFile]:
    """Read the files of buildings, zones, soft zones, fences and permitted heights, in this order."""
    from skyverse.maps.readers import read_features

    reading = options.reading or Reading()
    asked: list[tuple[str, str | None, float | None]] = [(str(path), "building", None) for path in options.buildings]
    asked += [(str(path), None, None) for path in options.zones]
    asked += [(str(path), None, risk) for path, risk in options.soft_zones]
    asked += [(str(path), FENCE, None) for path in options.fences]
    asked += [(str(path), ABOVE_PERMITTED, None) for path in options.max_heights]
    gives = {None: "zones", "building": "buildings", FENCE: FENCE, ABOVE_PERMITTED: "permitted heights"}
    read, timed = [], False
    for path, kind, risk in asked:
        if risk is not None and not (math.isfinite(risk) and risk > 0):
            raise InputError(f"{path}: expected a risk above 0, found {risk:g}")
        with told_of(path, options.on_note) as tell:
            found = read_features(path, Choices(**vars(reading), kind=kind, risk=risk, tell=tell))
        timed |= any(feature.has_times for feature in found)
        found = [feature for feature in found if feature.active != ()]
        read.append(FeatureFile(path, found, gives[kind]))
    if reading.date is not None and not timed:
        told = "no file says when its zones are active in a way that is read, so that it changes nothing"
        options.on_note(Note("", Sentence(told, field="Reading.date"), heed=True))
    return read


def open_clouds(options: BuildOptions) -> list[AerialCloud]:
    """Read what the files of points say of where they lie."""
    clouds = []
    for path in options.voxels:
        with told_of(str(path), options.on_note) as tell:
            clouds.append(aerial_cloud(Path(path), Choices(**vars(options.reading or Reading()), tell=tell)))
    return clouds


@contextmanager
def told_of(path: str, on_note: Callable[[Note], object]) -> Iterator[Callable[[str], object]]:
    """Yield what takes sentences on a file, the first of which become notes at the end."""
    told: list[str] = []
    yield told.append
    for sentence in told[:MAX_SENTENCES]:
        on_note(Note(path, sentence.removeprefix(f"{path}: ")))
    if len(told) > MAX_SENTENCES:
        on_note(Note(path, f"and {len(told) - MAX_SENTENCES} more like these"))


def voxels_of(
    cloud: AerialCloud,
    zero: Origin,
    region: Rectangle,
    reach: float,
    relief: Terrain | None,
    options: BuildOptions,
) -> list[Voxels]:
    """Return the voxels of a point cloud, at most one grid, and tell how many points were left out, and why."""
    solid, counts = aerial_voxels(cloud, zero, region, reach, relief, options.voxel_size)
    if solid is None:
        options.on_note(Note(str(cloud.path), f"{Caution.WARNING}: nothing of it stands in the area"))
        return []
    left = "".join(f", {counts[what]:,} {what} left out" for what in WHY_LEFT_OUT if counts[what])
    columns = counted(counts["columns"], "column")
    made = (
        f"{counted(counts['kept'], 'point')}{left}; {columns} of voxels of {solid.step[0]:g} m, "
        "occupied from the highest point down, as what is below was not seen"
    )
    options.on_note(Note(str(cloud.path), made))
    return [solid]


OPEN_STREET_MAP = "© OpenStreetMap contributors, Open Database License (ODbL) 1.0"
_LICENCE_FIELDS = ("license", "licence", "copyright", "attribution")
_HOLDERS = ("metadata", "+metadata-extended")
"""Where documents hold such fields, besides their top."""


def licence_of(path: Path) -> str:
    """Return what a file of buildings or zones says of its licence, ``""`` where it says nothing."""
    suffix = path.suffix.lower()
    if suffix in (".osm", ".pbf"):
        return OPEN_STREET_MAP
    if suffix not in (".json", ".geojson"):
        return ""
    from skyverse.maps.readers import geojson  # it needs libraries that only readers of such files have

    try:
        document = geojson.load(path)
    except InputError:
        return ""
    holders = [document, *(document.get(name) for name in _HOLDERS)] if isinstance(document, dict) else []
    said = (Fields(holder).text(*_LICENCE_FIELDS) for holder in holders if isinstance(holder, dict))
    return next(filter(None, said), "")


def licensed(sources: list[tuple[Path, Source]], licences: Mapping[str, str]) -> list[Source]:
    """Return sources with the licences that the user gives by path, or by name where one file only has it."""
    paths = {path for path, _ in sources}
    said = {}
    for file, text in licences.items():
        meant = {path for path in paths if path == Path(file)} or {path for path in paths if path.name == str(file)}
        if len(meant) != 1:
            found = "several of that name" if meant else "another"
            raise InputError(f"{file}: expected one of the files given, found {found}", field="licences")
        said[meant.pop()] = text
    return [source.model_copy(update={"licence": said.get(path, source.licence)}) for path, source in sources]
