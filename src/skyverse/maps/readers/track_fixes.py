"""What files of recorded tracks say: where something was, and when, one fix after another."""

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Literal

from skyverse.errors import InputError, shown

Reference = Literal["amsl", "ellipsoid"]
"""What altitudes are counted from: mean sea level, or the WGS84 ellipsoid."""
Unit = Literal["m", "ft"]
"""What altitudes are counted in."""
FIRST_DATE = 1e8
"""Seconds since 1970 from which on numbers are taken for dates, not for seconds into a mission."""
LAST_DATE = 1e10
"""Seconds since 1970, the year 2286: larger numbers are milliseconds."""


@dataclass(frozen=True)
class Fixes:
    """The fixes of one vehicle, n of them.

    Attributes
    ----------
    lines
        The number of each one's line, or, in GPX, of its point.
    line
        What messages call such a number: ``"line"`` or ``"point"``.
    times
        Seconds, since 1970 where they are `dated`.
    dated
        Whether the times are dates.
    first
        The earliest time in the file, of any vehicle.
    places
        x, y, z in metres; or latitude, longitude in degrees, and altitude in its unit.
    in_degrees
        Whether they are the latter.
    reference
        What altitudes are counted from; ``None`` where the file does not say.
    unit
        The unit of altitudes; ``None`` where the file does not say.
    heights
        What the file calls its altitudes.
    errors
        How far off each fix may be, metres; empty where the file does not say.
    """

    lines: list[int]
    line: str
    times: list[float]
    dated: bool
    first: float
    places: list[tuple[float, float, float]]
    in_degrees: bool
    reference: Reference | None
    unit: Unit | None
    heights: str
    errors: list[float]


def number(text: str | None, where: str) -> float:
    """Return a finite number, or raise `InputError`; `where` begins the message."""
    try:
        value = float((text or "").strip())
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: expected a number, found {shown((text or '').strip())}")
    return value


def time(text: str | None, where: str) -> tuple[float, bool]:
    """Return seconds, and whether they are those since 1970; dates as ISO 8601 has them, in UTC if they do not say."""
    said = (text or "").strip()
    if "-" in said[1:] and ":" in said:
        try:
            moment = datetime.fromisoformat(said)
        except ValueError:
            raise InputError(f"{where}: expected seconds or a date, found {shown(said)}") from None
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp(), True
    seconds = number(said, where)
    if seconds > LAST_DATE:
        raise InputError(f"{where}: expected seconds, found {seconds:g}, which may be milliseconds")
    return seconds, seconds >= FIRST_DATE
