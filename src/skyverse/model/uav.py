"""The vehicles: where a UAV starts, and its limits; limits that are given to all UAVs of a fleet at once."""

import math
from dataclasses import fields, replace
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError, model_validator

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.model.power import JOULES_OF_WATT_HOUR, TRUSTED_SHARE, Power, aeroplane_curve, multirotor_curve
from skyverse.model.quantities import Amount, Limit, Model, NonNegative, Number, Point, Positive, Whole, listed
from skyverse.model.vehicle_profiles import FleetLimits, energy_or_minutes, with_profile
from skyverse.model.wrong_values import complaint

GRAVITY = 9.81
"""Metres per second squared."""


class FixedWing(Model):
    """The limits of an aeroplane, which cannot hover: it keeps its horizontal speed, and turns and climbs gently.

    Attributes
    ----------
    speed
        Its horizontal speed, m/s.
    turn_radius
        The radius of its tightest turn seen from above, metres.
    climb
        The steepest climb or descent, degrees.
    max_wind
        The strongest wind, m/s, gusts included, in which it holds that speed over ground by flying faster or slower
        through the air. If it is left out, its airspeed may rise to the UAV's largest.
    """

    speed: Limit
    turn_radius: Limit
    climb: Annotated[Positive, Field(lt=90)]
    max_wind: NonNegative | None = None


class TrackingError(Model):
    """How far a UAV may stray from its nominal position: wind, gusts and the errors of GPS and barometer together.

    The position that is flown stays within `horizontal` metres of the nominal one seen from above, and within
    `vertical` metres of it in altitude.
    """

    horizontal: NonNegative = 0.0
    vertical: NonNegative = 0.0


PowerPoints = Annotated[tuple[tuple[Amount, Limit], ...], BeforeValidator(listed), Field(min_length=1, max_length=1000)]
"""Airspeeds, m/s, and the electrical powers, W, that level flight takes at them."""


