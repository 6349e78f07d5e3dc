"""Buildings and zones as files have them, and rectangles of the map around them."""

from dataclasses import dataclass

from skyverse._typing import Floats
from skyverse.model.altitude import Altitude
from skyverse.model.frame import MAX_FAR

MAX_WIDTH = 2 * MAX_FAR
"""Metres that a scenario may be wide."""
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
