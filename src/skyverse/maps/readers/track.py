"""Recorded tracks as motions of movers: from fix to fix in a straight line, each at its instant."""

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, path_of, require_file, shown
from skyverse.maps.georeference.feature import require_on_globe
from skyverse.maps.readers.adsb_json import adsb_fixes
from skyverse.maps.readers.track_files import Altitudes, Fixes, Reference, Unit, gpx_fixes, table_fixes, time
from skyverse.model.altitude import FOOT
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local
from skyverse.model.mover_motions import WaypointMotion
from skyverse.model.quantities import MAX_INSTANT

LONGEST_GAP = 60.0
"""Seconds between two fixes, beyond which nobody can say where a vehicle was, unless a caller knows better."""


class RecordedTrack(NamedTuple):
    """A motion, and how far off its fixes may be, metres; 0 where the file does not say.

    Where several fixes share a second, over which they are spread, `spread` is how far off the motion may be for that.
    """

    motion: WaypointMotion
    error: float
    spread: float


def read_track(
    path: str | Path,
    origin: Origin | None = None,
    *,
    altitude: Reference | None = None,
    unit: Unit | None = None,
    vehicle: str | None = None,
    zero: float | str | None = None,
    gap: float = LONGEST_GAP,
) -> WaypointMotion:
    """Read a recorded track as the motion of a mover.

    Parameters
    ----------
    path
        ``.csv``, a table whose first line names its columns: ``t``, and ``x``, ``y``, ``z`` in metres or ``latitude``,
        ``longitude``, ``altitude``; state vectors as ADS-B receivers and the OpenSky Network write them have
        ``icao24`` and ``geoaltitude``. Altitudes that follow the pressure are refused. ``.gpx``, a track. ``.json``, a
        trace of readsb or tar1090; ``.jsonl``, one of their snapshots (``aircraft.json``) on each line.
    origin
        Where the zero of the scenario's frame lies; needed for degrees.
    altitude
        What altitudes are counted from, ``"amsl"``, mean sea level, or ``"ellipsoid"``, that of WGS84; needed unless
        the name of their column says so (``altitude_amsl``, ``altitude_ellipsoid``, ``geoaltitude``).
    unit
        What they are counted in, ``"m"`` or ``"ft"``; needed unless the name of their column says so
        (``altitude_amsl_m``, ``geoaltitude_ft``), or the file is GPX or JSON, or has the columns of the OpenSky
        Network.
    vehicle
        The vehicle, by its ``icao24`` or name, or the name of a GPX track, where the file has several.
    zero
        The instant of the recording that is 0 s into the mission: a date, or seconds as in the file. By default the
        earliest one in the file if times are dates, else 0.
    gap
        Seconds that may pass between two fixes, between which the motion is a straight line.

    Returns
    -------
    WaypointMotion
        In seconds into the mission and local metres. Before its first and after its last fix the mover stands there.
        Fixes whose dates are the same whole second are spread over it; a mover of a scenario file that names the track
        has a doubt that covers that.

    Raises
    ------
    InputError
        If the file is none of these, a number is missing or none, times do not rise, a gap is too long, or it is not
        known what altitudes are counted from, and in what; the message names file, line and column.
    """
    return recorded_track(
        path_of(path), origin, altitude=altitude, unit=unit, vehicle=vehicle, zero=zero, gap=gap
    ).motion


def recorded_track(
    path: Path,
    origin: Origin | None,
    *,
    altitude: Reference | None,
    unit: Unit | None,
    vehicle: str | None,
    zero: float | str | None,
    gap: float,
) -> RecordedTrack:
    """Return a recorded track with its error; see `read_track`."""
    for field, given, known in (("altitude", altitude, Reference), ("unit", unit, Unit)):
        if given not in (None, *get_args(known)):
            raise InputError(f"expected {' or '.join(map(repr, get_args(known)))}, found {shown(given)}", field=field)
    if isinstance(gap, bool) or not isinstance(gap, int | float) or not gap > 0:
        raise InputError(f"expected seconds above 0, found {gap!r}", field="gap")
    readers = {".csv": table_fixes, ".gpx": gpx_fixes, ".json": adsb_fixes, ".jsonl": adsb_fixes}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(
            f"{path}: expected a track ending in {', '.join(readers)}, found {path.suffix or 'no ending'!r}"
        )
    require_file(path)
    found, seconds = _spread(reader(path, vehicle))
    _require_rising(path, found, gap)
    begin = _zero(path, found, zero)
    points = np.array(found.places)
    if found.altitudes is not None:
        points = _local(path, found, found.altitudes, origin, altitude, unit)
    instants = np.array(found.times) - begin
    if not np.abs(instants).max() <= MAX_INSTANT:
        raise InputError(f"{path}: its times are {MAX_INSTANT:g} s or more away from the mission's beginning")
    motion = WaypointMotion(points=tuple(map(tuple, points.tolist())), times=tuple(instants.tolist()))
    boxes = (np.ptp(points[max(begin - 1, 0) : end + 1], axis=0) for begin, end in seconds)
    spread = max((math.hypot(*box.tolist()) for box in boxes), default=0.0)
    return RecordedTrack(motion, max(found.errors, default=0.0), spread)


