"""The places where a returning UAV may land, as a pilot looks them up: on the globe, with the return altitude."""

import math
from typing import NamedTuple

import numpy as np

from skyverse.exports.global_positions import origin_of
from skyverse.exports.return_home import Return
from skyverse.model.geodesy import to_wgs84
from skyverse.model.scenario import Scenario

COMPASS = ("north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west")
"""Directions, every 45 degrees."""
COUNTED_FROM = {"px4": "where it lands", "ardupilot": "home", "dji": "home"}
"""What each autopilot counts its return altitude from; ArduPilot's rally points have altitudes of their own."""


class ReturnPlace(NamedTuple):
    """Where a UAV may land.

    Attributes
    ----------
    name
        ``"home"``, or ``"rally point 1"`` and so on.
    latitude, longitude
        WGS84 degrees.
    ground
        Metres above mean sea level of where it lands.
    level
        Metres above mean sea level over that place at which it returns there, unless it is higher already.
    """

    name: str
    latitude: float
    longitude: float
    ground: float
    level: float


def return_places(scenario: Scenario, back: Return) -> list[ReturnPlace]:
    """Return the places where a UAV may land, home first."""
    places, origin = back.way.places, origin_of(scenario)
    rows = np.column_stack([to_wgs84(origin, places), back.way.levels + origin.altitude]).tolist()
    names = ["home", *(f"rally point {number}" for number in range(1, len(places)))]
    return [ReturnPlace(name, *row) for name, row in zip(names, rows, strict=True)]


def places_text(scenario: Scenario, back: Return) -> str:
    """Return the places where a UAV may land, and at which altitude it returns to each, as a part of a sentence."""
    told = [
        f"{place.name} at {place.latitude:.6f}, {place.longitude:.6f}, {place.ground:z.1f} m above mean sea level, "
        f"returning there at {place.level:z.1f} m"
        for place in return_places(scenario, back)
    ]
    return f"{'; at '.join(told)}, or higher if it is higher"


def landing_name(back: Return) -> str:
    """Return where a UAV lands that returns at its end: ``"home"``, or a rally point and how far from home it is."""
    at = np.flatnonzero((back.rally == back.landing).all(axis=1))
    if not len(at):
        return "home"
    east, north, _ = (back.landing - back.plan.home).tolist()
    direction = COMPASS[round(math.degrees(math.atan2(east, north)) / 45) % 8]
    return f"rally point {at[0] + 1}, {math.hypot(east, north):.0f} m {direction} of home"
