"""Lines of JSON become observations; how long a line may be is counted before it is read."""

import json
from functools import cache
from typing import Any

from pydantic import ValidationError

from skyverse.documents.json import load_json
from skyverse.errors import InputError
from skyverse.live.messages import ObservationMessage
from skyverse.model.wrong_values import keys_of_schema, wrong_field

MAX_LINE = 2**23
"""Bytes of a line at most, 8 MB: an observation of ten thousand obstacles."""


class LineSplitter:
    """Splits what arrives in chunks into lines, and holds no more of an overlong line than is needed to refuse it.

    Attributes
    ----------
    most
        Bytes of a line that are held at most.
    """

    def __init__(self, most: int = MAX_LINE + 1) -> None:
        self.most = most
        self._held = bytearray()

    def lines(self, chunk: bytes) -> list[bytes]:
        """Return the lines that a chunk completes, without their ends."""
        *whole, rest = chunk.split(b"\n")
        done = []
        for part in whole:
            self._hold(part)
            done.append(bytes(self._held))
            self._held.clear()
        self._hold(rest)
        return done

    def end(self) -> list[bytes]:
        """Return what is left at the end of the input as its last line, if there is anything."""
        rest = bytes(self._held)
        self._held.clear()
        return [rest] if rest else []

    def _hold(self, part: bytes) -> None:
        self._held += part[: max(self.most - len(self._held), 0)]


def read_json(line: bytes) -> Any:
    """Return what a line of JSON holds.

    Raises
    ------
    InputError
        If it holds something else.
    """
    if len(line) > MAX_LINE:
        raise InputError(f"expected at most {MAX_LINE:,} bytes in a line, found more")
    try:
        return load_json(line.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise InputError(f"expected text in UTF-8, found something else at byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise InputError(f"expected JSON, found something else at character {error.pos + 1}: {error.msg}") from None
    except ValueError as error:
        raise InputError(str(error)) from None


def read_observation(line: bytes) -> ObservationMessage:
    """Return the observation that a line holds.

    Raises
    ------
    InputError
        If it is none; the message names the field.
    """
    data = read_json(line)
    try:
        return ObservationMessage.model_validate(data)
    except ValidationError as error:
        field, said = wrong_field(error, data, _known_keys())
        raise InputError(said, field=field or None) from None


@cache
def _known_keys() -> set[str]:
    """Return the keys that an observation may have anywhere."""
    return keys_of_schema(ObservationMessage.model_json_schema())
