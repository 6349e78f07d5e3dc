"""What the search for clear legs passes on to the referee: segments, and what is wrong with a leg."""

import math
from typing import NamedTuple

from skyverse._typing import Floats

Foot = tuple[float, float, float]


class Segments(NamedTuple):
    """Straight segments that keep clear of all obstacles by the clearance.

    Attributes
    ----------
    starts, ends
        (n, 3) metres.
    growth
        Metres beside the clearance less `LEG_ALLOWANCE`.
    strays
        Whether the tracking error counts. In a column over the UAV's own start or target, segments are asked for twice:
        without the error, and with it among all but what lies below.
    foot
        In the latter case, x, y and z of the foot of that column, metres.
    upright
        Metres by which the UAV may be above or below them besides.
    """

    starts: Floats
    ends: Floats
    growth: float
    strays: bool = True
    foot: Foot | None = None
    upright: float = 0.0


class Shortfall(NamedTuple):
    """What is wrong at a place, (3,) metres, in words that follow "it"."""

    said: str
    place: Floats


class Checked(NamedTuple):
    """What the search found of a leg or of a corner.

    Attributes
    ----------
    fault
        What is wrong, in words or as segments that meet something; ``None`` if nothing is.
    clear
        The segments that make it clear, which the referee has yet to prove.
    """

    fault: Shortfall | Segments | None
    clear: tuple[Segments, ...] = ()


def towards(way: Floats, radius: float) -> Floats:
    """Return a vector, (3,), cut to the length `radius`."""
    length = math.hypot(*way)
    return way * min(radius / length, 1.0) if length else way


def place_text(place: Floats) -> str:
    """Write a place, (3,) metres, to the centimetre."""
    return f"({', '.join(f'{value:.2f}' for value in place)})"
