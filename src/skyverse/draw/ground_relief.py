"""The ground for pictures: a terrain resampled to fewer heights, its shading and its colours."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.draw.palette import GROUND_ON_MAP
from skyverse.model.shapes import Terrain

MAX_SPACE_HEIGHTS = 200
"""The largest number of heights along each side of a picture in space."""

LIGHT_RANGE = 0.6
"""The least range of brightness, from 0 to 1, between lit and shaded slopes of a picture in space."""
MAX_GAIN = 2.5
"""How much the contrast of gentle slopes is raised at most."""
_LEVEL_SHARE = 0.02
"""Ground whose heights differ by less than this share of its longer side looks level."""
_TINTS = np.array([list(bytes.fromhex(tone[1:])) for tone in GROUND_ON_MAP])


@dataclass(frozen=True, eq=False)
class Relief:
    """Heights z, (n, m), at x, (n,), and y, (m,), in metres, which cover all that is drawn."""

    x: Floats
    y: Floats
    z: Floats


def relief(terrain: Terrain, low: ArrayLike, high: ArrayLike, finest: int = MAX_SPACE_HEIGHTS) -> Relief:
    """Return the ground from `low` to `high`, (x, y), in at most `finest` evenly spaced heights along each side."""
    first, last = (np.clip(np.asarray(corner, dtype=np.float64)[:2], *terrain.extent) for corner in (low, high))
    counts = np.ceil((last - first) / terrain.step - 1e-9).astype(int) + 1
    x, y = (np.linspace(first[k], last[k], np.clip(counts[k], 2, finest)) for k in range(2))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    return Relief(x, y, terrain.height(places))


def cleared(drawn: Relief, terrain: Terrain, points: Floats) -> Relief:
    """Return the relief lowered so that below each of `points`, (n, 3), it is at most half-way up from the true ground.

    With few heights the drawn ground may be higher than the true one; without this it could hide paths above it.
    """
    true = terrain.height(points[:, :2])
    most = np.maximum(true, (true + points[:, 2]) / 2)
    i = np.clip(np.searchsorted(drawn.x, points[:, 0], side="right") - 1, 0, len(drawn.x) - 2)
    j = np.clip(np.searchsorted(drawn.y, points[:, 1], side="right") - 1, 0, len(drawn.y) - 2)
    u = np.clip((points[:, 0] - drawn.x[i]) / (drawn.x[i + 1] - drawn.x[i]), 0, 1)
    v = np.clip((points[:, 1] - drawn.y[j]) / (drawn.y[j + 1] - drawn.y[j]), 0, 1)
    h, a, b, d = (drawn.z[i + p, j + q] for p, q in ((0, 0), (1, 0), (0, 1), (1, 1)))
    # a cell is drawn as two triangles, which meet at either of its diagonals
    one = np.where(u >= v, h + u * (a - h) + v * (d - a), h + v * (b - h) + u * (d - b))
    other = np.where(u + v <= 1, h + u * (a - h) + v * (b - h), d + (1 - u) * (b - d) + (1 - v) * (a - d))
    excess = np.maximum(np.maximum(one, other) - most, 0)
    lowered = np.zeros_like(drawn.z)
    for p, q in ((0, 0), (1, 0), (0, 1), (1, 1)):
        np.maximum.at(lowered, (i + p, j + q), excess)
    return Relief(drawn.x, drawn.y, drawn.z - lowered)


def along(lines: Sequence[Floats], spacing: float) -> Floats:
    """Return points, (n, m), on lines, (k, m) each, at most `spacing` metres apart on the map.

    The first two columns of a line are x and y; the others, such as z, are interpolated with them.
    """
    width = lines[0].shape[1] if lines else 3
    points = [np.empty((0, width))]
    for line in lines:
        if len(line):
            lengths = np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1)
            counts = np.ceil(lengths / spacing).astype(int) + 1
            where = [k + np.arange(n) / n for k, n in enumerate(counts)]
            at = np.concatenate([*where, [len(line) - 1.0]])
            points.append(
                np.column_stack([np.interp(at, np.arange(len(line)), line[:, axis]) for axis in range(width)])
            )
    return np.concatenate(points)


def shade(drawn: Relief, exaggeration: float = 1.0) -> Floats:
    """Return the brightness, (n, m) from 0 to 1, of the ground in light from the north-west, 45 degrees high."""
    east, north = np.gradient(drawn.z * exaggeration, drawn.x, drawn.y)
    light = (0.5 * east - 0.5 * north + np.sqrt(0.5)) / np.sqrt(1 + east**2 + north**2)
    return np.clip(light, 0, 1)


def tinted(drawn: Relief, exaggeration: float = 1.0) -> Floats:
    """Return the ground's colours, (n, m, 3) from 0 to 1, which follow height and shading."""
    at = _share(drawn) * (len(_TINTS) - 1)
    tints = np.stack([np.interp(at, np.arange(len(_TINTS)), _TINTS[:, channel]) for channel in range(3)], axis=-1)
    return np.clip(tints / 255 * (0.45 + 0.78 * shade(drawn, exaggeration))[..., None], 0, 1)


def relit(drawn: Relief, exaggeration: float = 1.0) -> Floats:
    """Return height and shading combined into one number, (n, m) from 0 to 1, for a colour scale."""
    light = shade(drawn, exaggeration)
    dark, bright = np.quantile(light, (0.02, 0.98))
    gain = min(LIGHT_RANGE / max(float(bright - dark), 1e-9), MAX_GAIN)
    lit = np.clip(0.5 + max(gain, 1.0) * (light - (dark + bright) / 2), 0, 1)
    return 0.45 * _share(drawn) + 0.55 * lit


def _share(drawn: Relief) -> Floats:
    """Return heights, (n, m), scaled to 0 to 1; those of nearly level ground all lie near 0.5."""
    side = max(float(np.ptp(drawn.x)), float(np.ptp(drawn.y)))
    low, range_ = float(drawn.z.min()), float(np.ptp(drawn.z))
    return 0.5 + (drawn.z - low - range_ / 2) / max(range_, _LEVEL_SHARE * side)
