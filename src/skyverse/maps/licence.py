"""Under which licence a file says that it may be used."""

import json
from pathlib import Path
from typing import Any

OPEN_STREET_MAP = "© OpenStreetMap contributors, Open Database License (ODbL) 1.0"
_FIELDS = ("license", "licence", "copyright", "attribution")


def licence_of(path: Path) -> str:
    """Return what a file of buildings or zones says of its licence; nothing where it says nothing."""
    suffix = path.suffix.lower()
    if suffix in (".osm", ".pbf"):
        return OPEN_STREET_MAP
    if suffix not in (".json", ".geojson"):
        return ""
    try:
        document = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return ""
    return _said(document) if isinstance(document, dict) else ""


def _said(document: dict[str, Any]) -> str:
    metadata = document.get("metadata")
    extended = document.get("+metadata-extended")
    for held in (document, metadata, extended):
        if isinstance(held, dict):
            lower = {str(name).lower(): value for name, value in held.items()}
            for name in _FIELDS:
                if isinstance(lower.get(name), str) and lower[name].strip():
                    return " ".join(lower[name].split())[:200]
    return ""
