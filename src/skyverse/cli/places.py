"""Points, places, altitudes and other numbers that a user writes as text."""

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from skyverse.errors import InputError
from skyverse.extras import require_libraries
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude, parse_altitude

if TYPE_CHECKING:
    from skyverse.model.altitude import GlobalPlace
    from skyverse.model.frame import Origin
    from skyverse.model.scenario import Scenario


def numbers_of(option: str, expected: str, text: str, count: int | None = None) -> Any:
    """Read numbers between commas, as many as `count` says if it says anything."""
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if not numbers or len(numbers) != (count or len(numbers)):
        raise InputError(f"{option}: expected {expected}, found {text!r}")
    return numbers


def point_of(option: str, text: str) -> tuple[float, float, float]:
    """Read a point of the local frame, as in ``0,-4,1``."""
    x, y, z = numbers_of(option, "x,y,z in metres, as in 0,-4,1", text, 3)
    return x, y, z


def ends_of(
    option: str, texts: Sequence[str], scenario: "Scenario"
) -> list[tuple[str | None, tuple[float, float, float]]]:
    """Read starts or targets, by name if they have one: points of the local frame, or places where it has an origin."""
    return [
        (name.strip() or None if equals else None, _end_of(option, rest if equals else text, scenario))
        for text in written_places(option, texts)
        for name, equals, rest in [text.rpartition("=")]
    ]


def _end_of(option: str, text: str, scenario: "Scenario") -> tuple[float, float, float]:
    """Read ``0,-4,1``, or ``46.81,9.85,60 m agl`` where the scenario has an origin."""
    from skyverse.maps.assembly.places import local_points, named_places, refuse_outside

    origin, last = scenario.frame.origin, text.rpartition(",")[2]
    if origin is None or not any(map(str.isalpha, last)):
        return point_of(option, text)
    place = _place_of(option, text)
    if isinstance(place[2], AboveHome):
        raise InputError(f"{option}: expected an altitude as agl or amsl, found {text!r}")
    named = named_places({f"{option} {text}": place}, "")
    low, high = scenario.bounds.min, scenario.bounds.max
    try:
        refuse_outside([*named], [place], origin, (*low[:2], *high[:2]), "the scenario's area")
    except InputError as error:
        raise InputError(f"{error}; skyverse scenario build --from builds it anew around other places") from None
    (point,) = local_points(named, {}, origin, scenario.terrain, {}).values()
    return point


def tracking_error_of(text: str | None) -> tuple[float, float] | None:
    """Read how far UAVs may stray, as in ``1.5,2``: metres seen from above, and metres in altitude."""
    if text is None:
        return None
    horizontal, vertical = numbers_of("--tracking-error", "horizontal,vertical in metres, as in 1.5,2", text, 2)
    return horizontal, vertical


def wind_of(wind: str | None, speed: float | None, direction: float | None) -> tuple[float, float, float] | None:
    """Read a wind: as a vector, ``1,0,0``, or as pilots tell it, a speed and the direction that it blows from."""
    from skyverse.model.wind import wind_from

    if speed is None and direction is None:
        if wind is None:
            return None
        east, north, up = numbers_of("--wind", "east,north,up in m/s, as in 1,0,0", wind, 3)
        return east, north, up
    if speed is None or direction is None:
        raise InputError("--wind-speed and --wind-from: expected both or neither, found only one of them")
    if wind is not None:
        raise InputError("--wind: expected either this or --wind-speed and --wind-from, found both")
    if not 0 <= speed < math.inf:
        raise InputError(f"--wind-speed: expected m/s from 0 on, found {speed:g}")
    if not -360 <= direction <= 360:
        raise InputError(f"--wind-from: expected degrees from north, clockwise, as in 270, found {direction:g}")
    return wind_from(speed, direction)


def share_of(option: str, text: str) -> float:
    """Read a share, as in ``20%`` or ``0.2``."""
    percent = text.strip().removesuffix("%")
    try:
        return float(percent) / (100.0 if percent != text.strip() else 1.0)
    except ValueError:
        raise InputError(f"{option}: expected a share, as in 20% or 0.2, found {text!r}") from None


