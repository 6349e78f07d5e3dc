"""Conversion between WGS84 and local metres: a map of the Earth about an origin, and altitude.

x and y are east and north on the transverse Mercator projection of the ellipsoid whose central meridian goes through
the origin; z is the altitude above mean sea level less the origin's. So what is level or upright is so in the frame,
and all angles on the map are true. Lengths on the map are too long by the share x^2 / (2 R^2), where R is the radius of
the Earth: 1.2e-6 at 10 km east or west of the origin, 1e-4 at 90 km. h metres above the ellipsoid they are too short by
the share h / R, 1.6e-4 a kilometre.

Sources: L. Krüger, "Konforme Abbildung des Erdellipsoids in der Ebene", 1912; C. F. F. Karney, "Transverse Mercator
with an accuracy of a few nanometers", Journal of Geodesy 85 (2011), 475-485, equations 35 and 36, to the fourth order.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import InputError, require_kind
from skyverse.model.arrays import arcsinh, arctan2, exp, power, rows_of
from skyverse.model.frame import Origin
from skyverse.model.short_lines import told_point

SEMI_MAJOR_AXIS = 6378137.0
"""WGS84's radius at the equator, metres."""
FLATTENING = 1 / 298.257223563
ECCENTRICITY = math.sqrt(FLATTENING * (2 - FLATTENING))
LEAST_RADIUS = SEMI_MAJOR_AXIS * (1 - ECCENTRICITY**2)
"""The least radius of curvature of the ellipsoid, metres."""
FARTHEST = math.sin(math.radians(80.0))
"""The sine of the angle from the central meridian, at most: what is farther is on the map as if it were so far."""
MAX_METRES = 1e7
"""Metres along x and y from the origin up to which places can be told."""

_n = FLATTENING / (2 - FLATTENING)
_TO_MAP = (
    _n / 2 - 2 / 3 * _n**2 + 5 / 16 * _n**3 + 41 / 180 * _n**4,
    13 / 48 * _n**2 - 3 / 5 * _n**3 + 557 / 1440 * _n**4,
    61 / 240 * _n**3 - 103 / 140 * _n**4,
    49561 / 161280 * _n**4,
)
_FROM_MAP = (
    -_n / 2 + 2 / 3 * _n**2 - 37 / 96 * _n**3 + 1 / 360 * _n**4,
    -1 / 48 * _n**2 - 1 / 15 * _n**3 + 437 / 1440 * _n**4,
    -17 / 480 * _n**3 + 37 / 840 * _n**4,
    -4397 / 161280 * _n**4,
)
RECTIFYING_RADIUS = SEMI_MAJOR_AXIS / (1 + _n) * (1 + _n**2 / 4 + _n**4 / 64)
"""That of a sphere whose meridians are as long as the ellipsoid's, metres."""
_STEPS_TO_LATITUDE = 6  # each gains two digits or more


def to_local(origin: Origin, places: ArrayLike) -> Floats:
    """Return (n, 3) local east, north, up of (n, 3) latitude, longitude (degrees), altitude above mean sea level."""
    require_kind(origin, Origin, "origin")
    rows = rows_of(places, "places")
    middle, _ = _on_map(np.array([origin.latitude]), np.zeros(1))
    north, east = _on_map(rows[:, 0], rows[:, 1] - origin.longitude)
    return np.column_stack(
        [RECTIFYING_RADIUS * east, RECTIFYING_RADIUS * (north - middle), rows[:, 2] - origin.altitude]
    )


def to_wgs84(origin: Origin, points: ArrayLike) -> Floats:
    """Return (n, 3) latitude, longitude (degrees), altitude above mean sea level of (n, 3) local metres."""
    require_kind(origin, Origin, "origin")
    rows = rows_of(points, "points")
    if not (np.abs(rows[:, :2]) <= MAX_METRES).all():
        raise InputError(f"points: expected x and y within {MAX_METRES / 1000:,.0f} km of the origin")
    middle, _ = _on_map(np.array([origin.latitude]), np.zeros(1))
    east, north = rows[:, 0] / RECTIFYING_RADIUS, rows[:, 1] / RECTIFYING_RADIUS
    north, east = _series(_FROM_MAP, middle + north, east)
    grown = exp(east)
    aside, level = (grown - 1 / grown) / 2, np.cos(north)
    conformal = arctan2(np.sin(north), np.hypot(aside, level))
    latitude = conformal
    for _ in range(_STEPS_TO_LATITUDE):
        latitude = latitude + conformal - _conformal(latitude)
    longitude = origin.longitude + np.degrees(arctan2(aside, level))
    longitude = np.where(np.abs(longitude) <= 180, longitude, (longitude + 180) % 360 - 180)
    return np.column_stack([np.clip(np.degrees(latitude), -90, 90), longitude, rows[:, 2] + origin.altitude])


def told_globe(latitude: float, longitude: float) -> str:
    """Return a latitude and a longitude, degrees, to about 0.1 m: ``46.812345, 9.851234``."""
    return f"{latitude:.6f}, {longitude:.6f}"


def told_on_globe(origin: Origin | None, point: Sequence[float] | Floats) -> str:
    """Return the latitude and longitude of a point, (2,) or (3,) metres; ``""`` where nobody can tell them."""
    if origin is None or not np.abs(point[:2]).max() <= MAX_METRES:
        return ""
    return told_globe(*to_wgs84(origin, [(*point[:2], 0.0)])[0, :2].tolist())


def told_place(origin: Origin | None, point: Sequence[float] | Floats) -> str:
    """Return a point in words, metres beside latitude and longitude: ``46.812345, 9.851234 (-87.1, 212.9)``."""
    return f"{told_on_globe(origin, point)} {told_point(np.round(point, 1))}".lstrip()


def _on_map(latitude: Floats, longitude: Floats) -> tuple[Floats, Floats]:
    """Return north and east (n,) on the map, in rectifying radii, of degrees from the equator and central meridian."""
    conformal, turn = _conformal(np.radians(latitude)), np.radians(longitude)
    s, c = np.sin(conformal), np.cos(conformal)
    level, aside = c * np.cos(turn), np.clip(c * np.sin(turn), -FARTHEST, FARTHEST)
    return _series(_TO_MAP, arctan2(s, level), arcsinh(aside / np.sqrt(1 - aside * aside)))


def _conformal(latitude: Floats) -> Floats:
    """Return the latitudes on the sphere that the ellipsoid is mapped to with true directions, radians."""
    s = np.sin(latitude)
    stretch = power((1 + ECCENTRICITY * s) / (1 - ECCENTRICITY * s), ECCENTRICITY / 2)
    shift = (stretch - 1 / stretch) / 2
    return arctan2(s * np.sqrt(1 + shift * shift) - shift, np.cos(latitude))


def _series(coefficients: tuple[float, ...], north: Floats, east: Floats) -> tuple[Floats, Floats]:
    """Return the real and imaginary part of z + sum of c_j sin(2 j z), where z = north + i east."""
    grown = exp(2 * east)
    cosh, sinh = (grown + 1 / grown) / 2, (grown - 1 / grown) / 2
    s, c = np.sin(2 * north), np.cos(2 * north)
    sine, cosine = s * cosh + 1j * (c * sinh), c * cosh - 1j * (s * sinh)
    before, last = np.zeros_like(sine), np.zeros_like(sine)
    for coefficient in reversed(coefficients):  # Clenshaw's recurrence
        before, last = last, coefficient + 2 * cosine * last - before
    added = sine * last
    return north + added.real, east + added.imag
