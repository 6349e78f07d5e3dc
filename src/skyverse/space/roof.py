"""How high obstacles reach."""

import numpy as np

from skyverse.model.shapes import AnyShape, Box, Sphere, Voxels

Place = tuple[float, float, float]


def roof_z(shape: AnyShape, point: Place, clearance: float) -> float:
    """Return the z at which an obstacle ends, metres.

    Parameters
    ----------
    shape
        The obstacle.
    point
        x, y, z in metres: of voxels, only those count that are nearer to this point, as seen from above, than the
        clearance along x and y.
    clearance
        Metres.
    """
    if isinstance(shape, Box):
        return shape.max[2]
    if isinstance(shape, Sphere):
        return shape.centre[2] + shape.radius
    if not isinstance(shape, Voxels):
        return shape.high
    first, step = np.array(shape.origin), np.array(shape.step)
    cells = [np.floor((np.array(point) + side * clearance - first) / step).astype(int) for side in (-1, 1)]
    (i, j, _), (last_i, last_j, _) = np.clip(cells, 0, np.array(shape.occupied.shape) - 1).tolist()
    levels = np.flatnonzero(shape.occupied[i : last_i + 1, j : last_j + 1].any(axis=(0, 1)))
    return float(first[2] + step[2] * (levels.max(initial=-1) + 1))
