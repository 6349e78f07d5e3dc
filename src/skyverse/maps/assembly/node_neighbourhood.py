"""Values of the cells around the nodes of a grid."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats


def greatest_around_nodes(cells: Floats, reach: Sequence[int] = (0, 0)) -> Floats:
    """Return for each node the greatest value of the cells around it, (nx, ny).

    Parameters
    ----------
    cells
        (nx - 1, ny - 1) values of the cells.
    reach
        How many cells more count on each side along x and along y.
    """
    for axis, more in enumerate(reach):
        few = min(more, cells.shape[axis])
        padding = [(0, 0), (0, 0)]
        padding[axis] = (few + 1, few + 1)
        padded = np.pad(cells, padding, mode="edge")
        cells = np.lib.stride_tricks.sliding_window_view(padded, 2 * few + 2, axis).max(axis=-1)
    return np.asarray(cells)
