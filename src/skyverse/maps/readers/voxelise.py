"""The voxels that triangles touch, by exact tests of separating axes.

Source: T. Akenine-Möller, "Fast 3D triangle-box overlap testing", Journal of Graphics Tools 6 (2001), 29-33.
"""

import numpy as np
from numpy.typing import NDArray

from skyverse.numerics.kernel import inner, kernel

_VOXEL_TOUCH = 1e-9
"""Voxels; a triangle this near to a voxel touches it, so that rounding leaves no voxel out."""


@kernel
def touched(corners: NDArray[np.float64], occupied: NDArray[np.bool_]) -> None:
    """Mark the voxels that triangles touch.

    Parameters
    ----------
    corners
        (n, 3, 3) corners of triangles in voxels: voxel i, j, k reaches from (i, j, k) to (i + 1, j + 1, k + 1).
    occupied
        (nx, ny, nz); voxels that are touched become true.
    """
    low = np.empty(3, dtype=np.int64)
    high = np.empty(3, dtype=np.int64)
    for t in range(len(corners)):
        a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
        for axis in range(3):
            least = min(a[axis], b[axis], c[axis])
            most = max(a[axis], b[axis], c[axis])
            low[axis] = max(0, int(np.ceil(least - _VOXEL_TOUCH)) - 1)
            high[axis] = min(occupied.shape[axis] - 1, int(np.floor(most + _VOXEL_TOUCH)))
        nx = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])
        ny = (b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2])
        nz = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        # along the axis that is nearest to the normal, a column of voxels meets the plane in few voxels
        size = abs(nx) + abs(ny) + abs(nz)
        face = 0 if abs(nx) >= max(abs(ny), abs(nz)) else (1 if abs(ny) >= abs(nz) else 2)
        normal = nx if face == 0 else (ny if face == 1 else nz)
        u, v = (face + 1) % 3, (face + 2) % 3
        nu = ny if face == 0 else (nz if face == 1 else nx)
        nv = nz if face == 0 else (nx if face == 1 else ny)
        for i in range(low[u], high[u] + 1):
            for j in range(low[v], high[v] + 1):
                first, last = low[face], high[face]
                if size > 0:
                    middle = a[face] - (nu * (i + 0.5 - a[u]) + nv * (j + 0.5 - a[v])) / normal
                    reach = (abs(nu) + abs(nv)) / abs(normal) / 2 + 1e-6
                    first = max(first, int(np.floor(middle - reach)) - 1)
                    last = min(last, int(np.floor(middle + reach)) + 1)
                for k in range(first, last + 1):
                    x = k if face == 0 else (j if face == 1 else i)
                    y = i if face == 0 else (k if face == 1 else j)
                    z = j if face == 0 else (i if face == 1 else k)
                    if not occupied[x, y, z] and _overlap(a, b, c, x + 0.5, y + 0.5, z + 0.5):
                        occupied[x, y, z] = True


@inner
def _overlap(
    a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], x: float, y: float, z: float
) -> bool:
    """Tell whether a triangle touches the unit cube around x, y, z: no axis separates them."""
    ax, ay, az = a[0] - x, a[1] - y, a[2] - z
    bx, by, bz = b[0] - x, b[1] - y, b[2] - z
    cx, cy, cz = c[0] - x, c[1] - y, c[2] - z
    if (
        _separates(1.0, 0.0, 0.0, ax, ay, az, bx, by, bz, cx, cy, cz)
        or _separates(0.0, 1.0, 0.0, ax, ay, az, bx, by, bz, cx, cy, cz)
        or _separates(0.0, 0.0, 1.0, ax, ay, az, bx, by, bz, cx, cy, cz)
    ):
        return False
    dx, dy, dz = bx - ax, by - ay, bz - az
    ex, ey, ez = cx - bx, cy - by, cz - bz
    fx, fy, fz = ax - cx, ay - cy, az - cz
    if _separates(dy * ez - dz * ey, dz * ex - dx * ez, dx * ey - dy * ex, ax, ay, az, bx, by, bz, cx, cy, cz):
        return False
    for edge in range(3):
        ox = dx if edge == 0 else (ex if edge == 1 else fx)
        oy = dy if edge == 0 else (ey if edge == 1 else fy)
        oz = dz if edge == 0 else (ez if edge == 1 else fz)
        if (
            _separates(0.0, -oz, oy, ax, ay, az, bx, by, bz, cx, cy, cz)
            or _separates(oz, 0.0, -ox, ax, ay, az, bx, by, bz, cx, cy, cz)
            or _separates(-oy, ox, 0.0, ax, ay, az, bx, by, bz, cx, cy, cz)
        ):
            return False
    return True


@inner
def _separates(
    nx: float,
    ny: float,
    nz: float,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    cx: float,
    cy: float,
    cz: float,
) -> bool:
    """Tell whether an axis separates a triangle from the unit cube around zero by more than `_VOXEL_TOUCH`."""
    p, q, r = nx * ax + ny * ay + nz * az, nx * bx + ny * by + nz * bz, nx * cx + ny * cy + nz * cz
    reach = (abs(nx) + abs(ny) + abs(nz)) * (0.5 + _VOXEL_TOUCH)
    return min(p, q, r) > reach or max(p, q, r) < -reach
