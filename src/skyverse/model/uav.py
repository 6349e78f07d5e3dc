"""The vehicles: what a UAV can do."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from skyverse.model.quantities import Limit, Model, NonNegative, Number, Point, Positive


class FixedWing(Model):
    """What an aeroplane can do that cannot hover: it flies on, level speed held, and turns and climbs gently.

    Attributes
    ----------
    speed
        Its horizontal speed, m/s.
    turn_radius
        Of its tightest turn seen from above, metres.
    climb
        The steepest climb or descent, degrees.
    """

    speed: Limit
    turn_radius: Limit
    climb: Annotated[Positive, Field(lt=90)]


class UAV(Model):
    """One vehicle: where it starts and what it can do.

    Attributes
    ----------
    name
        Unique in its scenario; ``uav-1``, ``uav-2`` ... when left out.
    start
        Metres.
    home
        z of the real ground below `start`, metres, where it stands before it takes off, and from where autopilots count
        heights above home. When left out it is the terrain below, or the start itself where there is no terrain.
    max_speed, max_acceleration, max_jerk
        Limits on the norm of velocity (m/s), of acceleration (m/s^2) and of its rate of change (m/s^3).
    max_tilt
        Of a multirotor: degrees between its thrust and the vertical.
    thrust_to_weight
        Of a multirotor: the most thrust, as a multiple of its weight; above 1, or it cannot hover.
    separation
        The horizontal distance in metres that other UAVs at its height must keep; of two UAVs the larger counts.
    vertical_separation
        The vertical distance that those above and below must keep, metres, because of its downwash; twice `separation`
        when left out. Between the two an ellipsoid is kept free.
    priority
        Of two UAVs in conflict the one of lower priority gives way.
    fixed_wing
        Given for an aeroplane; then tilt and thrust are not limited, nor is it at rest at its start and target.
    """

    name: str = ""
    start: Point
    home: Number | None = None
    max_speed: Limit = 5.0
    max_acceleration: Limit = 3.5
    max_jerk: Limit = 50.0
    max_tilt: Annotated[Number, Field(ge=0.1, lt=90)] = 40.0
    thrust_to_weight: Annotated[Number, Field(gt=1, le=1e6)] = 2.5
    separation: NonNegative = 0.5
    vertical_separation: NonNegative | None = None
    priority: Annotated[int, Field(strict=True)] = 0
    fixed_wing: FixedWing | None = None

    @property
    def ellipsoid(self) -> tuple[float, float]:
        """Horizontal and vertical semi-axis of what it keeps free of others, metres."""
        vertical = 2.0 * self.separation if self.vertical_separation is None else self.vertical_separation
        return self.separation, vertical

    @model_validator(mode="after")
    def _within_limits(self) -> Self:
        if self.home is not None and self.home > self.start[2]:
            raise ValueError(f"home, at {self.home:g} m, must not be above the start, at {self.start[2]:g} m")
        if (self.separation == 0) != (self.ellipsoid[1] == 0):
            raise ValueError(
                "separation and vertical_separation must both be above 0, or both 0, but they are "
                f"{self.separation:g} and {self.ellipsoid[1]:g}"
            )
        wing = self.fixed_wing
        if wing is None:
            return self
        fastest = wing.speed / math.cos(math.radians(wing.climb))
        if fastest > self.max_speed:
            raise ValueError(
                f"fixed_wing.speed of {wing.speed:g} m/s at a climb of {wing.climb:g} degrees is {fastest:.4g} m/s, "
                f"above max_speed, {self.max_speed:g}"
            )
        turning = wing.speed**2 / wing.turn_radius
        if turning >= self.max_acceleration:
            raise ValueError(
                f"fixed_wing.turn_radius of {wing.turn_radius:g} m at {wing.speed:g} m/s takes {turning:.4g} m/s^2, "
                f"not below max_acceleration, {self.max_acceleration:g}"
            )
        return self
