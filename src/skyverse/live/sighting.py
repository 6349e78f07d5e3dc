"""What was seen of a mover at an instant, and what is known of how it may move on."""

import math
from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator

from skyverse.errors import InputError
from skyverse.model.mover import MoverShape
from skyverse.model.quantities import Amount, Limit, Model, Number, listed
from skyverse.model.wrong_values import complaint

MAX_SEEN = 1e6
"""Metres, m/s or m/s^2: nothing that is seen is farther off, larger or faster, so that squares of it mean something."""
MIN_SEEN = 1e-6
"""Metres: nothing that is seen is smaller."""


def _of_real_size(shape: MoverShape) -> MoverShape:
    for name, value in shape.model_dump(
        exclude_none=True, exclude={"shape", "name", "kind", "solid", "closed_above"}
    ).items():
        sizes = np.abs(np.atleast_1d(value))
        if sizes.max() > MAX_SEEN:
            raise ValueError(f"{name} must be at most {MAX_SEEN:g} m")
        if np.ndim(value) == 0 and name not in ("low", "high") and sizes.min() < MIN_SEEN:
            raise ValueError(f"{name} must be at least {MIN_SEEN:g} m")
    return shape


Component = Annotated[Number, Field(ge=-MAX_SEEN, le=MAX_SEEN)]
Vector = Annotated[tuple[Component, Component, Component], BeforeValidator(listed)]


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
    shape: Annotated[MoverShape, AfterValidator(_of_real_size)]
    position: Vector
    error: Amount = 0.0
    velocity: Vector | None = None
    velocity_error: Amount = 0.0
    top_speed: Limit
    max_acceleration: Amount | None = None

    @model_validator(mode="after")
    def _within_top_speed(self) -> Self:
        if self.velocity is not None and math.hypot(*self.velocity) > self.top_speed + self.velocity_error:
            seen = f"{math.hypot(*self.velocity):g} m/s"
            raise ValueError(f"velocity must not be above top_speed and velocity_error together, but it is {seen}")
        return self


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
