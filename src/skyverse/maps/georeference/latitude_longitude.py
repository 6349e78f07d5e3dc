"""Whether a latitude and a longitude lie on the globe."""

from skyverse.errors import InputError

SWAPPED = "; are latitude and longitude swapped?"
"""What is added to a message where the two would fit the other way round."""


def require_on_globe(what: str, latitude: float, longitude: float) -> None:
    """Raise `InputError`, which begins with `what`, unless both are in their ranges, degrees."""
    if not abs(latitude) <= 90:
        hint = SWAPPED if abs(latitude) <= 180 and abs(longitude) <= 90 else ""
        raise InputError(f"{what}: expected a latitude from -90 to 90 degrees, found {latitude:g}{hint}")
    if not abs(longitude) <= 180:
        raise InputError(f"{what}: expected a longitude from -180 to 180 degrees, found {longitude:g}")