class UAV(Model):
    """One vehicle: where it starts, its limits, and its separation from others.

    Attributes
    ----------
    name
        Unique in its scenario; ``uav-1``, ``uav-2`` and so on if it is left out.
    start
        x, y, z in metres.
    home
        z of the real ground below `start`, metres, where the UAV stands before it takes off, and from where autopilots
        count heights above home. If it is left out, it is the terrain below, or the start where there is no terrain.
    end
        Where it ends: ``"target"``, at its last target, or ``"home"``, where it started.
    capacity
        The targets' demands that it can carry at once, kg; ``None`` where that is not limited. Its power is that with
        all of it on board.
    max_speed, max_acceleration, max_jerk
        Limits on the norm of velocity (m/s), of acceleration (m/s^2) and of its rate of change (m/s^3).
    max_airspeed
        The fastest that it flies through the air, m/s, which is what counts in a wind; `max_speed`, which is over
        ground, if it is left out.
    max_climb, max_descent
        The fastest that it climbs and descends, m/s; ``None`` where it has no such limit of its own.
    max_yaw_rate, max_yaw_acceleration
        Limits on how fast a UAV turns about the vertical, degrees/s, and on the rate of change of that, degrees/s^2.
    look_at
        x, y, z in metres at which a multirotor points its nose and camera.
    heading
        The direction in which a multirotor points its nose, degrees clockwise from north, which is y. Its nose points
        along its course if both are left out.
    max_tilt
        The largest angle between a multirotor's thrust and the vertical, degrees.
    thrust_to_weight
        The largest thrust of a multirotor, as a multiple of its weight; above 1, or else it cannot hover.
    separation
        The distance that other UAVs at its height must keep, metres; of two UAVs the larger one counts.
    vertical_separation
        The vertical distance that UAVs above and below it must keep because of its downwash, metres; twice `separation`
        if it is left out. In all other directions an ellipsoid with these semi-axes must be kept free.
    hover_power
        The electrical power, W, at which a multirotor hovers without payload, and from which the energy of its flights
        is estimated; ``None`` where it is not known.
    power
        Points of a data sheet, airspeed (m/s) and power (W), such as those of the longest and of the farthest flight.
        Momentum theory and drag say what is between them; see `Power`. A multirotor has `hover_power` besides, an
        aeroplane two points or more.
    power_curve
        Measured points instead, airspeed and power, in rising order, with straight lines between them.
    mass, payload
        Kilograms with battery and without payload, and of the payload. Where the mass is not known, climbs are free.
    battery
        Nominal energy of its battery, Wh; ``None`` where flights are not limited by it.
    reserve
        Share of the battery that must be left at landing.
    batteries
        How many it may use, one for each sortie; ``None`` for as many as it takes.
    swap
        Seconds that changing one takes.
    tracking_error
        How far it may stray from its nominal position; it keeps to it exactly if this is left out.
    priority
        Of two UAVs in conflict, the one of lower priority gives way.
    fixed_wing
        Given for an aeroplane, whose tilt and thrust are not limited, and which does not rest at its start and target.
    vehicle
        The name of a vehicle profile, which gives the fields that are left out; empty for none. A field that is given
        as ``None`` is not left out.
    """

    name: str = ""
    start: Point
    home: Number | None = None
    end: Literal["target", "home"] = "target"
    capacity: Limit | None = None
    max_speed: Limit = 5.0
    max_acceleration: Limit = 3.5
    max_jerk: Limit = 50.0
    max_airspeed: Limit | None = None
    max_climb: Limit | None = None
    max_descent: Limit | None = None
    max_yaw_rate: Limit = 60.0
    max_yaw_acceleration: Limit = 120.0
    look_at: Point | None = None
    heading: Annotated[Number, Field(ge=0, le=360)] | None = None
    max_tilt: Annotated[Number, Field(ge=0.1, lt=90)] = 40.0
    thrust_to_weight: Annotated[Number, Field(gt=1, le=1e6)] = 2.5
    separation: NonNegative = 0.5
    vertical_separation: NonNegative | None = None
    hover_power: Limit | None = None
    power: PowerPoints | None = None
    power_curve: PowerPoints | None = None
    mass: Limit | None = None
    payload: Annotated[NonNegative, Field(le=1e6)] = 0.0
    battery: Limit | None = None
    reserve: Annotated[Number, Field(ge=0, lt=TRUSTED_SHARE)] = 0.2
    batteries: Annotated[Whole, Field(ge=1)] | None = None
    swap: Annotated[NonNegative, Field(le=1e6)] = 120.0
    tracking_error: TrackingError = TrackingError()
    priority: Whole = 0
    fixed_wing: FixedWing | None = None
    vehicle: str = ""

    @property
    def ellipsoid(self) -> tuple[float, float]:
        """The horizontal and the vertical semi-axis of the ellipsoid that others must stay out of, metres."""
        vertical = 2.0 * self.separation if self.vertical_separation is None else self.vertical_separation
        return self.separation, vertical

    @property
    def usable_energy(self) -> float | None:
        """Joules that one battery gives, without the reserve and what is not trusted; ``None`` without a battery."""
        return None if self.battery is None else self.battery * (TRUSTED_SHARE - self.reserve) * JOULES_OF_WATT_HOUR

    @property
    def power_model(self) -> Power | None:
        """Its electrical power as a function of airspeed, climb and load; ``None`` where no power is known."""
        wings, mass = self.fixed_wing is not None, self.mass or 0.0
        laden = 1.0 + ((self.payload + (self.capacity or 0.0)) / mass if mass else 0.0)
        power = Power(weight=mass * GRAVITY, laden=laden, wings=wings)
        if self.power_curve is not None:
            hover = () if self.hover_power is None or wings else ((0.0, self.hover_power),)
            return replace(power, points=(*hover, *self.power_curve))
        if wings:
            drag, lift = (0.0, 0.0) if self.power is None else aeroplane_curve(self.power)
            return None if self.power is None else replace(power, drag=drag, lift=lift)
        if self.hover_power is None:
            return None
        induced, drag = (0.0, 0.0) if self.power is None else multirotor_curve(self.hover_power, self.power)
        return replace(power, hover=self.hover_power, induced=induced, drag=drag)

    @property
    def airspeed(self) -> float:
        """The fastest that it flies through the air, m/s."""
        return self.max_speed if self.max_airspeed is None else self.max_airspeed

    @property
    def max_wind(self) -> float:
        """The strongest wind in which it can fly at all, m/s: hold its place, or an aeroplane its speed."""
        wing = self.fixed_wing
        if wing is None:
            return self.airspeed
        fastest = wing.speed / math.cos(math.radians(wing.climb))
        return max(self.airspeed - fastest, 0.0) if wing.max_wind is None else wing.max_wind

    @model_validator(mode="before")
    @classmethod
    def _of_its_vehicle(cls, data: Any) -> Any:
        return with_profile(data)

    @model_validator(mode="after")
    def _within_limits(self) -> Self:
        if self.home is not None and self.home > self.start[2]:
            raise ValueError(f"home, at {self.home:g} m, must not be above the start, at {self.start[2]:g} m")
        if (self.separation == 0) != (self.ellipsoid[1] == 0):
            raise ValueError(
                "separation and vertical_separation must both be above 0, or both 0, but they are "
                f"{self.separation:g} and {self.ellipsoid[1]:g}"
            )
        self._require_sound_power()
        if self.look_at is not None and self.heading is not None:
            raise ValueError("look_at and heading both say where the nose points: give one of them")
        wing = self.fixed_wing
        if wing is None:
            return self
        for name in ("look_at", "heading"):
            if getattr(self, name) is not None:
                raise ValueError(f"{name} is for multirotors: an aeroplane flies where its nose points")
        fastest = wing.speed / math.cos(math.radians(wing.climb))
        if fastest > self.max_speed:
            raise ValueError(
                f"fixed_wing.speed of {wing.speed:g} m/s at a climb of {wing.climb:g} degrees is {fastest:.4g} m/s, "
                f"above max_speed, {self.max_speed:g}"
            )
        rising = wing.speed * math.tan(math.radians(wing.climb))
        for name, limit in (("max_climb", self.max_climb), ("max_descent", self.max_descent)):
            if limit is not None and rising > limit:
                raise ValueError(
                    f"fixed_wing.climb of {wing.climb:g} degrees at {wing.speed:g} m/s is {rising:.4g} m/s, "
                    f"above {name}, {limit:g}"
                )
        turning = wing.speed**2 / wing.turn_radius
        if turning >= self.max_acceleration:
            raise ValueError(
                f"fixed_wing.turn_radius of {wing.turn_radius:g} m at {wing.speed:g} m/s takes {turning:.4g} m/s^2, "
                f"not below max_acceleration, {self.max_acceleration:g}"
            )
        return self

    def _require_sound_power(self) -> None:
        if self.power is not None and self.power_curve is not None:
            raise ValueError("power and power_curve both say what level flight takes: give one of them")
        if self.power is not None and self.fixed_wing is None and self.hover_power is None:
            raise ValueError("power needs hover_power beside it, the power of a multirotor at an airspeed of 0")
        power = self.power_model
        speeds = [speed for speed, _ in power.points] if power is not None else []
        if any(one >= other for one, other in pairwise(speeds)):
            raise ValueError(
                f"power_curve must rise in airspeed, from hover_power at 0 if that is given, found {speeds}"
            )
        if speeds and speeds[0] > 0 and self.fixed_wing is None:
            raise ValueError(
                f"power_curve must begin at 0 m/s, or hover_power be given, but it begins at {speeds[0]:g}"
            )
        if self.capacity is not None and self.battery is not None and self.mass is None:
            raise ValueError("capacity needs mass beside a battery, that of the UAV without what it carries")
        if self.payload > 0 and self.mass is None:
            raise ValueError("payload needs mass beside it, that of the UAV without payload")
        if self.battery is not None and (power is None or self.mass is None):
            points = "two points of power" if self.fixed_wing is not None else "hover_power"
            raise ValueError(
                f"battery needs mass and {points}, or power_curve, beside it: how long it lasts is not known without"
            )


