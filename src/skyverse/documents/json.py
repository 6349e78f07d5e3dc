"""JSON texts become data; how deep and how large a text is nested is counted before it is built."""

import json
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from skyverse.documents.limits import MAX_DIGITS, require_depth, require_digits, require_values
from skyverse.errors import shown

_STRING = re.compile(r'"(?:[^"\\]|\\.)*+"', re.DOTALL)
_LONG_NUMBER = re.compile(rf"\d{{{MAX_DIGITS + 1},}}")
_STEPS = np.zeros(256, np.int8)
_STEPS[[ord("["), ord("{")]] = 1
_STEPS[[ord("]"), ord("}")]] = -1

Pairs = list[tuple[str, Any]]


def load_json(
    text: str,
    *,
    objects: Callable[[Pairs], dict[str, Any]] | None = None,
    constants: Callable[[str], Any] | None = None,
) -> Any:
    """Return the data of a JSON text.

    Parameters
    ----------
    text
        The text.
    objects
        Makes an object of its keys and values; by default a key that stands twice is refused.
    constants
        Makes a value of ``NaN``, ``Infinity`` or ``-Infinity``; floats by default.

    Raises
    ------
    LimitError
        If the text holds too many values, nests them too deeply, or holds a number of too many digits.
    json.JSONDecodeError
        If it is not JSON.
    ValueError
        If a key stands twice in an object.
    """
    codes = np.frombuffer(_STRING.sub("", text).encode("utf-8", "replace"), np.uint8)
    steps = _STEPS[codes]
    brackets = steps[steps != 0]
    require_values(int(np.count_nonzero(codes == ord(","))) + len(brackets))
    require_depth(int(np.cumsum(brackets, dtype=np.int64).max(initial=0)))
    try:
        return json.loads(text, object_pairs_hook=objects or unique_keys, parse_constant=constants)
    except json.JSONDecodeError:
        raise
    except ValueError:  # Python refuses whole numbers of thousands of digits
        require_digits(max(map(len, _LONG_NUMBER.findall(text)), default=0))
        raise


def unique_keys(pairs: Pairs) -> dict[str, Any]:
    """Return an object's keys and values, or raise `ValueError` if a key stands twice."""
    data = dict(pairs)
    if len(data) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"the key {shown(twice)} stands twice in one object")
    return data
