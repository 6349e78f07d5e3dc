"""What positions mean: a map about an origin, and altitude."""

from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, model_validator

from skyverse.errors import InputError, require_number
from skyverse.model.quantities import Model, Number

MAX_GEOID = 150.0
"""Metres: mean sea level is nowhere farther above or below the ellipsoid; it reaches from -107 to 85."""


def require_geoid(metres: float) -> None:
    """Raise `InputError` for a height of mean sea level above the ellipsoid that is nowhere on Earth."""
    require_number(metres, "geoid", "metres", -MAX_GEOID, MAX_GEOID)


class Origin(Model):
    """Where the zero of the local frame lies.

    Attributes
    ----------
    latitude, longitude
        WGS84 degrees.
    altitude
        Metres above mean sea level.
    geoid
        How far mean sea level lies above the WGS84 ellipsoid there, metres. If it is not known, heights above the
        ellipsoid cannot be written.
    """

    latitude: Annotated[Number, Field(ge=-90, le=90)]
    longitude: Annotated[Number, Field(ge=-180, le=180)]
    altitude: Number
    geoid: Annotated[Number, Field(ge=-MAX_GEOID, le=MAX_GEOID)] | None = None


class Frame(Model):
    """What positions mean: metres east and north on a map about `origin`, where that is known, and altitude above it.

    The map is the transverse Mercator projection of WGS84 whose central meridian goes through the origin; lengths are
    true at the origin, to 1e-4 within 90 km. See `skyverse.to_local`.
    """

    axes: Literal["map"] = "map"
    origin: Origin | None = None

    @model_validator(mode="before")
    @classmethod
    def _refuse_a_tangent_plane(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict):
            return data
        if data.get("axes") == "enu" and data.get("origin") is None:
            return {key: value for key, value in data.items() if key != "axes"}
        in_a_file = "folder" in (info.context or {})
        if data.get("axes") == "enu" or (in_a_file and data.get("origin") is not None and "axes" not in data):
            found = "found 'enu'" if "axes" in data else "but it is missing, which meant 'enu'"
            raise ValueError(
                f"axes: expected 'map' beside an origin, {found}, a plane that touches the Earth there, as in older "
                "files; build the scenario anew, with the options in its built_with, or write 'map' if its places are "
                "those of a map"
            )
        return data


MAX_FAR = 90_000.0
"""Metres along x and y from a map's origin; farther east or west, its lengths are too long by more than 1e-4."""


def require_true_lengths(low: Iterable[float], high: Iterable[float], where: str) -> None:
    """Raise `InputError` for an area between two corners, x and y, over which lengths on the map are not true."""
    for axis, least, most in zip("xy", low, high, strict=False):
        if max(-least, most) > MAX_FAR:
            raise InputError(
                f"{where}: expected {axis} within {MAX_FAR / 1000:g} km of the origin, where lengths on the map are "
                f"true to 1e-4, found {least / 1000:.4g} to {most / 1000:.4g} km"
            )
