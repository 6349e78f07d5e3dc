"""Limits that are given to all UAVs of a fleet at once."""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from skyverse.errors import InputError, shown
from skyverse.model.vehicle_profiles import VEHICLE_PROFILES
from skyverse.model.wrong_values import complaint

if TYPE_CHECKING:
    from skyverse.model.uav import UAV


_NOT_OF_A_VEHICLE = ("name", "start", "home", "priority")
"""The fields of a UAV that do not depend on its vehicle."""


@dataclass(frozen=True, kw_only=True)
class FleetLimits:
    """Limits of all UAVs; what is left out stays as it is.

    Attributes
    ----------
    vehicle
        The profile of all UAVs, which sets all their limits and their tracking error: indoor, thesis, camera, heavy or
        mapping.
    max_speed
        The fastest that UAVs fly, m/s.
    max_climb
        The fastest that they climb, m/s.
    max_descent
        The fastest that they descend, m/s.
    separation
        The distance that UAVs at one height keep from each other, metres; above and below, the vehicle's own, or twice
        as much.
    tracking_error
        How far they may stray from their nominal positions: metres seen from above, and metres in altitude.
    """

    vehicle: str | None = None
    max_speed: float | None = None
    max_climb: float | None = None
    max_descent: float | None = None
    separation: float | None = None
    tracking_error: tuple[float, float] | None = None

    def limit(self, uav: "UAV") -> "UAV":
        """Return a UAV with these limits, or raise `InputError` that names the limit."""
        from pydantic import ValidationError

        from skyverse.model.uav import UAV

        given: dict[str, Any] = {
            field.name: getattr(self, field.name)
            for field in fields(FleetLimits)
            if getattr(self, field.name) is not None
        }
        if not given:
            return uav
        if self.tracking_error is not None:
            given["tracking_error"] = dict(zip(("horizontal", "vertical"), self.tracking_error, strict=True))
        if self.vehicle is not None and self.vehicle not in VEHICLE_PROFILES:
            raise InputError(
                f"expected one of {', '.join(VEHICLE_PROFILES)}, found {self.vehicle!r:.40}", field="vehicle"
            )
        kept = tuple(UAV.model_fields) if self.vehicle is None else _NOT_OF_A_VEHICLE
        own = {name: getattr(uav, name) for name in kept}
        if self.separation is not None and self.vehicle is None:
            own["vertical_separation"] = None  # twice the new one
        try:
            return UAV.model_validate(own | given)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            found = "" if isinstance(first["input"], dict) else f", found {shown(first['input'])}"
            place = str(first["loc"][0]) if first["loc"] else ""
            raise InputError(f"{uav.name}: {complaint(first)}{found}", field=place or None) from None
