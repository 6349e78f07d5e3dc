"""Local metres converted to latitude, longitude and altitude above one of three references."""

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy, require_kind
from skyverse.model.altitude import AboveGround, AboveHome, AboveSea, Altitude
from skyverse.model.frame import Frame, Origin, require_true_lengths
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission
from skyverse.model.pad import home_height
from skyverse.model.scenario import Scenario

AltitudeReference = Literal["amsl", "home", "agl"]
ALTITUDE_TYPES: dict[AltitudeReference, type[Altitude]] = {"amsl": AboveSea, "home": AboveHome, "agl": AboveGround}


class GlobalPositions(NamedTuple):
    """Where the points of one UAV are on the globe.

    Attributes
    ----------
    latitude, longitude
        (n,) WGS84 degrees.
    altitude
        (n,) metres above the reference that `kind` names.
    sea
        (n,) metres above mean sea level.
    kind
        The reference of `altitude`.
    """

    latitude: Floats
    longitude: Floats
    altitude: Floats
    sea: Floats
    kind: type[Altitude]

    @property
    def rows(self) -> list[tuple[float, float, float]]:
        """Latitude, longitude and altitude of each point."""
        return list(zip(self.latitude.tolist(), self.longitude.tolist(), self.altitude.tolist(), strict=True))


GEOID_REACH = 0.2
"""Degrees: an origin this near to another has the same geoid height, to about half a metre."""


def with_origin(mission: Mission, origin: Origin | None, what: str) -> Scenario:
    """Return the mission's scenario with an origin; raise `InputError` if there is none.

    A scenario that is made of maps cannot be moved. If the new origin has no geoid height and is near the scenario's
    own, it keeps the latter's. `what` names the output in messages.
    """
    scenario = mission.scenario
    if origin is not None:
        require_kind(origin, Origin, "origin")
        require_true_lengths(scenario.bounds.min, scenario.bounds.max, f"{what}: bounds")
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
    """Return the origin of a scenario from `with_origin`, which has one."""
    assert scenario.frame.origin is not None
    return scenario.frame.origin


def geoid_of(scenario: Scenario, what: str) -> float:
    """Return how far mean sea level lies above the ellipsoid, metres; raise `InputError` where it is not known."""
    geoid = origin_of(scenario).geoid
    if geoid is None:
        raise InputError(
            f"{what}: its heights are above the WGS84 ellipsoid, and scenario {scenario.name!r} does not say how far "
            "mean sea level lies above that (frame.origin.geoid in its file, 52 in Davos)",
            give=[Remedy("Origin.geoid")],
        )
    return geoid


def require_reference(scenario: Scenario, reference: str, allowed: tuple[AltitudeReference, ...], what: str) -> None:
    """Raise `InputError` if the format does not support the reference, or it needs a terrain and there is none."""
    if reference not in allowed:
        raise InputError(f"{what}: expected altitudes as {' or '.join(allowed)}, found {reference!r}")
    if reference == "agl" and scenario.terrain is None:
        raise InputError(
            f"{what}: altitudes above ground (agl) need a terrain, and scenario {scenario.name!r} has none"
        )


def global_positions(
    scenario: Scenario, uav: int, points: Floats, reference: AltitudeReference, place: Floats | None = None
) -> GlobalPositions:
    """Return the global positions of a UAV's `points`, (n, 3) local metres.

    Altitudes above home are counted from `place`, (3,) metres, where that is given.
    """
    origin = origin_of(scenario)
    latitude, longitude, sea = to_wgs84(origin, points).T
    if reference == "home":
        altitude = points[:, 2] - (home(scenario, uav) if place is None else place)[2]
    elif reference == "agl":
        assert scenario.terrain is not None
        altitude = points[:, 2] - scenario.terrain.height(points[:, :2])
    else:
        altitude = sea
    altitude = np.round(altitude, 4) + 0.0  # files never say -0.0
    return GlobalPositions(latitude, longitude, altitude, sea, ALTITUDE_TYPES[reference])


def home(scenario: Scenario, uav: int) -> Floats:
    """Return the place below its start at which a UAV takes off, (3,) metres.

    See `home_height`.
    """
    return np.array([*scenario.uavs[uav].start[:2], home_height(scenario, uav)])


def home_on_globe(scenario: Scenario, uav: int) -> tuple[float, float, float]:
    """Return latitude, longitude and altitude above mean sea level of the place at which a UAV takes off."""
    return global_positions(scenario, uav, home(scenario, uav)[None], "amsl").rows[0]


def targets_on_globe(
    scenario: Scenario, reference: AltitudeReference
) -> Iterator[tuple[str, tuple[float, float, float]]]:
    """Yield the name of each target, and its latitude, longitude and altitude."""
    for target in scenario.targets:
        yield target.name, global_positions(scenario, 0, np.array([target.position]), reference).rows[0]
