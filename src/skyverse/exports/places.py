"""Local metres as an autopilot takes them: latitude, longitude, and an altitude that knows what it is counted from."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.errors import InputError
from skyverse.geodesy import to_wgs84
from skyverse.result import Mission
from skyverse.scenario import Frame, Origin, Scenario
from skyverse.shapes import Terrain

Floats = NDArray[np.float64]
Above = Literal["amsl", "home", "ground"]
KINDS: dict[Above, type[Altitude]] = {"amsl": AboveSea, "home": AboveHome, "ground": AboveGround}


class Places(NamedTuple):
    """Where the points of one UAV are on the globe.

    Attributes
    ----------
    latitude, longitude
        (n,) WGS84 degrees.
    altitude
        (n,) metres, above what `kind` says.
    sea
        (n,) metres above mean sea level, whatever `kind` says.
    kind
        What altitudes are counted from.
    """

    latitude: Floats
    longitude: Floats
    altitude: Floats
    sea: Floats
    kind: type[Altitude]


NEAR = 0.2
"""Degrees within which a known geoid holds for another origin, to half a metre or so."""


def with_origin(mission: Mission, origin: Origin | None, what: str) -> Scenario:
    """Return the mission's scenario with an origin, or refuse to write `what` without one.

    What is made of maps stays where it is. Of others a known geoid is kept where the new origin is near the old one and
    does not say its own.
    """
    scenario = mission.scenario
    if origin is not None:
        known = scenario.frame.origin
        moved = known is not None and origin.model_copy(update={"geoid": known.geoid}) != known
        if known is not None and moved and (scenario.terrain is not None or scenario.sources):
            raise InputError(
                f"{what}: {scenario.name!r} is made of maps and lies at latitude {known.latitude:g}, longitude "
                f"{known.longitude:g}, {known.altitude:g} m above the sea; found another origin, latitude "
                f"{origin.latitude:g}, longitude {origin.longitude:g}, {origin.altitude:g} m"
            )
        if origin.geoid is None and known is not None:
            turn = (origin.longitude - known.longitude + 180) % 360 - 180
            if max(abs(turn), abs(origin.latitude - known.latitude)) <= NEAR:
                origin = origin.model_copy(update={"geoid": known.geoid})
        return scenario.model_copy(update={"frame": Frame(origin=origin)})
    if scenario.frame.origin is None:
        raise InputError(
            f"{what}: expected a scenario that says where its zero lies, found none in {scenario.name!r}; give "
            "frame.origin (latitude, longitude, altitude) in its file, or --origin latitude,longitude,altitude"
        )
    return scenario


def origin_of(scenario: Scenario) -> Origin:
    """Return where the zero lies, once `with_origin` has seen to it."""
    assert scenario.frame.origin is not None
    return scenario.frame.origin


def geoid_of(scenario: Scenario, what: str) -> float:
    """Return how far mean sea level lies above the ellipsoid, or refuse to write `what` where it is not known."""
    geoid = origin_of(scenario).geoid
    if geoid is None:
        raise InputError(
            f"{what}: its heights are above the WGS84 ellipsoid, and scenario {scenario.name!r} does not say how far "
            "mean sea level lies above that; give --geoid METRES (52 in Davos), or frame.origin.geoid in its file"
        )
    return geoid


def require_kind(scenario: Scenario, above: str, allowed: tuple[Above, ...], what: str) -> None:
    """Refuse altitudes that a format does not know, or that need a terrain where there is none."""
    if above not in allowed:
        raise InputError(f"{what}: expected altitudes above {' or '.join(allowed)}, found {above!r}")
    if above == "ground" and scenario.terrain is None:
        raise InputError(f"{what}: altitudes above ground need a terrain, and scenario {scenario.name!r} has none")


def places(scenario: Scenario, uav: int, points: Floats, above: Above) -> Places:
    """Return (n, 3) local metres of a UAV as places."""
    origin = origin_of(scenario)
    latitude, longitude, sea = to_wgs84(origin, points).T
    if above == "home":
        altitude = sea - to_wgs84(origin, home(scenario, uav))[0, 2]
    elif above == "ground":
        assert scenario.terrain is not None
        below = points.copy()
        below[:, 2] = ground(scenario.terrain, points[:, :2])
        altitude = sea - to_wgs84(origin, below)[:, 2]
    else:
        altitude = sea
    return Places(latitude, longitude, altitude, sea, KINDS[above])


def home(scenario: Scenario, uav: int) -> Floats:
    """Return where a UAV takes off, (3,) metres: on the ground below its start, or at it where there is no terrain."""
    at = np.array(scenario.uavs[uav].start)
    if scenario.terrain is not None:
        at[2] = ground(scenario.terrain, at[None, :2])[0]
    return at


def ground(terrain: Terrain, at: Floats) -> Floats:
    """Return z of the ground at (n, 2) x, y, metres: bilinear, and level beyond the grid."""
    shape = np.array(terrain.heights.shape)
    cells = np.clip((at - np.array(terrain.origin)) / np.array(terrain.step), 0, shape - 1)
    i, j = np.minimum(cells.astype(np.intp), shape - 2).T
    u, v = (cells - np.column_stack([i, j])).T
    h = terrain.heights
    low = h[i, j] * (1 - u) + h[i + 1, j] * u
    high = h[i, j + 1] * (1 - u) + h[i + 1, j + 1] * u
    z: Floats = low * (1 - v) + high * v
    return z
