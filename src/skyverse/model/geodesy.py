"""Conversion between WGS84 and local east-north-up metres, exact on the ellipsoid.

The local frame is a plane that touches the Earth at its origin, so that a place at the same altitude lies lower in the
frame the farther away it is: 8 cm at 1 km, and 2 m at 5 km.
"""

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.errors import require_kind
from skyverse.model.arrays import rows_of
from skyverse.model.elementary import arctan2
from skyverse.model.scenario import Origin

SEMI_MAJOR_AXIS = 6378137.0
"""WGS84's radius at the equator, metres."""
FLATTENING = 1 / 298.257223563
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)
"""The square of the first eccentricity."""


def to_local(origin: Origin, places: ArrayLike) -> Floats:
    """Return (n, 3) local east, north, up of (n, 3) latitude, longitude (degrees), altitude above mean sea level."""
    require_kind(origin, Origin, "origin")
    rows = rows_of(places, "places")
    geoid = origin.geoid or 0.0
    return np.einsum("ij,kj->ik", _geocentric(rows, geoid) - _geocentric(_place(origin), geoid), _axes(origin))


def to_wgs84(origin: Origin, points: ArrayLike) -> Floats:
    """Return (n, 3) latitude, longitude (degrees), altitude above mean sea level of (n, 3) local metres."""
    require_kind(origin, Origin, "origin")
    rows, geoid = rows_of(points, "points"), origin.geoid or 0.0
    return _geodetic(_geocentric(_place(origin), geoid) + np.einsum("ij,jk->ik", rows, _axes(origin)), geoid)


def _place(origin: Origin) -> Floats:
    return np.array([[origin.latitude, origin.longitude, origin.altitude]])


def _axes(origin: Origin) -> Floats:
    """Return the unit vectors east, north and up in geocentric axes, as rows."""
    latitude, longitude = np.radians([origin.latitude, origin.longitude])
    s, c, sl, cl = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    return np.array([[-sl, cl, 0.0], [-s * cl, -s * sl, c], [c * cl, c * sl, s]])


def _geocentric(places: Floats, geoid: float) -> Floats:
    """Return Earth-centred x, y, z (n, 3), metres, of latitudes, longitudes and altitudes (n, 3)."""
    latitude, longitude = np.radians(places[:, 0]), np.radians(places[:, 1])
    height = places[:, 2] + geoid
    across = SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2)
    flat = (across + height) * np.cos(latitude)
    up = (across * (1 - ECCENTRICITY_SQUARED) + height) * np.sin(latitude)
    return np.column_stack([flat * np.cos(longitude), flat * np.sin(longitude), up])


def _geodetic(points: Floats, geoid: float) -> Floats:
    """Return latitudes, longitudes and altitudes (n, 3) of Earth-centred x, y, z (n, 3), metres."""
    x, y, z = points.T
    flat = np.hypot(x, y)
    raised, level = z, flat * (1 - ECCENTRICITY_SQUARED)  # the latitude is the angle of these two
    for _ in range(7):  # each iteration gains at least two digits
        size = np.hypot(raised, level)
        s, c = raised / size, level / size
        across = SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * s**2)
        raised, level = z + ECCENTRICITY_SQUARED * across * s, flat
    height = flat * c + z * s - SEMI_MAJOR_AXIS * np.sqrt(1 - ECCENTRICITY_SQUARED * s**2)
    return np.column_stack([np.degrees(arctan2(raised, level)), np.degrees(arctan2(y, x)), height - geoid])
