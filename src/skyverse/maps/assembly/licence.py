"""The licences under which files say that they may be used."""

from collections.abc import Mapping
from pathlib import Path

from skyverse.errors import InputError
from skyverse.maps.georeference.fields import Fields
from skyverse.model.scenario import Source

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
