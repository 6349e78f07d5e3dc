"""What receivers of ADS-B wrote as JSON: traces of one aircraft, and snapshots of all that were heard.

Altitudes are geometric, in feet above the WGS84 ellipsoid. Positions of an aircraft on the ground, or whose altitude
follows the pressure of the air, have none, and are left out; how long nothing may be known is up to the caller.

Sources: readsb, README-json.md; RTCA DO-260B, tables of NACp and GVA.
"""

import gzip
import math
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from skyverse.documents.json import load_json
from skyverse.documents.limits import MAX_BYTES
from skyverse.errors import InputError, first_line, shown, unreadable
from skyverse.maps.georeference.feature import are_numbers
from skyverse.maps.readers.track_files import FIRST_DATE, LAST_DATE, Altitudes, Fixes, of_vehicle

GZIP = b"\x1f\x8b"
"""How traces begin, which are compressed although their names say nothing of it."""
ALTITUDE_IS_GEOMETRIC = 8
"""A bit of the flags of a trace's entry."""
REPEATED = 0.2
"""Seconds: instants of one position in two snapshots are no farther apart, as times are rounded to 0.1 s."""
NACP = dict(enumerate((18520, 7408, 3704, 1852, 926, 556, 186, 93, 30, 10, 3), 1))
"""Metres to any side, by `nac_p`, within which a position is in 95 % of all cases."""
GVA = {1: 150, 2: 45}
"""Metres above or below, by `gva`, likewise."""


class _Position(NamedTuple):
    """Whose, the number of its line or entry, seconds since 1970, degrees, feet where known, and metres it is off."""

    vehicle: str
    number: int
    time: float
    latitude: float
    longitude: float
    altitude: float | None
    error: float


def adsb_fixes(path: Path, vehicle: str | None) -> Fixes:
    """Return the fixes of the only aircraft in a trace or in snapshots, one on each line, or of one that is named.

    Raises
    ------
    InputError
        If the file is none of these, or an aircraft has fewer than two positions with a geometric altitude.
    """
    with unreadable(path, "cannot be read", EOFError, zlib.error), path.open("rb") as stream:
        packed = stream.peek(2)[:2] == GZIP
        data = (gzip.GzipFile(fileobj=stream) if packed else stream).read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: expected at most {MAX_BYTES:,} bytes, found more")
    lines = path.suffix.lower() == ".jsonl"
    texts = enumerate(data.rstrip().split(b"\n") if lines else [data], 1)
    found = [one for k, text in texts for one in _positions(f"{path}: line {k}" if lines else str(path), text, k)]
    fixes: list[_Position] = []
    for k in of_vehicle(path, "hex", {k: one.vehicle for k, one in enumerate(found)}, vehicle):
        again = lines and fixes and abs(found[k].time - fixes[-1].time) < REPEATED
        if found[k].altitude is not None and not again:
            fixes.append(found[k])
    if len(fixes) < 2:
        raise InputError(
            f"{path}: expected two positions or more with a geometric altitude (alt_geom), found {len(fixes)}; an "
            "altitude that follows the pressure of the air (alt_baro) is none, nor is 'ground', and snapshots stand "
            "one on each line (.jsonl)"
        )
    return Fixes(
        lines=[one.number for one in fixes],
        line="line" if lines else "entry",
        times=[one.time for one in fixes],
        dated=True,
        first=min(one.time for one in found),
        places=[(one.latitude, one.longitude, one.altitude or 0.0) for one in fixes],
        altitudes=Altitudes("alt_geom", "ellipsoid", "ft"),
        errors=[one.error for one in fixes],
    )


def _positions(where: str, text: bytes, line: int) -> Iterator[_Position]:
    """Yield the positions of a trace, or of a snapshot that stands on some line."""
    try:
        data = load_json(text.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{where}: expected JSON, found something else: {first_line(error)}") from None
    rows = [data.get(key) for key in ("trace", "aircraft")] if isinstance(data, dict) else [None, None]
    if isinstance(rows[0], list):
        for k, row in enumerate(rows[0], 1):
            padded: list[Any] = [*(row if isinstance(row, list) else []), *[None] * 11]
            after, latitude, longitude, altitude, _, _, flags, _, extra, _, feet = padded[:11]
            told = {"alt_geom": feet} | (extra if isinstance(extra, dict) else {})
            if isinstance(flags, int) and flags & ALTITUDE_IS_GEOMETRIC:
                told["alt_geom"] = altitude
            told |= {"hex": data.get("icao"), "lat": latitude, "lon": longitude, "alt_baro": altitude}
            yield _position(f"{where}: entry {k}", k, [data.get("timestamp"), after], told)
    elif isinstance(rows[1], list):
        for told in rows[1]:
            if isinstance(told, dict) and "lat" in told:
                yield _position(where, line, [data.get("now"), told.get("seen_pos")], told, sign=-1)
    else:
        raise InputError(f"{where}: expected an ADS-B receiver's 'trace' or 'aircraft', found {shown(data, 60)}")


def _position(where: str, number: int, instant: list[Any], told: dict[str, Any], sign: int = 1) -> _Position:
    """Return a position some seconds after an instant, or before it, from what is told of an aircraft by its keys."""
    vehicle, feet = told.get("hex"), None if told.get("alt_baro") == "ground" else told.get("alt_geom")
    numbers = [*instant, told["lat"], told.get("lon"), *([] if feet is None else [feet])]
    if not isinstance(vehicle, str) or not are_numbers(numbers, (len(numbers),), 1e15):
        raise InputError(
            f"{where}: expected an address, seconds, degrees and feet, found {shown([vehicle, *numbers], 80)}"
        )
    time = numbers[0] + sign * numbers[1]
    if not FIRST_DATE <= time <= LAST_DATE:
        raise InputError(f"{where}: expected seconds since 1970, found {time:g}")
    nacp, gva = (told[key] if isinstance(told.get(key), int) else 0 for key in ("nac_p", "gva"))
    error = math.hypot(NACP.get(nacp, 0), GVA.get(gva, 0))
    return _Position(vehicle, number, time, numbers[2], numbers[3], feet, error)
