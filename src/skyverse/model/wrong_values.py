"""What was expected of a value that pydantic refuses, in the words of all other messages."""

from collections.abc import Mapping, Sequence
from typing import Any

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

_FIELDS_BY_UNIT = {
    "metres": (
        "altitude centre clearance geoid high home horizontal look_at low max max_height min points position radius "
        "separation start step turn_radius vertical vertical_separation"
    ),
    "seconds": "active knots period since times",
    "m/s": "growth max_climb max_descent max_speed speed top_speed",
    "m/s^2": "acceleration max_acceleration",
    "m/s^3": "max_jerk",
    "degrees": "angle bearing climb latitude longitude max_tilt",
    "degrees/s": "max_yaw_rate",
    "degrees/s^2": "max_yaw_acceleration",
    "watts": "hover_power",
}
_UNITS = {field: unit for unit, fields in _FIELDS_BY_UNIT.items() for field in fields.split()}
"""The unit of a field that holds numbers."""


def complaint(error: Mapping[str, Any]) -> str:
    """Return what is wrong with a value, without its place: what was expected, or what a validator of ours says.

    Parameters
    ----------
    error
        One of the errors that pydantic's `ValidationError.errors` lists.
    """
    expected = _EXPECTED.get(error["type"])
    if expected is not None:
        unit = _unit_of(error["loc"]) if expected == "a number" else None
        return f"expected {expected.format(**error.get('ctx', {}))}{f' of {unit}' if unit else ''}"
    said: str = error["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ").rstrip(".")
    said = said.replace("Input should be", "expected", 1)
    return said[:1].lower() + said[1:] if said[1:2].islower() else said


def _unit_of(loc: Sequence[int | str]) -> str | None:
    """Return the unit of the field at a place of pydantic's, where it is known; validators there do not count."""
    names = [part for part in loc if isinstance(part, str) and part.isidentifier()]
    return _UNITS.get(names[-1]) if names else None
