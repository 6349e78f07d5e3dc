"""When zones are active, from the ways in which files say so: seconds after the beginning of a mission."""

import math
from collections.abc import Iterator, Mapping
from datetime import date as calendar_date
from datetime import datetime, time, timedelta
from typing import Any

from skyverse.errors import InputError, Remedy, shown
from skyverse.maps.georeference.feature import Fields, is_empty, plain, require_type
from skyverse.maps.georeference.reading import instant_of
from skyverse.model.shapes import Spans

HORIZON = 86_400.0
"""Seconds after its beginning until which a mission may last: no zone is looked up for later."""
SEAM = 60.0
"""Seconds: gaps up to this long are closed, as files let days end at 23:59."""
_LISTS = ("applicability", "limitedapplicability", "timespan")
_BEGINS = ("startdatetime", "starttime", "validfrom", "activefrom")
_ENDS = ("enddatetime", "endtime", "validto", "validuntil", "activeto", "activeuntil")
_UNREAD = ("activetimes", "timesofuse", "hoursofoperation", "operatinghours")
TIME_FIELDS = (*_LISTS, "schedule", *_BEGINS, *_ENDS, *_UNREAD)
"""Plain names of fields that say when a zone is active: ED-269's, ED-318's, the FAA's, openAIP's, KML's and others."""
_ALWAYS = ("yes", "true", "any", "always", "permanent", "continuous", "h24", "24h", "247")
"""Plain names of what such fields hold where a zone is always active."""
_DAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
GIVE_DATE = Remedy("Reading.date", "2026-11-26T10:00+01:00", "for the times to count")
"""What helps where a file says when its zones are active, with an example."""
Span = tuple[float, float]


def said_times(fields: Fields) -> dict[str, Any]:
    """Return the fields of `TIME_FIELDS` that say more than that a zone is always active, as the file writes them."""
    return {written: value for written, value in fields.of(*TIME_FIELDS) if _says_times(value)}


def _says_times(value: object) -> bool:
    if isinstance(value, dict | list):
        return any(map(_says_times, value.values() if isinstance(value, dict) else value))
    return not is_empty(value) and plain(str(value)) not in _ALWAYS


def active_times(said: Mapping[str, Any], where: str, begin: datetime) -> Spans | None:
    """Return when a zone is active in a mission: ``None`` for always, and no span for never until `HORIZON`.

    Parameters
    ----------
    said
        The fields that say so, as `said_times` gives them.
    where
        File and feature, for messages.
    begin
        When the mission begins.

    Raises
    ------
    InputError
        If a field cannot be read, has no time zone, or there are several that may contradict one another.
    """
    lists = [name for name in said if plain(name) in _LISTS]
    if lists and len(said) > 1:
        raise InputError(f"{where}: expected times in one field, found {', '.join(map(repr, said))}")
    found: list[Span] = []
    if lists:
        value = said[lists[0]]
        for k, period in enumerate(value if isinstance(value, list) else [value]):
            place = f"{where}: '{lists[0]}[{k}]'"
            found += _period(require_type(dict, period, place, "times"), place, begin)
    else:
        found += _period(said, where, begin)
    merged: list[Span] = []
    for first, last in sorted(found):
        if merged and first <= merged[-1][1] + SEAM:
            merged[-1] = (merged[-1][0], max(last, merged[-1][1]))
        else:
            merged.append((first, last))
    near = [(first, last) for first, last in merged if last >= 0.0 and first <= HORIZON]
    spans = tuple((None if a <= 0.0 else a, None if b >= HORIZON else b) for a, b in near)
    return None if spans == ((None, None),) else spans


def _period(said: Mapping[str, Any], where: str, begin: datetime) -> Iterator[Span]:
    """Yield when one entry of ED-269's `applicability`, or another such object, is active: first and last second."""
    first, last, days = -math.inf, math.inf, None
    given = {plain(name): (f"{where}: {name!r}", value) for name, value in said.items() if not is_empty(value)}
    place, permanent = given.pop("permanent", (where, "no"))
    if plain(str(permanent)) in _ALWAYS:
        yield first, last
        return
    if plain(str(permanent)) not in ("no", "false"):
        raise InputError(f"{place}: expected YES or NO, found {shown(permanent)}")
    for name, (place, value) in given.items():
        if name in (*_BEGINS, "begin"):
            first = max(first, _seconds(value, place, begin))
        elif name in (*_ENDS, "end"):
            last = min(last, _seconds(value, place, begin))
        elif name == "schedule":
            days = [
                span
                for k, one in enumerate(require_type(list, value, place, "a list of daily times"))
                for span in _daily(require_type(dict, one, place, "daily times"), f"{place}[{k}]", begin)
            ]
        else:
            raise InputError(f"{place}: expected a beginning, an end or a schedule, found {shown(value)}")
    if not given or not first < last:
        raise InputError(f"{where}: expected a beginning and a later end, or a schedule, found {shown(dict(said))}")
    for start, end in [(-math.inf, math.inf)] if days is None else days:
        if max(first, start) < min(last, end):
            yield max(first, start), min(last, end)


def _daily(said: Mapping[str, Any], where: str, begin: datetime) -> Iterator[Span]:
    """Yield when a daily period of a schedule is active, from two days before a mission begins to two days after."""
    given = {plain(name): value for name, value in said.items() if not is_empty(value)}
    names = given.get("day")
    names = [plain(str(day)) for day in (names if isinstance(names, list) else [names])]
    unknown = [name for name in said if plain(name) not in ("day", "starttime", "endtime")]
    if unknown or not names or set(names) - {*_DAYS, "any"}:
        raise InputError(
            f"{where}: expected 'day', of MON to SUN or ANY, 'startTime' and 'endTime', found {shown(said)}"
        )
    try:
        start, end = (time.fromisoformat(given[name]) for name in ("starttime", "endtime"))
    except (KeyError, TypeError, ValueError):
        start = end = time()
    if start.tzinfo is None or end.tzinfo is None:
        raise InputError(f"{where}: expected times of day with their time zone, as 08:00Z, found {shown(said)}")
    for day in (calendar_date.fromordinal(begin.toordinal() + k) for k in range(-2, 3)):
        if "any" in names or _DAYS[day.weekday()] in names:
            opened, closed = datetime.combine(day, start), datetime.combine(day, end)
            closed += timedelta(days=closed <= opened)  # past midnight, or all day
            yield (opened - begin).total_seconds(), (closed - begin).total_seconds()


def _seconds(value: object, place: str, begin: datetime) -> float:
    found = instant_of(value)
    if found is None:
        raise InputError(f"{place}: expected a date and time with its time zone, found {shown(value)}")
    return (found - begin).total_seconds()