def _spread(found: Fixes) -> tuple[Fixes, list[tuple[int, int]]]:
    """Spread fixes that share a second over it, where dates are whole seconds, as clocks are written cut off.

    Returns the fixes, and the numbers of the first of each second and of the first behind it: between the fix before
    them and the one behind them the vehicle was all that second. Nothing, if no second has several.
    """
    times = np.array(found.times)
    firsts = np.flatnonzero(np.diff(times, prepend=-np.inf))
    if not found.dated or len(firsts) == len(times) or (times % 1 != 0).any():
        return found, []
    ends = np.append(firsts[1:], len(times))
    counts = np.repeat(ends - firsts, ends - firsts)
    times += (np.arange(len(times)) - np.repeat(firsts, ends - firsts)) / counts
    return replace(found, times=times.tolist()), list(zip(firsts.tolist(), ends.tolist(), strict=True))


def _require_rising(path: Path, found: Fixes, gap: float) -> None:
    for k in range(1, len(found.times)):
        passed = found.times[k] - found.times[k - 1]
        where, before = f"{path}: {found.line} {found.lines[k]}: time", f"{found.line} {found.lines[k - 1]}"
        if passed == 0:
            raise InputError(f"{where}: expected a later one than in {before}, found the same again")
        if passed < 0:
            raise InputError(f"{where}: expected a later one than in {before}, found one that is {-passed:g} s earlier")
        if passed > gap:
            raise InputError(
                f"{where}: {passed:g} s have passed since {before}, more than {gap:g}; give gap, if the vehicle is "
                "known to have flown straight on"
            )


def _zero(path: Path, found: Fixes, zero: float | str | None) -> float:
    """Return the instant of the recording that is 0 s into the mission, seconds."""
    if zero is None:
        return found.first if found.dated else 0.0
    seconds, dated = time(str(zero), f"{path}: zero")
    if dated != found.dated:
        expected = "a date, or seconds since 1970" if found.dated else "seconds as in the file"
        raise InputError(f"{path}: zero: expected {expected}, found {shown(zero)}")
    return seconds


def _local(
    path: Path,
    found: Fixes,
    altitudes: Altitudes,
    origin: Origin | None,
    altitude: Reference | None,
    unit: Unit | None,
) -> Floats:
    """Return places in degrees as local metres, (n, 3)."""
    if origin is None:
        raise InputError(f"{path}: its places are in degrees, but the scenario has no frame.origin")
    for line, (latitude, longitude, _) in zip(found.lines, found.places, strict=True):
        require_on_globe(f"{path}: {found.line} {line}", latitude, longitude)
    where, reference, counted_in = f"{path}: {altitudes.name}", altitudes.reference or altitude, altitudes.unit or unit
    if reference is None:
        raise InputError(
            f"{where}: expected word what it is counted from, mean sea level (altitude: amsl) or the WGS84 ellipsoid "
            "(altitude: ellipsoid), found none; the altitude of ADS-B messages follows the pressure of the air, and is "
            "neither"
        )
    if altitude not in (None, reference):
        raise InputError(f"{where}: is counted from {reference}, not from {altitude}")
    if counted_in is None:
        raise InputError(f"{where}: expected word of its unit, metres (unit: m) or feet (unit: ft), found none")
    if unit not in (None, counted_in):
        raise InputError(f"{where}: is in {counted_in}, not in {unit}")
    places = np.array(found.places)
    places[:, 2] *= FOOT if counted_in == "ft" else 1.0
    if reference == "ellipsoid":
        if origin.geoid is None:
            raise InputError(
                f"{where}: is counted from the WGS84 ellipsoid, but the scenario has no frame.origin.geoid, which says "
                "how far the sea lies above it"
            )
        places[:, 2] -= origin.geoid
    return to_local(origin, places)
