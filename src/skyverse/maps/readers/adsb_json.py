"""What receivers of ADS-B wrote as JSON: traces of one aircraft, and snapshots of all that were heard, as a table.

Altitudes are geometric, in feet above the WGS84 ellipsoid. Positions of an aircraft on the ground, or whose altitude
follows the pressure of the air, have none, and are left out; how long nothing may be known is up to the caller.

Sources: readsb, README-json.md; RTCA DO-260B, tables of NACp and GVA.
"""

import gzip
import math
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from skyverse.documents.json import load_json
from skyverse.documents.limits import MAX_BYTES
from skyverse.errors import InputError, shown, unreadable
from skyverse.maps.readers.track_files import Fixes, fixes_of_rows

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
NAMES = ["time", "hex", "lat", "lon", "alt_geom_ft", "error"]


def adsb_fixes(path: Path, vehicle: str | None) -> Fixes:
    """Return the fixes of the only aircraft in a trace or in snapshots, one on each line, or of one that is named.

    Raises
    ------
    InputError
        If the file is none of these, or has fewer than two positions of the aircraft with a geometric altitude.
    """
    with unreadable(path, "cannot be read", EOFError, zlib.error), path.open("rb") as stream:
        packed = stream.peek(2)[:2] == GZIP
        data = (gzip.GzipFile(fileobj=stream) if packed else stream).read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise InputError(f"{path}: expected at most {MAX_BYTES:,} bytes, found more")
    lines = data.splitlines() if path.suffix.lower() == ".jsonl" else [data]
    rows, last = dict[int, list[str]](), dict[str, float]()
    for k, line in enumerate(lines, 1):
        wrong = (KeyError, TypeError, ValueError, RecursionError)
        with unreadable(f"{path}: line {k}", "expected a receiver's trace or snapshot, found something else", *wrong):
            for time, told in _positions(load_json(line.decode("utf-8"))):
                feet, address = told.get("alt_geom"), str(told["hex"])
                again = len(lines) > 1 and abs(time - last.get(address, -math.inf)) < REPEATED
                if feet is None or told.get("alt_baro") == "ground" or again:
                    continue
                last[address] = time
                error = math.hypot(NACP.get(told.get("nac_p", 0), 0), GVA.get(told.get("gva", 0), 0))
                rows[len(rows) + 1] = list(map(str, (time, address, told["lat"], told.get("lon"), feet, error)))
    count = sum(vehicle is None or row[1].lower() == vehicle.strip().lower() for row in rows.values())
    if count < 2:
        raise InputError(
            f"{path}: expected two positions or more of {shown(vehicle or 'one aircraft')} with a geometric "
            f"altitude (alt_geom), found {count}; one that follows the pressure of the air (alt_baro) is none, nor is "
            "'ground', and snapshots stand one on each line (.jsonl)"
        )
    return fixes_of_rows(path, NAMES, rows, vehicle, "position")


def _positions(data: Any) -> Iterator[tuple[float, dict[str, Any]]]:
    """Yield the instant of each position, seconds since 1970, and what is told of the aircraft, by readsb's keys."""
    if not isinstance(data, dict):
        raise TypeError(shown(data, 60))
    if "trace" in data:
        for after, latitude, longitude, altitude, _, _, flags, _, extra, *newer in data["trace"]:
            told = {"alt_geom": newer[1] if len(newer) > 1 else None, **(extra or {})}
            if flags & ALTITUDE_IS_GEOMETRIC:
                told["alt_geom"] = altitude
            told |= {"hex": data["icao"], "lat": latitude, "lon": longitude, "alt_baro": altitude}
            yield float(data["timestamp"]) + float(after), told
    else:
        for told in data["aircraft"]:
            if "lat" in told:
                yield float(data["now"]) - float(told["seen_pos"]), told
