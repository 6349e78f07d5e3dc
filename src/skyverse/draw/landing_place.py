"""A place where a UAV may land when it returns by itself."""

from dataclasses import dataclass

from skyverse.draw.track import Point


@dataclass(frozen=True)
class LandingPlace:
    """Where a UAV may land when it returns.

    Attributes
    ----------
    uav
        Its index.
    words
        What is told of the place.
    position
        x, y, z in metres.
    level
        z at which the UAV returns there, unless it is higher already, metres.
    """

    uav: int
    words: str
    position: Point
    level: float
