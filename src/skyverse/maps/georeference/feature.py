"""Buildings and zones as files have them, rectangles around them, and fields, whatever their case and punctuation."""

import math
import re
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar

from skyverse._typing import Floats
from skyverse.errors import InputError, printable, shown
from skyverse.model.altitude import Altitude
from skyverse.model.frame import MAX_FAR
from skyverse.model.shapes import Spans

MAX_WIDTH = 2 * MAX_FAR
"""Metres that a scenario may be wide."""
ABOVE_PERMITTED = "airspace above the permitted height"
"""The kind of what is above the heights up to which flight is permitted."""
Rectangle = tuple[float, float, float, float]
"""The least x and y and the greatest x and y, metres."""


def intersection(one: Rectangle, other: Rectangle) -> Rectangle:
    """Return the rectangle that two rectangles share; where they share none, a minimum is above its maximum."""
    return max(one[0], other[0]), max(one[1], other[1]), min(one[2], other[2]), min(one[3], other[3])


def contains(rectangle: Rectangle, point: Floats) -> bool:
    """Tell whether a point (x, y, ...) lies in a rectangle."""
    return bool(rectangle[0] <= point[0] <= rectangle[2] and rectangle[1] <= point[1] <= rectangle[3])


@dataclass(frozen=True, eq=False)
class Feature:
    """One building or zone as its file has it; a multipolygon becomes several features.

    Attributes
    ----------
    outline
        (n, 2) WGS84 longitude and latitude, degrees; the first corner is not repeated at the end.
    holes
        The holes' outlines, each (k, 2).
    low, high
        The altitudes at which it begins and ends. ``None`` for `low` means from the ground on, for `high` without end.
    kind
        ``"building"``, or what the file calls the zone.
    solid
        Whether it is a building or another thing, rather than a zone.
    name
        Its name, if it has one.
    where
        File and feature, for messages: ``zones.geojson: feature 3``.
    risk
        The risk of a metre flown inside, for a zone that may be entered; ``None`` for what must not be entered.
    active
        When it is active, seconds after the mission begins; ``None`` for always.
    has_times
        Whether its file says when it is active.
    """

    outline: Floats
    holes: tuple[Floats, ...]
    low: Altitude | None
    high: Altitude | None
    kind: str
    solid: bool
    name: str | None
    where: str
    risk: float | None = None
    active: Spans | None = None
    has_times: bool = False


T = TypeVar("T")


_NUMBER = r"\s*[-+]?\.?\d"
_TIME = r"(?s:.*)(\d{1,2}:\d\d|\d{4}-?\d\d-?\d\d|\b\d{4}-\d{4}\b)"
LIMITS = "alt|height|limit|upper|lower|ceiling|floor", _NUMBER
RADII = "radius|buffer|distance|width|diameter", _NUMBER
TIMES = "start|begin|end|from|until|till|valid|activ|hours|schedule|period|expir", _TIME
"""What stands in plain names of fields that look like a limit, a radius or a time, and how such a value is written."""


class Fields:
    """The fields of a feature that hold something; names are compared as `plain` gives them.

    They know which of them were asked for, so that those that nobody reads can be told.
    """

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self._asked: set[str] = set()
        self._fields: dict[str, list[tuple[str, Any]]] = {}
        for name, value in fields.items():
            if not is_empty(value):
                self._fields.setdefault(plain(name), []).append((name, value))

    def get(self, name: str) -> Any:
        """Return a field's value, or ``None``; where several fields have that plain name, the last one's."""
        self._asked.add(plain(name))
        return self._fields.get(plain(name), [(name, None)])[-1][1]

    def of(self, *names: str) -> Iterator[tuple[str, Any]]:
        """Return the name, as the file writes it, and the value of each field that has one of these plain names."""
        self._asked.update(names)
        return (field for name in names for field in self._fields.get(name, ()))

    def unread(self, looks: tuple[str, str]) -> dict[str, Any]:
        """Return the fields that nobody asked for which look like `LIMITS`, `RADII` or `TIMES`.

        A field within a field is named as in ``volume.upper``.
        """
        found: dict[str, Any] = {}
        for name, held in self._fields.items():
            for written, value in () if name in self._asked else held:
                if isinstance(value, Mapping):
                    within = Fields({str(key): inner for key, inner in value.items()}).unread(looks)
                    found |= {f"{written}.{inner}": one for inner, one in within.items()}
                elif type(value) in (int, float, str) and re.search(looks[0], name) and re.match(looks[1], str(value)):
                    found[written] = value
        return found

    def text(self, *names: str) -> str | None:
        """Return the first of these fields that holds a text, in printable characters."""
        for _, value in self.of(*names):
            if isinstance(value, str) and value.strip():
                return printable(value)
        return None


@lru_cache(maxsize=4096)
def plain(name: str) -> str:
    """Return a field's name in lower case, letters and digits only."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def is_empty(value: object) -> bool:
    """Tell whether a value is null, a blank text, or the NaN of an empty cell."""
    if isinstance(value, float):
        return math.isnan(value)
    return value is None or (isinstance(value, str) and not value.strip())


def number_of(value: object, place: str) -> float:
    """Return the number that a field must hold, or raise `InputError`."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e6:
        raise InputError(f"{place}: expected metres or feet, found {shown(value)}")
    return float(value)


def looked_up(table: Mapping[str, T], value: object, place: str, expected: str) -> T:
    """Return what a word stands for by its plain name, or raise `InputError`."""
    found = table.get(plain(value)) if isinstance(value, str) else None
    if found is None:
        raise InputError(f"{place}: expected {expected}, found {shown(value)}")
    return found


def require_type(kind: type[T], value: object, place: str, expected: str) -> T:
    """Return a value that must be of this type, or raise `InputError`."""
    if not isinstance(value, kind):
        raise InputError(f"{place}: expected {expected}, found {shown(value)}")
    return value


def are_numbers(value: object, counts: Container[int], limit: float) -> bool:
    """Tell whether a value is a list of as many numbers as `counts` allows, all nearer to zero than a limit."""
    return (
        isinstance(value, list)
        and len(value) in counts
        and all(type(number) in (int, float) and abs(number) < limit for number in value)
    )


SWAPPED = "; are latitude and longitude swapped?"
"""What is added to a message where the two would fit the other way round."""


def require_on_globe(what: str, latitude: float, longitude: float) -> None:
    """Raise `InputError`, which begins with `what`, unless both are in their ranges, degrees."""
    if not abs(latitude) <= 90:
        hint = SWAPPED if abs(latitude) <= 180 and abs(longitude) <= 90 else ""
        raise InputError(f"{what}: expected a latitude from -90 to 90 degrees, found {latitude:g}{hint}")
    if not abs(longitude) <= 180:
        raise InputError(f"{what}: expected a longitude from -180 to 180 degrees, found {longitude:g}")
