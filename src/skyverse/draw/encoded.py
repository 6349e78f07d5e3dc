"""Numbers and names as plotly's script takes them."""

import base64
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Trace = dict[str, Any]


def flat(values: ArrayLike) -> list[float | None]:
    """Return numbers for JSON: rounded to a tenth of a millimetre, what is not finite as ``None``."""
    rounded = np.round(np.asarray(values, dtype=np.float64), 4).tolist()
    return [value if math.isfinite(value) else None for value in rounded]


def packed(values: ArrayLike) -> Trace:
    """Return many numbers as plotly takes them in little space: bytes in base64; of fractions, 7 digits are kept."""
    array = np.asarray(values)
    whole = array.dtype.kind in "iu"
    array = np.ascontiguousarray(array, dtype="<i4" if whole else "<f4")
    shape = {"shape": ", ".join(map(str, array.shape))} if array.ndim > 1 else {}
    return {"dtype": "i4" if whole else "f4", "bdata": base64.b64encode(array.tobytes()).decode(), **shape}


def plain(text: str) -> str:
    """Return `text` without what plotly would take for markup."""
    return text.translate({60: 0x2039, 62: 0x203A})  # single guillemets
