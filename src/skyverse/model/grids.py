"""Grids as fields of models: heights and voxels, in the file itself or in a side file that it refers to."""

from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, PlainSerializer, PlainValidator, SerializationInfo, ValidationInfo, WithJsonSchema

from skyverse._typing import Bools, Floats
from skyverse.model.arrays import all_numbers, equal, frozen
from skyverse.model.quantities import Model


class _Shape(tuple[int, ...]):
    """The shape of an array, which stands for its numbers where a model is shown."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"array of {' x '.join(map(str, self))}"


class GridModel(Model):
    """A model with grids among its fields; they are read-only arrays and compared element by element."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        ours, theirs = self.__dict__, other.__dict__
        return ours.keys() == theirs.keys() and all(equal(value, theirs[name]) for name, value in ours.items())

    __hash__ = None  # type: ignore[assignment]

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        for name, value in super().__repr_args__():
            yield name, _Shape(value.shape) if isinstance(value, np.ndarray) else value

    def __setstate__(self, state: dict[Any, Any]) -> None:
        super().__setstate__(state)
        for value in self.__dict__.values():  # a pickle does not keep that arrays are read-only
            if isinstance(value, np.ndarray):
                value.flags.writeable = False


def _dereferenced(value: object, info: ValidationInfo) -> object:
    """Return a value as it is, or, for a reference to a side file, the array that the reader's `grids` finds there."""
    if not isinstance(value, dict):
        return value
    grids = (info.context or {}).get("grids")
    if grids is None:
        raise ValueError(
            "expected rows of numbers; a reference to a side file is followed only when the scenario's file is read"
        )
    return grids(value)


def _heights(value: object, info: ValidationInfo) -> Floats:
    rows = _dereferenced(value, info)
    try:
        if not all_numbers(rows):
            raise ValueError
        heights = np.asarray(rows, dtype=np.float64)
    except (TypeError, OverflowError, ValueError):
        raise ValueError("expected rows of numbers of equal length") from None
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise ValueError(f"expected two rows of two numbers or more, found an array of shape {heights.shape}")
    holes = np.argwhere(~np.isfinite(heights))
    if len(holes):
        raise ValueError(f"expected a height everywhere, but there is none at [{holes[0, 0]}][{holes[0, 1]}]")
    return frozen(heights)


def _occupied(value: object, info: ValidationInfo) -> Bools:
    layers = _dereferenced(value, info)
    try:
        occupied = np.asarray(layers)
    except ValueError:
        raise ValueError("expected layers of rows of equal length") from None
    if occupied.ndim != 3 or not occupied.size:
        raise ValueError(f"expected an array of three dimensions, found one of shape {occupied.shape}")
    if occupied.dtype != bool and not (all_numbers(layers) and np.isin(occupied, (0, 1)).all()):
        raise ValueError("expected 0 for what is free and 1 for what is occupied")
    return frozen(occupied.astype(bool, copy=False))


MAX_INLINE_NUMBERS = 4096
"""Numbers at most that a file holds itself; larger arrays go to a side file."""


def written(array: NDArray[Any], info: SerializationInfo) -> object:
    """Return an array as lists, or, if it is large and the writer has a `side` file, as a reference to that file."""
    side = (info.context or {}).get("side")
    if side is None or array.size <= MAX_INLINE_NUMBERS:
        return array.astype(int).tolist() if array.dtype == bool else array.tolist()
    return side(array)


_REFERENCE = {
    "type": "object",
    "properties": {
        "file": {"type": "string"},
        "array": {"type": "string"},
        "shape": {"type": "array", "items": {"type": "integer"}},
        "sha256": {"type": "string"},
    },
    "required": ["file", "array", "shape", "sha256"],
    "additionalProperties": False,
}


def _schema(depth: int) -> WithJsonSchema:
    rows: dict[str, Any] = {"type": "number"}
    for _ in range(depth):
        rows = {"type": "array", "items": rows}
    return WithJsonSchema({"anyOf": [rows, _REFERENCE]})


Occupied = Annotated[Bools, PlainValidator(_occupied), PlainSerializer(written, when_used="json"), _schema(3)]
Heights = Annotated[Floats, PlainValidator(_heights), PlainSerializer(written, when_used="json"), _schema(2)]
