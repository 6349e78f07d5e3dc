"""The types of a scenario's fields: numbers, places and extents, in SI units and local metres east, north and up."""

import hashlib
import sys
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from skyverse.errors import InputError
from skyverse.model.wrong_values import keys_of_schema, wrong_field

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Limit = Annotated[Number, Field(ge=1e-3, le=1e6)]
"""A limit of a vehicle; the range holds every real one, and keeps durations and their powers finite."""
Amount = Annotated[NonNegative, Field(le=1e6)]
"""An amount of anything that is seen, with the same largest value."""


NOT_FINITE = ("Infinity", "-Infinity", "NaN")
"""How files spell numbers that are not finite, for which JSON has no other words."""


def _number(value: object) -> object:
    if isinstance(value, bool) or (isinstance(value, str) and value not in NOT_FINITE):
        raise ValueError("expected a number")
    return value


Real = Annotated[float, BeforeValidator(_number)]
"""A number of an answer, which may be infinite; a text and a truth value are none."""
Whole = Annotated[int, Field(strict=True, ge=-(2**53), le=2**53)]
"""A whole number that a float holds, too."""
Flag = Annotated[bool, Field(strict=True)]


MAX_COORDINATE = 1e12
"""Metres from the zero of the frame, beyond which squares and products of coordinates mean nothing any more."""
Coordinate = Annotated[Number, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]


def listed(value: object) -> object:
    """Return an array as lists, which pydantic can validate, and anything else as it is."""
    return value.tolist() if isinstance(value, np.ndarray) else value


Point = Annotated[tuple[Coordinate, Coordinate, Coordinate], BeforeValidator(listed)]
"""x, y, z in metres; a numpy array of three numbers is accepted too."""
Place = Annotated[tuple[Coordinate, Coordinate], BeforeValidator(listed)]
"""x, y in metres."""
Steps = Annotated[tuple[Positive, Positive, Positive], BeforeValidator(listed)]


MAX_INSTANT = 1e9
"""Seconds: no instant is later or earlier than this."""
Instant = Annotated[Number, Field(ge=-MAX_INSTANT, le=MAX_INSTANT)]
"""Seconds into the mission."""


class Model(BaseModel):
    """The base of all models: frozen data that refuse unknown keys.

    Whatever makes one validates it, a copy with changes too, and raises `InputError` that names the field;
    ``model_validate`` raises pydantic's own error, which lists everything that is wrong.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            field, said = wrong_field(error, data, keys_of_schema(type(self).model_json_schema()))
            raise InputError(said, field=field or None) from None

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # or pydantic would call it for parts of data

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values in some fields, validated as if it were made anew.

        Raises
        ------
        InputError
            If there is no such field, or the model cannot have such a value.
        """
        whole = super().model_copy(deep=deep)
        return type(self)(**{**dict(whole), **update}) if update else whole

    def copy(self, **changes: Any) -> Self:
        """Do what `model_copy` does; pydantic's own, which it keeps from its first version, validates nothing."""
        return self.model_copy(**changes)


AnyModel = TypeVar("AnyModel", bound=BaseModel)


def derived(model: AnyModel, **fields: Any) -> AnyModel:
    """Return a copy with other values in some fields, which nobody validates.

    It is for what the library derives from given data, such as a scenario without its terrain, and may be unsound.
    """
    unknown = fields.keys() - type(model).model_fields.keys()
    if unknown:
        raise TypeError(f"{type(model).__name__} has no field {', '.join(sorted(unknown))}")
    return BaseModel.model_copy(model, update=fields)


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


def named_type(field: str, default: str) -> Callable[[object], str]:
    """Return what tells the type of data by a field that names it; data without that field are of the default type."""

    def name(value: object) -> str:
        said = value.get(field, default) if isinstance(value, dict) else getattr(value, field, default)
        return said if isinstance(said, str) else default

    return name


SHORT_DIGEST = 12
"""Hexadecimal digits of a digest that messages and pages show; 48 bits, which no mistake makes equal."""


def digest_of(model: BaseModel) -> str:
    """Return the SHA-256 of a model's canonical content, 64 hexadecimal digits.

    The content is the model as JSON, without what equals its default, and what a scenario was built with. A large array
    counts by its shape and the digest of its bytes.
    """
    left_out, context = {"built_with"}, {"side": _array_digest}
    text = model.model_dump_json(exclude_defaults=True, exclude=left_out, context=context)
    return hashlib.sha256(text.encode()).hexdigest()


def short(digest: object) -> str:
    """Return a digest as messages show it, such as ``sha256 1a2b3c4d5e6f``."""
    return f"sha256 {str(digest)[:SHORT_DIGEST]}"


def _array_digest(array: NDArray[Any]) -> dict[str, object]:
    """Return the shape of an array, and the digest of its numbers in little-endian order."""
    numbers = np.ascontiguousarray(array)
    if sys.byteorder == "big":
        numbers = numbers.byteswap()
    return {"shape": list(array.shape), "sha256": hashlib.sha256(numbers.tobytes()).hexdigest()}
