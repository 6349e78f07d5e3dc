"""Numbers and names in the form that plotly.js reads."""

import base64
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skyverse._typing import Floats, Ints

Trace = dict[str, Any]

PLOTLY_DASHES = ("solid", "dash", "dot", "longdash", "dashdot")
"""The dash of each lap of the palette of tracks."""


def trace(kind: str, mode: str, name: str, points: Trace, hover: str | None, meta: Trace, **more: Any) -> Trace:
    """Return a plotly trace whose ``meta`` says what it shows; without `hover` the pointer shows no label."""
    label = {"hoverinfo": "skip"} if hover is None else {"hovertemplate": hover}
    return {"type": kind, "mode": mode, "name": name, **points, **label, **more, "meta": meta}


def flat(values: ArrayLike) -> list[float | None]:
    """Return numbers for JSON, rounded to 4 decimals; numbers that are not finite become ``None``."""
    rounded = np.round(np.asarray(values, dtype=np.float64), 4).tolist()
    return [value if math.isfinite(value) else None for value in rounded]


NOWHERE: Trace = {"x": [None], "y": [None], "z": [None]}
"""The points of a trace in space that the page fills in."""


def packed(values: ArrayLike) -> Trace:
    """Return numbers as base64 bytes, which plotly reads: 32-bit integers, or floats with about 7 digits."""
    array = np.asarray(values)
    whole = array.dtype.kind in "iu"
    array = np.ascontiguousarray(array, dtype="<i4" if whole else "<f4")
    shape = {"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else {}
    return {"dtype": "i4" if whole else "f4", "bdata": base64.b64encode(array.tobytes()).decode(), **shape}


def round_step(least: float) -> float:
    """Return the first of 1, 2, 5 and 10 times a power of ten that is not below a number above zero."""
    decade = 10.0 ** math.floor(math.log10(least))
    return next(n * decade for n in (1, 2, 5, 10) if n * decade >= least * (1 - 1e-9))


def plain(text: str) -> str:
    """Return `text` without characters that plotly reads as markup."""
    return text.translate({60: 0x2039, 62: 0x203A})  # < and > become single guillemets


def columns(points: NDArray[Any], names: str = "xyz", form: Callable[[ArrayLike], Any] = flat) -> Trace:
    """Return the columns of points, (n, k), by name, as numbers or packed."""
    return {name: form(points[:, column]) for column, name in enumerate(names)}


def mesh(name: str, points: Floats, triangles: Ints, meta: Trace, /, **more: Any) -> Trace:
    """Return a surface of points, (n, 3), and triangles, (m, 3)."""
    faces = columns(points, form=packed) | columns(triangles, "ijk", packed)
    return {"type": "mesh3d", "name": name, **faces, "hoverinfo": "skip", **more, "meta": meta}


def area(name: str, line: Floats, meta: Trace, /, **more: Any) -> Trace:
    """Return what a line, (n, 2) with gaps of nan, encloses."""
    return trace("scatter", "lines", name, columns(line, "xy", packed), None, meta, fill="toself", **more)