def altitude_of(option: str, text: str) -> Altitude:
    """Read an altitude, as in ``60 m agl``."""
    try:
        return parse_altitude(text)
    except ValueError as error:
        raise InputError(f"{option}: {error}") from None


def altitude_above_sea(option: str, text: str) -> AboveSea:
    """Read an altitude above mean sea level, as in ``12 m amsl``."""
    altitude = altitude_of(option, text)
    if not isinstance(altitude, AboveSea):
        raise InputError(f"{option}: expected an altitude above mean sea level, as in '12 m amsl', found {text!r}")
    return altitude


def height_above_ground(option: str, text: str) -> AboveGround:
    """Read a height above the ground, as in ``120 m agl``."""
    altitude = altitude_of(option, text) if "agl" in text.lower() else None
    if not (isinstance(altitude, AboveGround) and altitude.metres > 0):
        raise InputError(f"{option}: expected a height above ground, as in '120 m agl', found {text!r}")
    return altitude


def places_of(option: str, kind: str, texts: Sequence[str]) -> "dict[str, GlobalPlace]":
    """Read places by name, as in ``alpha=46.81,9.85,60 m agl``; those without a name are numbered."""
    places: dict[str, GlobalPlace] = {}
    for number, text in enumerate(texts, 1):
        name, equals, rest = text.rpartition("=")
        key = name.strip() if equals else f"{kind}-{number}"
        if key in places:
            raise InputError(f"{option}: expected names that differ, found {key!r} twice")
        places[key] = _place_of(option, rest if equals else text)
    return places


def points_of(option: str, text: str, altitude: str | None = None) -> "dict[str, GlobalPlace] | None":
    """Read the points of a file, such as ``towers.kml`` or ``towers.gpx,60 m agl``; ``None`` for what is no file.

    `altitude` is that of all of them where only latitude and longitude count.
    """
    from skyverse.maps.readers import AREA_SUFFIXES

    before, _, said = text.rpartition(",")
    path, given = (text, None) if text.lower().endswith(AREA_SUFFIXES) else (before, said)
    if not path.lower().endswith(AREA_SUFFIXES):
        return None
    require_libraries(f"{option}: {path}", "pyproj")
    from skyverse.maps.readers.points import read_points

    try:
        return read_points(path, altitude=altitude or given)
    except InputError as error:
        more = f"; write '{path},60 m agl' for the altitude of all, or '{path},amsl' for what its own count from"
        raise InputError(f"{option}: {error.sentence.text}{more if error.sentence.give else ''}") from None


def written_places(option: str, texts: Sequence[str]) -> list[str]:
    """Return places each in its own words, ``tower 3=46.81,9.85,60 m agl``, also those of files."""
    written = []
    for text in texts:
        found = points_of(option, text)
        if found is None:
            written.append(text)
        else:
            written += [f"{name}={latitude!r},{longitude!r},{up}" for name, (latitude, longitude, up) in found.items()]
    return written


def _place_of(option: str, text: str) -> "GlobalPlace":
    latitude, longitude, altitude = _parts(option, text, "altitude, as in '46.81,9.85,60 m agl'")
    return latitude, longitude, altitude_of(f"{option} {text}", altitude)


def _parts(option: str, text: str, form: str) -> tuple[float, float, str]:
    """Return latitude and longitude, and what follows them, of which `form` tells what it should be."""
    words = text.split(",", 2)
    with suppress(ValueError, IndexError):
        return float(words[0]), float(words[1]), words[2]
    raise InputError(f"{option}: expected latitude,longitude,{form}, found {text!r}")


def origin_of(text: str) -> "Origin":
    """Read where a frame's zero lies, as in ``46.81,9.85,1560 m amsl``."""
    from skyverse.model.frame import Origin

    form = "altitude above mean sea level, as in '46.81,9.85,1560 m amsl'"
    latitude, longitude, said = _parts("--origin", text, form)
    altitude: Altitude | None = None
    with suppress(ValueError):
        altitude = parse_altitude(said)
    if not isinstance(altitude, AboveSea):
        raise InputError(f"--origin: expected latitude,longitude,{form}, found {text!r}")
    from skyverse.maps.georeference.feature import require_on_globe

    require_on_globe("--origin", latitude, longitude)
    return Origin(latitude=latitude, longitude=longitude, altitude=altitude.metres)
