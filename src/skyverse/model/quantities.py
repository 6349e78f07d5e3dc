"""What the fields of a scenario hold: numbers, places and extents. SI units, local east-north-up metres."""

from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Limit = Annotated[Number, Field(ge=1e-3, le=1e6)]
"""What no vehicle is outside of, so that durations and their powers stay numbers."""


def listed(value: object) -> object:
    """Return an array as the lists that pydantic validates."""
    return value.tolist() if isinstance(value, np.ndarray) else value


Point = Annotated[tuple[Number, Number, Number], BeforeValidator(listed)]
"""x, y, z in metres; a numpy array of three is accepted."""
Place = Annotated[tuple[Number, Number], BeforeValidator(listed)]
"""x, y in metres."""
Steps = Annotated[tuple[Positive, Positive, Positive], BeforeValidator(listed)]


class Model(BaseModel):
    """Frozen data; unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Extent(Model):
    """A box: ``min`` and ``max`` corner, metres."""

    min: Point
    max: Point

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for axis, low, high in zip("xyz", self.min, self.max, strict=True):
            if not low < high:
                raise ValueError(f"min must be below max on every axis, but {axis} runs from {low:g} to {high:g}")
        return self
