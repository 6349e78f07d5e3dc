"""Local metres as an autopilot takes them: latitude, longitude, and an altitude that knows what it is counted from."""

from typing import Literal, NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.scenario import Frame, Origin, Scenario

AltitudeReference = Literal["amsl", "home", "agl"]
ALTITUDE_TYPES: dict[AltitudeReference, type[Altitude]] = {"amsl": AboveSea, "home": AboveHome, "agl": AboveGround}


class GlobalPositions(NamedTuple):
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


GEOID_REACH = 0.2
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
            if max(abs(turn), abs(origin.latitude - known.latitude)) <= GEOID_REACH:
                origin = origin.model_copy(update={"geoid": known.geoid})
        return scenario.model_copy(update={"frame": Frame(origin=origin)})
    if scenario.frame.origin is None:
        raise InputError(
            f"{what}: expected a scenario that says where its zero lies (frame.origin in its file), found none in "
            f"{scenario.name!r}",
            give=[Remedy("origin")],
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
            "mean sea level lies above that (frame.origin.geoid in its file, 52 in Davos)",
            give=[Remedy("Origin.geoid")],
        )
    return geoid


def require_reference(scenario: Scenario, reference: str, allowed: tuple[AltitudeReference, ...], what: str) -> None:
    """Refuse altitudes that a format does not know, or that need a terrain where there is none."""
    if reference not in allowed:
        raise InputError(f"{what}: expected altitudes as {' or '.join(allowed)}, found {reference!r}")
    if reference == "agl" and scenario.terrain is None:
        raise InputError(
            f"{what}: altitudes above ground (agl) need a terrain, and scenario {scenario.name!r} has none"
        )


def global_positions(scenario: Scenario, uav: int, points: Floats, reference: AltitudeReference) -> GlobalPositions:
    """Return (n, 3) local metres of a UAV as global_positions."""
    origin = origin_of(scenario)
    latitude, longitude, sea = to_wgs84(origin, points).T
    if reference == "home":
        altitude = sea - to_wgs84(origin, home(scenario, uav))[0, 2]
    elif reference == "agl":
        assert scenario.terrain is not None
        below = points.copy()
        below[:, 2] = scenario.terrain.height(points[:, :2])
        altitude = sea - to_wgs84(origin, below)[:, 2]
    else:
        altitude = sea
    return GlobalPositions(latitude, longitude, altitude, sea, ALTITUDE_TYPES[reference])


def home(scenario: Scenario, uav: int) -> Floats:
    """Return where a UAV takes off, (3,) metres, straight below its start.

    On the real ground, where the scenario has it; else on the terrain; else at the start itself.
    """
    at = np.array(scenario.uavs[uav].start)
    real = scenario.uavs[uav].home
    if real is not None:
        at[2] = real
    elif scenario.terrain is not None:
        at[2] = scenario.terrain.height(at[:2])
    return at
