"""What was expected of a value that pydantic refuses, in the words of all other messages."""

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from skyverse.errors import did_you_mean, printable, shown

if TYPE_CHECKING:
    from pydantic import ValidationError

_EXPECTED = {
    "bool_type": "true or false",
    "dict_type": "a mapping of keys to values",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "greater_than": "a number above {gt:.12g}",
    "greater_than_equal": "{ge:.12g} or more",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "less_than": "a number below {lt:.12g}",
    "less_than_equal": "at most {le:.12g}",
    "list_type": "a list",
    "literal_error": "{expected}",
    "model_attributes_type": "a mapping of keys to values",
    "model_type": "a mapping of keys to values",
    "dataclass_type": "a mapping of keys to values",
    "dataclass_exact_type": "a mapping of keys to values",
    "string_too_short": "a text that is not empty",
    "string_type": "a text",
    "too_long": "{max_length} values at most",
    "too_short": "{min_length} values or more",
    "tuple_type": "a list",
    "union_tag_invalid": "one of {expected_tags}",
}
"""What is expected, by the type of pydantic's error."""

_UNKNOWN_KEY_ERRORS = ("extra_forbidden", "unexpected_keyword_argument")
"""How pydantic calls an unknown key in a model and in a dataclass."""
_FIELDS_BY_UNIT = {
    "metres": (
        "altitude centre clearance geoid high home horizontal look_at low max max_height min points position radius "
        "separation start step turn_radius vertical vertical_separation"
    ),
    "seconds": "active knots period since swap times",
    "m/s": "growth gust max_airspeed max_climb max_descent max_speed max_wind speed top_speed velocity",
    "m/s^2": "acceleration max_acceleration",
    "m/s^3": "max_jerk",
    "degrees": "angle bearing climb heading latitude longitude max_tilt",
    "degrees/s": "max_yaw_rate",
    "degrees/s^2": "max_yaw_acceleration",
    "watts": "hover_power",
    "watt-hours": "battery",
    "kilograms": "mass payload",
}
_UNITS = {field: unit for unit, fields in _FIELDS_BY_UNIT.items() for field in fields.split()}
"""The unit of a field that holds numbers."""


def complaint(error: Mapping[str, Any]) -> str:
    """Return what is wrong with a value, without its place: what was expected, or what a validator says, and found.

    Parameters
    ----------
    error
        One of the errors that pydantic's `ValidationError.errors` lists.
    """
    given = error["ctx"]["tag"] if error["type"] == "union_tag_invalid" else error["input"]
    whole = isinstance(given, dict) and error["type"] in ("missing", "value_error")  # says nothing of what is wrong
    found = "" if whole else f", found {shown(given, 60)}"
    expected = _EXPECTED.get(error["type"])
    if expected is not None:
        unit = _unit_of(error["loc"]) if expected == "a number" else None
        return f"expected {expected.format(**error.get('ctx', {}))}{f' of {unit}' if unit else ''}{found}"
    said: str = error["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ").rstrip(".")
    said = said.replace("Input should be", "expected", 1)
    return (said[:1].lower() + said[1:] if said[1:2].islower() else said) + found


def _unit_of(loc: Sequence[int | str]) -> str | None:
    """Return the unit of the field at a place of pydantic's, where it is known; validators there do not count."""
    names = [part for part in loc if isinstance(part, str) and part.isidentifier()]
    return _UNITS.get(names[-1]) if names else None


def wrong_field(error: "ValidationError", data: Any, known: set[str]) -> tuple[str, str]:
    """Return the field that pydantic found wrong, empty if it is all of the data, and in a sentence what is wrong.

    Parameters
    ----------
    error
        What pydantic found.
    data
        The data that were read.
    known
        Keys that an unknown key may be a misspelling of.
    """
    # where a key is misspelt, the right one is missing, too: the misspelt one is the cause
    wrong = [one for one in error.errors(include_url=False) if one["type"] != "default_factory_not_called"]
    first = min(wrong, key=lambda found: found["type"] not in _UNKNOWN_KEY_ERRORS)
    place, kind = _place(first["loc"], data, missing=first["type"] == "missing")
    near = ""
    if first["type"] == "union_tag_invalid":
        place += f".{_name_of_type(first['loc'])}"
        near = did_you_mean(first["ctx"]["tag"], re.findall(r"'([^']+)'", first["ctx"]["expected_tags"]))
    if first["type"] in _UNKNOWN_KEY_ERRORS:
        key = str(first["loc"][-1])
        if kind is not None and key in known:
            name = _name_of_type(first["loc"][:-2])
            said = f"the {name} {kind!r} has no such key; the key {name!r} says which {name} it is"
            return place, said
        return place, f"there is no such key{did_you_mean(key, known)}"
    if first["type"] == "missing":
        return place, "is missing"
    said = re.sub(r"\S{80,}", lambda word: f"{word[0][:60]}...", complaint(first))
    more = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
    return place, f"{said}{near}{more}"


def _name_of_type(loc: tuple[int | str, ...]) -> str:
    """Return the key that says of which type the data at a place are."""
    return "motion" if loc[-1] == "motion" else "shape"


def _place(loc: tuple[int | str, ...], data: Any, missing: bool) -> tuple[str, str | None]:
    """Return where in a file's data a place of pydantic's is, and the type that pydantic names just before its end.

    On the way, pydantic names types, validators, and the first entry of a list where the file has that entry alone.
    These do not stand in the file, and are left out; a key that is missing stands at the end.
    """
    place, kind = "", None
    for k, part in enumerate(loc):
        last = k == len(loc) - 1
        if isinstance(part, int):
            if not isinstance(data, dict | str | float | int):
                place += f"[{part}]"
                data = data[part] if isinstance(data, list | tuple) and part < len(data) else None
        elif _stands_in(data, part) or (missing and last):
            place += f".{printable(part, 60)}" if place else printable(part, 60)
            data = data.get(part) if isinstance(data, dict) else None
        elif k == len(loc) - 2:
            kind = part
    return place, kind


def _stands_in(data: Any, part: str) -> bool:
    """Tell whether a key stands in data; of other data than mappings, whether it is a key at all."""
    return part in data if isinstance(data, dict) else not part.startswith(("function-", "tuple[", "literal["))


def keys_of_schema(schema: Any) -> set[str]:
    """Return all keys that a JSON Schema knows."""
    keys: set[str] = set()
    if isinstance(schema, dict):
        keys.update(schema.get("properties", {}))
        for value in schema.values():
            keys |= keys_of_schema(value)
    return keys
