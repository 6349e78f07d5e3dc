"""The licences under which files say that they may be used."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skyverse.errors import InputError
from skyverse.model.scenario import Source

OPEN_STREET_MAP = "© OpenStreetMap contributors, Open Database License (ODbL) 1.0"
_LICENCE_FIELDS = ("license", "licence", "copyright", "attribution")


def licence_of(path: Path) -> str:
    """Return what a file of buildings or zones says of its licence, ``""`` where it says nothing."""
    suffix = path.suffix.lower()
    if suffix in (".osm", ".pbf"):
        return OPEN_STREET_MAP
    if suffix not in (".json", ".geojson"):
        return ""
    try:
        document = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return ""
    return _licence_in(document) if isinstance(document, dict) else ""


def _licence_in(document: dict[str, Any]) -> str:
    metadata = document.get("metadata")
    extended = document.get("+metadata-extended")
    for held in (document, metadata, extended):
        if isinstance(held, dict):
            lower = {str(name).lower(): value for name, value in held.items()}
            for name in _LICENCE_FIELDS:
                if isinstance(lower.get(name), str) and lower[name].strip():
                    return " ".join(lower[name].split())[:200]
    return ""


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
