"""JSON texts become data; how deep and how large a text is nested is counted before it is built."""

import json
import re
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from skyverse.documents.limits import MAX_DIGITS, require_depth, require_digits, require_values
from skyverse.errors import InputError, printable, shown

_STRING = re.compile(r'"(?:[^"\\]|\\.)*+"', re.DOTALL)
_LONG_NUMBER = re.compile(rf"\d{{{MAX_DIGITS + 1},}}")
_STEPS = np.zeros(256, np.int8)
_STEPS[[ord("["), ord("{")]] = 1
_STEPS[[ord("]"), ord("}")]] = -1

Pairs = list[tuple[str, Any]]


def load_json(text: str, constants: Callable[[str], Any] | None = None) -> Any:
    """Return the data of a JSON text.

    Parameters
    ----------
    text
        The text.
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
    outside = _STRING.sub("", text)
    if long := _LONG_NUMBER.search(outside):
        require_digits(len(long[0]), f"line {1 + outside.count(chr(10), 0, long.start())}: ")
    codes = np.frombuffer(outside.encode("utf-8", "replace"), np.uint8)
    steps = _STEPS[codes]
    brackets = steps[steps != 0]
    require_values(int(np.count_nonzero(codes == ord(","))) + len(brackets))
    require_depth(int(np.cumsum(brackets, dtype=np.int64).max(initial=0)))
    return json.loads(text, object_pairs_hook=unique_keys, parse_constant=constants)


def read_json(data: bytes | str, where: object = "", constants: Callable[[str], Any] | None = None) -> Any:
    """Return what a JSON text, or bytes in the encoding that they begin in, hold, or raise `InputError`.

    Parameters
    ----------
    data
        The text or the bytes.
    where
        What messages name, such as the file.
    constants
        As for `load_json`.
    """
    try:
        text = data if isinstance(data, str) else data.decode(json.detect_encoding(data), "surrogatepass")
        return load_json(text, constants=constants)
    except InputError:
        raise
    except UnicodeDecodeError as error:
        said = f"expected text in UTF-8, found something else at byte {error.start}"
    except json.JSONDecodeError as error:
        cut = error.pos > len(error.doc.rstrip()) - 5 or error.msg.startswith("Unterminated string")  # as in "tru"
        line = f"line {error.lineno}: " if where else ""
        said = f"{line}expected JSON, found {'it cut off' if cut else 'something else'}: {error.msg}"
    except RecursionError:
        said = "its lists and objects are nested too deeply to be read here"
    except ValueError as error:
        said = str(error)
    raise InputError(f"{where}: {said}" if where else said) from None


def unique_keys(pairs: Pairs) -> dict[str, Any]:
    """Return an object's keys and values, or raise `ValueError` if a key stands twice."""
    data = dict(pairs)
    if len(data) < len(pairs):
        twice = next(name for name, many in Counter(name for name, _ in pairs).items() if many > 1)
        said = [value for name, value in pairs if name == twice]
        named = next((name for name in ("name", "identifier", "id") if isinstance(data.get(name), str | int)), None)
        within = "" if named is None else f", where {named!r} is {shown(data[named])}"
        raise ValueError(
            f"field {printable(twice)!r}: expected it once in an object, found it {len(said)} times: "
            f"{shown(said[0])} and {shown(said[1])}{within}"
        )
    return data