def kept_ellipsoid(one: UAV, other: UAV) -> tuple[float, float]:
    """Return the semi-axes of the ellipsoid that two UAVs must keep out of, horizontal and vertical, metres."""
    xy, z = (np.array([max(pair)]) for pair in zip(one.ellipsoid, other.ellipsoid, strict=True))
    errors = one.tracking_error, other.tracking_error
    aside, up = sum(error.horizontal for error in errors), sum(error.vertical for error in errors)
    factor = 1.0 + strayed_share(xy, z, np.array([aside]), np.array([up]))
    return float((xy * factor)[0]), float((z * factor)[0])


def strayed_share(xy: Floats, z: Floats, aside: Floats, up: Floats) -> Floats:
    """Return by what share of itself an ellipsoid has to grow to hold what comes within an error of it.

    The error is an upright cylinder, which lies in an ellipsoid of the same shape through its rim. Two ellipsoids of
    one shape add up to a third of that shape.

    Parameters
    ----------
    xy, z
        Semi-axes of the ellipsoids, metres.
    aside, up
        The radius and half the height of the cylinder, metres.
    """
    rim = (np.divide(reach, axis, np.zeros_like(axis), where=axis > 0) for reach, axis in ((aside, xy), (up, z)))
    return np.hypot(*rim)


