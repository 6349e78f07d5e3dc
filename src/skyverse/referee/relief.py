"""The relief between places and cameras: whether the ground is certain to hide nothing, by its slopes and heights.

Along the way from a place to the camera, the ground rises by no more than its steepest slopes in the blocks of cells on
the way allow, and is nowhere higher than the highest cell there.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Bools, Floats, Indices
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.referee.tolerances import NO_LENGTH

LONGER = 1.3
"""How much farther from the place each piece of a way ends than the one before it."""


class Places(NamedTuple):
    """Places, each anywhere in an upright box.

    Attributes
    ----------
    x, y, radius
        (n,) metres: their middles, and how far they reach along x and y from there.
    low, high
        (n,) metres: the least and the greatest z.
    """

    x: Floats
    y: Floats
    radius: Floats
    low: Floats
    high: Floats

    def of(self, some: Indices | Bools) -> "Places":
        """Return some of them."""
        return Places(*(column[some] for column in self))


@dataclass(frozen=True, eq=False)
class GroundRelief:
    """The greatest heights and slopes of a terrain's cells, of squares of 2 x 2 cells, of 4 x 4, and so on.

    Attributes
    ----------
    origin, step
        (2,) metres.
    shape
        How many cells there are along x and y.
    first, columns
        Where the squares of each size begin in the table, and how many of them are in a row.
    table
        (m, 5) the greatest height, metres, and the greatest slopes along x, along -x, along y and along -y.
    """

    origin: Floats
    step: Floats
    shape: tuple[int, int]
    first: Indices
    columns: Indices
    table: NDArray[np.float32]

    def most(self, low: Floats, high: Floats) -> Floats:
        """Return the greatest height and slopes, (n, 5), of all ground between corners (n, 2), metres."""
        last = np.array(self.shape) - 1
        ends = [np.floor((corner - self.origin) / self.step) for corner in (low, high)]
        a, b = (np.clip(end, 0, last).astype(np.intp) for end in ends)
        level = np.ceil(np.log2(np.maximum((b - a).max(axis=1), 1))).astype(np.intp)
        (i, j), (m, n) = (a >> level[:, None]).T, (b >> level[:, None]).T
        first, columns = self.first[level], self.columns[level]
        found = self.table[first + i * columns + j]
        for row, column in ((m, j), (i, n), (m, n)):
            np.maximum(found, self.table[first + row * columns + column], out=found)
        beyond = ((ends[0] < 0) | (ends[1] > last)).any(axis=1)  # where the ground is level
        found[beyond, 1:] = np.maximum(found[beyond, 1:], 0.0)
        return found.astype(np.float64)

    def hides_nothing(self, places: Places, camera: Floats, error: TrackingError) -> Bools:
        """Return of places (n,) on the ground, or above, whether it is certain not to hide them from a camera (3,)."""
        found = np.zeros(len(places.x), dtype=np.bool_)
        if not len(found):
            return found
        middle, ways = np.column_stack([places.x, places.y]), np.empty((len(found), 2))
        np.subtract(camera[:2], middle, out=ways)
        reach = np.minimum(middle.min(axis=0), camera[:2]), np.maximum(middle.max(axis=0), camera[:2])
        wide = float(places.radius.max()) + error.horizontal
        highest, *slopes = self.most((reach[0] - wide)[None], (reach[1] + wide)[None])[0]
        steepest = np.hypot(max(slopes[0], slopes[1], 0.0), max(slopes[2], slopes[3], 0.0))
        lowest, length = camera[2] - error.vertical, np.hypot(*ways.T)
        found[:] = lowest - places.high >= steepest * (length + error.horizontal + places.radius * np.sqrt(2.0))
        some = np.flatnonzero(~found)
        first = np.maximum(places.radius, self.step.min())[some]
        share, risen, at = np.zeros(len(some)), np.zeros(len(some)), np.zeros(len(some))
        while len(some):
            of, way = places.of(some), ways[some]
            at = np.maximum(at + first, at * LONGER)
            end = np.minimum(at / np.maximum(length[some], NO_LENGTH), 1.0)
            ends = middle[some] + share[:, None] * way, middle[some] + end[:, None] * way
            beside = ((1.0 - share) * of.radius + end * error.horizontal)[:, None]
            top, *slope = self.most(np.minimum(*ends) - beside, np.maximum(*ends) + beside).T
            east, north = np.where(way > 0, np.stack(slope[::2], axis=1), np.stack(slope[1::2], axis=1)).T
            astray = np.maximum(slope[0], slope[1]) + np.maximum(slope[2], slope[3])
            rise = east * np.abs(way[:, 0]) + north * np.abs(way[:, 1]) + (of.radius + error.horizontal) * astray
            height = lowest - of.high
            above = [(1.0 - s) * of.low + s * lowest for s in (share, end)]
            after = risen + (end - share) * rise
            clear = ((risen <= share * height) & (after <= end * height)) | (top <= np.minimum(*above))
            over = clear & ((end >= 1.0) | ((above[1] >= highest) & (height > 0)))
            found[some[over]] = True
            going = clear & ~over
            some, share, first, at = some[going], end[going], first[going], at[going]
            risen = np.minimum(after, top - of.low)[going]
        return found


def relief_of(terrain: Terrain) -> GroundRelief:
    """Return the relief of a terrain."""
    h, step = terrain.heights, np.array(terrain.step)
    east, north = np.diff(h, axis=0) / step[0], np.diff(h, axis=1) / step[1]
    highest = np.maximum(np.maximum(h[:-1, :-1], h[1:, :-1]), np.maximum(h[:-1, 1:], h[1:, 1:]))
    steepest = [
        np.maximum(s * a, s * b) for a, b in ((east[:, :-1], east[:, 1:]), (north[:-1], north[1:])) for s in (1, -1)
    ]
    cells = np.stack([highest, *steepest], axis=2)
    levels = [np.nextafter(cells.astype(np.float32), np.float32(np.inf))]
    while max(levels[-1].shape[:2]) > 1:
        even = np.pad(levels[-1], [(0, n % 2) for n in levels[-1].shape[:2]] + [(0, 0)], mode="edge")
        levels.append(even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2, 5).max(axis=(1, 3)))
    sizes = [level.shape[0] * level.shape[1] for level in levels]
    table = np.concatenate([level.reshape(-1, 5) for level in levels])
    first, columns = np.cumsum([0, *sizes[:-1]]), np.array([level.shape[1] for level in levels])
    return GroundRelief(np.array(terrain.origin), step, (h.shape[0] - 1, h.shape[1] - 1), first, columns, table)
