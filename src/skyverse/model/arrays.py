"""Records with arrays: validated when they are read, read-only, compared element by element, lists in JSON."""

import math
from dataclasses import fields
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ConfigDict, PlainSerializer, PlainValidator

from skyverse._typing import Floats, Ints
from skyverse.errors import InputError, shown
from skyverse.model.quantities import NOT_FINITE


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only copy of an array, or the array itself if it is read-only and owns its memory."""
    if array.flags.writeable or array.base is not None:
        array = array.copy(order="C")
        array.flags.writeable = False
    return array


def equal(one: Any, other: Any) -> bool:
    """Tell whether two values are equal; arrays are compared element by element."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other)
    return bool(one == other)


class ArrayRecord:
    """The base of frozen dataclasses with arrays among their fields.

    The arrays are read-only and compared element by element; unknown keys are refused when a record is read.
    """

    __pydantic_config__ = ConfigDict(extra="forbid", ser_json_inf_nan="strings")

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, frozen(value))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()  # a pickle does not keep that arrays are read-only

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        compared = (f.name for f in fields(self) if f.compare)  # type: ignore[arg-type]
        return all(equal(getattr(self, name), getattr(other, name)) for name in compared)

    __hash__ = None  # type: ignore[assignment]


def floats(value: object) -> Floats:
    """Return numbers in rows of equal length as a read-only array, or raise `ValueError`."""
    return frozen(_array(value, np.float64, "numbers in rows of equal length"))


def instants_of(t: ArrayLike) -> Floats:
    """Return one instant or several as an array (m,) of seconds.

    Raises
    ------
    InputError
        If they are no numbers, or not a row of them, or NaN is among them.
    """
    try:
        instants = np.atleast_1d(np.asarray(t, dtype=np.float64))
    except (TypeError, ValueError):
        instants = np.full((1, 1), np.nan)
    if instants.ndim != 1 or np.isnan(instants).any():
        raise InputError(f"expected an instant, or a row of instants, in seconds, found {shown(t)}", field="t")
    return instants


def rows_of(points: ArrayLike, field: str) -> Floats:
    """Return one point or several as an array (m, 3), or raise `InputError` unless they are rows of three numbers."""
    try:
        rows = np.atleast_2d(np.asarray(points, dtype=np.float64))
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] != 3 or not np.isfinite(rows).all():
        raise InputError(f"expected rows of three finite numbers, found {shown(points)}", field=field)
    return rows


def integers(value: object) -> Ints:
    """Return whole numbers as a read-only array, or raise `ValueError`."""
    array = _array(value, None, "whole numbers")
    if array.size and array.dtype.kind not in "iu":
        raise ValueError("expected whole numbers")
    return frozen(array.astype(np.int64))


def all_numbers(value: object) -> bool:
    """Tell whether a value, or all that lists in it hold, are numbers; a text and a truth value are none."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "iuf"
    if isinstance(value, list | tuple):
        return set(map(type, value)) <= {int, float} or all(map(all_numbers, value))
    return not isinstance(value, bool | str) or value in NOT_FINITE


def _array(value: object, dtype: type[np.float64] | None, due: str) -> NDArray[Any]:
    if not all_numbers(value):
        raise ValueError(f"expected {due}")
    try:
        return np.array(value, dtype=dtype)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"expected {due}") from None


def _points(value: object) -> Floats:
    array = floats(value)
    if array.size == 0:
        return floats(array.reshape(0, 3))
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"expected rows of x, y, z, found an array of shape {array.shape}")
    return array


def _point(value: object) -> Floats:
    array = floats(value)
    if array.shape != (3,):
        raise ValueError(f"expected x, y, z, found an array of shape {array.shape}")
    return array


_listed = PlainSerializer(lambda array: array.tolist(), when_used="json")
FloatArray = Annotated[NDArray[np.float64], PlainValidator(floats), _listed]
IntArray = Annotated[NDArray[np.int64], PlainValidator(integers), _listed]
PointArray = Annotated[NDArray[np.float64], PlainValidator(_points), _listed]
"""(n, 3) metres."""
PointVector = Annotated[NDArray[np.float64], PlainValidator(_point), _listed]
"""(3,) metres."""


_ARCSINH, _ARCTAN2 = np.frompyfunc(math.asinh, 1, 1), np.frompyfunc(math.atan2, 2, 1)
_EXP, _POWER = np.frompyfunc(math.exp, 1, 1), np.frompyfunc(math.pow, 2, 1)


# These round alike on all processors: the C library computes one element after another. numpy has functions of its own
# for processors with AVX-512, which round otherwise. Its sine, cosine and square root are the same everywhere.
def arcsinh(x: ArrayLike) -> Floats:
    """Return the inverse hyperbolic sines."""
    return np.asarray(_ARCSINH(x), dtype=np.float64)


def arctan2(y: ArrayLike, x: ArrayLike) -> Floats:
    """Return the angles of vectors from the x-axis, radians."""
    return np.asarray(_ARCTAN2(y, x), dtype=np.float64)


def exp(x: ArrayLike) -> Floats:
    """Return the exponentials."""
    return np.asarray(_EXP(x), dtype=np.float64)


def power(base: ArrayLike, exponent: ArrayLike) -> Floats:
    """Return powers of numbers that are not negative."""
    return np.asarray(_POWER(base, exponent), dtype=np.float64)