_NOT_OF_A_VEHICLE = (
    *("name", "start", "home", "end", "look_at", "heading", "priority"),
    *("payload", "reserve", "batteries", "swap"),
)
"""The fields of a UAV that do not depend on its vehicle."""


def _energy(uav: UAV, limits: FleetLimits, amount: float, minutes: bool) -> float:
    """Return the energy, Wh, of a battery that gives so many Wh, or minutes at the power of a UAV with limits."""
    if not minutes:
        return amount
    limited = with_limits(uav, replace(limits, battery=None))
    if limited.power_model is None:
        known = [Remedy("vehicle", "camera"), Remedy("battery", "'77 Wh'")]
        raise InputError("the power of the vehicle is not known", field="battery", give=known)
    speed = np.array([0.0 if limited.fixed_wing is None else limited.fixed_wing.speed])
    return float(limited.power_model.at(speed, np.zeros(1), np.ones(1))[0]) * amount / 60.0


def with_limits(uav: UAV, limits: FleetLimits) -> UAV:
    """Return a UAV with limits of its fleet, or raise `InputError` that names the limit."""
    given: dict[str, Any] = {
        field.name: getattr(limits, field.name)
        for field in fields(FleetLimits)
        if getattr(limits, field.name) is not None
    }
    if not given:
        return uav
    if isinstance(limits.battery, str):
        given["battery"] = _energy(uav, limits, *energy_or_minutes(limits.battery))
    if limits.tracking_error is not None:
        given["tracking_error"] = dict(zip(("horizontal", "vertical"), limits.tracking_error, strict=True))
    kept = tuple(UAV.model_fields) if limits.vehicle is None else _NOT_OF_A_VEHICLE
    own = {name: getattr(uav, name) for name in kept}
    if limits.separation is not None and limits.vehicle is None:
        own["vertical_separation"] = None  # twice the new one
    try:
        return UAV.model_validate(own | given)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = str(first["loc"][0]) if first["loc"] else ""
        raise InputError(f"{uav.name}: {complaint(first)}", field=place or None) from None
