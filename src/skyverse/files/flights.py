"""Flight files: one self-contained JSON, the mission that was flown in it."""

from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from skyverse.errors import InputError
from skyverse.files.document import explain
from skyverse.files.grids import Side, grids_of
from skyverse.model.flight_record import Flight

FORMAT = "skyverse/flight/1"


@cache
def _codec() -> TypeAdapter[Flight]:
    return TypeAdapter(Flight)


def flight_from_data(source: str | Path, data: Any) -> Flight:
    """Validate a flight file's data, or raise `InputError` naming file and field."""
    if data["format"] != FORMAT:
        raise InputError(f"{source}: format: expected {FORMAT!r}, found {data['format']!r:.60}")
    try:
        return _codec().validate_python(data, context={"grids": grids_of(Path(source))})
    except ValidationError as error:
        raise explain(source, error, set()) from None


def flight_text(flight: Flight, side: Side | None = None) -> str:
    """Return a flight as the text of its JSON file; its scenario's large arrays go to `side` if there is one."""
    return _codec().dump_json(flight, indent=1, context={"side": side}).decode() + "\n"
