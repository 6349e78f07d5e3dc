"""Flight files: one self-contained JSON, which holds the mission that was flown."""

from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from skyverse.files.document import validated
from skyverse.files.grid_archive import GridArchive
from skyverse.model.flight_record import Flight

FLIGHT_FORMAT = "skyverse/flight/1"


@cache
def _codec() -> TypeAdapter[Flight]:
    return TypeAdapter(Flight)


def flight_from_data(source: str | Path, data: Any) -> Flight:
    """Return the flight that a file's data describe, or raise `InputError` that names file and field."""
    return validated(_codec(), FLIGHT_FORMAT, source, data)


def flight_text(flight: Flight, archive: GridArchive | None = None) -> str:
    """Return a flight as the text of its JSON file; large arrays of its scenario go to the archive if there is one."""
    return _codec().dump_json(flight, indent=1, context={"side": archive}).decode() + "\n"
