"""The surface of boxes as one solid, without the walls inside it where they touch or overlap."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.draw.shape_geometry import skin
from skyverse.model.shapes import Box, Voxels

MAX_BOXES = 2_000
"""The largest number of boxes that are compared with each other."""
MAX_CELLS = 2_000_000
"""The largest number of cells into which the boxes' sides may cut space."""


def touching(shapes: Sequence[object]) -> set[int]:
    """Return the indices of the boxes among some shapes that touch or overlap another one of them."""
    rows = [k for k, shape in enumerate(shapes) if isinstance(shape, Box)]
    if not 1 < len(rows) <= MAX_BOXES:
        return set()
    boxes = [shape for shape in shapes if isinstance(shape, Box)]
    low, high = np.array([box.min for box in boxes]), np.array([box.max for box in boxes])
    meet = np.ones((len(boxes), len(boxes)), dtype=bool)
    for axis in range(3):
        meet &= low[:, None, axis] <= high[:, axis]
        meet &= low[:, axis] <= high[:, None, axis]
    np.fill_diagonal(meet, False)
    return {rows[k] for k in np.flatnonzero(meet.any(axis=1))}


def united(boxes: Sequence[Box]) -> tuple[Floats, Ints] | None:
    """Return the points (n, 3) and triangles (m, 3) of the surface of some boxes; ``None`` for none, or too many.

    Seen through, two boxes that share a wall would otherwise be darker there than anywhere else.
    """
    corners = np.array([(box.min, box.max) for box in boxes], dtype=np.float64).reshape(-1, 2, 3)
    sides = [np.unique(corners[:, :, axis]) for axis in range(3)]
    shape = [len(places) - 1 for places in sides]
    if min(shape, default=0) < 1 or np.prod(shape, dtype=float) > MAX_CELLS:
        return None
    cells = np.zeros(shape, dtype=bool)
    first, last = (
        np.column_stack([np.searchsorted(sides[axis], corners[:, end, axis]) for axis in range(3)]) for end in (0, 1)
    )
    for low, high in zip(first, last, strict=True):
        cells[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = True
    numbered = skin(Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=cells)).astype(np.int64)
    quads = np.stack([sides[axis][numbered[:, :, axis]] for axis in range(3)], axis=-1)
    start = 4 * np.arange(len(quads))[:, None]
    return quads.reshape(-1, 3), np.vstack([start + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
