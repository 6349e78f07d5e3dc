"""The digest of a model: a short text that names its content, and that another content does not have."""

import hashlib
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

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
