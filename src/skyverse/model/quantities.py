"""What the fields of a scenario hold: numbers, places, extents, and arrays. SI units, local east-north-up metres."""

from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
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


class GridModel(Model):
    """A model that holds arrays; they are read-only, and compared element by element."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        ours, theirs = self.__dict__, other.__dict__
        return ours.keys() == theirs.keys() and all(
            np.array_equal(value, theirs[name]) if isinstance(value, np.ndarray) else value == theirs[name]
            for name, value in ours.items()
        )

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[Any, Any]) -> None:
        super().__setstate__(state)
        for value in self.__dict__.values():  # a pickle forgets that arrays are read-only
            if isinstance(value, np.ndarray):
                value.flags.writeable = False


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only copy of an array; itself where it is read-only and its own already."""
    if array.flags.writeable or array.base is not None:
        array = array.copy(order="C")
        array.flags.writeable = False
    return array


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
