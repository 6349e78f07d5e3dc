"""Flight files: one self-contained JSON, the mission that was flown in it."""

from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError

from skyverse.errors import InputError
from skyverse.files.document import explain
from skyverse.flown import Flight

FORMAT = "skyverse/flight/1"


@cache
def _codec() -> TypeAdapter[Flight]:
    return TypeAdapter(Flight)


def flight_from_data(source: object, data: Any) -> Flight:
    """Validate a flight file's data, or raise `InputError` naming file and field."""
    if data["format"] != FORMAT:
        raise InputError(f"{source}: format: expected {FORMAT!r}, found {data['format']!r:.60}")
    try:
        return _codec().validate_python(data)
    except ValidationError as error:
        raise explain(source, error, set()) from None


def flight_text(flight: Flight) -> str:
    """Return a flight as the text of its JSON file."""
    return _codec().dump_json(flight, indent=1).decode() + "\n"
