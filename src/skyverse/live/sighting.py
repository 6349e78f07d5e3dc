"""What was seen of a mover at an instant, and what is known of how it may move on."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, ValidationError

from skyverse.errors import InputError
from skyverse.model.mover import MoverShape
from skyverse.model.quantities import Limit, Model, NonNegative, Point
from skyverse.model.wrong_values import complaint


class Sighting(Model):
    """What was seen of a mover at an instant, and what is known of how it may move on.

    Attributes
    ----------
    name
        Tells movers apart: sightings of one mover have one name.
    shape
        In a frame whose zero is the moving point and whose axes do not turn.
    position
        x, y, z of the moving point, metres.
    error
        Metres by which that may be off.
    velocity
        x, y, z in m/s; ``None`` where it was not measured, and is estimated from earlier sightings.
    velocity_error
        M/s by which the velocity may be off, if it is given.
    top_speed
        M/s that the mover never exceeds.
    max_acceleration
        M/s^2 that it never exceeds; ``None`` where that is not known, as of a mover that may turn back in an instant.
    """

    name: Annotated[str, Field(min_length=1)]
    shape: MoverShape
    position: Point
    error: NonNegative = 0.0
    velocity: Point | None = None
    velocity_error: NonNegative = 0.0
    top_speed: Limit
    max_acceleration: NonNegative | None = None


def checked_sighting(given: Sighting | Mapping[str, object], number: int) -> Sighting:
    """Return the sighting of a mover that was given as the one of some number, or raise `InputError`."""
    if isinstance(given, Sighting):
        return given
    try:
        return Sighting.model_validate(given)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in ("", *first["loc"]))
        raise InputError(complaint(first), field=f"movers[{number}]{place}") from None
