"""What was expected of a value that pydantic refuses, in the words of all other messages."""

from collections.abc import Mapping
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


def complaint(error: Mapping[str, Any]) -> str:
    """Return what is wrong with a value, without its place: what was expected, or what a validator of ours says.

    Parameters
    ----------
    error
        One of the errors that pydantic's `ValidationError.errors` lists.
    """
    expected = _EXPECTED.get(error["type"])
    if expected is not None:
        return f"expected {expected.format(**error.get('ctx', {}))}"
    said: str = error["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ").rstrip(".")
    said = said.replace("Input should be", "expected", 1)
    return said[:1].lower() + said[1:] if said[1:2].islower() else said
