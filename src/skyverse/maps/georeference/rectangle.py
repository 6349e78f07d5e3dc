"""Rectangles of the local frame."""

from skyverse._typing import Floats

Rectangle = tuple[float, float, float, float]
"""The least x and y and the greatest x and y, metres."""


def intersection(one: Rectangle, other: Rectangle) -> Rectangle:
    """Return the rectangle that two rectangles share; where they share none, a minimum is above its maximum."""
    return max(one[0], other[0]), max(one[1], other[1]), min(one[2], other[2]), min(one[3], other[3])


def contains(rectangle: Rectangle, point: Floats) -> bool:
    """Tell whether a point (x, y, ...) lies in a rectangle."""
    return bool(rectangle[0] <= point[0] <= rectangle[2] and rectangle[1] <= point[1] <= rectangle[3])
