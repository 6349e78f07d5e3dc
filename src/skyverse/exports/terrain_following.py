"""Between which altitudes a UAV is that follows the ground, as autopilots do with altitudes above ground.

Its height above ground changes linearly from waypoint to waypoint, and the ground is that of where it is. Which ground
an autopilot knows is uncertain: any between the terrain's `lowest` and its `heights`. Where the UAV is, is uncertain,
too: it may be beside its leg, and then the ground is another one.

Points are given here as x, y and the height above `Terrain.heights`, as waypoints have them in the file.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.exports.ground_under_legs import lowered
from skyverse.exports.obstacle_search import growth_of
from skyverse.model.quantities import derived
from skyverse.model.shapes import Terrain
from skyverse.model.uav import TrackingError
from skyverse.space.tube import raised

FINE = 0.05
"""Metres: the ground under a piece of a leg is no farther off a straight line, if pieces can be cut so short."""
MOST_CUTS = 32
"""The most parts into which a leg is cut within one cell of the terrain."""


class GroundNearby(NamedTuple):
    """What the ground is at most within some metres of each place, with and without the tracking error.

    Attributes
    ----------
    highest, lowest
        Surfaces that are nowhere below the highest of all possible grounds nearby, and nowhere above the lowest.
    gap
        How much lower a possible ground nearby is, at most, than another one at the same place.
    slope, lowest_slope
        How steep the ground nearby is at most, and the lowest ground: metres for each metre.
    """

    highest: Terrain
    lowest: Terrain
    gap: Terrain
    slope: Terrain
    lowest_slope: Terrain


def ground_nearby(terrain: Terrain, near: float, error: TrackingError) -> GroundNearby:
    """Return what the ground is within `near` metres of each place and the error."""
    radius = near + error.horizontal
    reach = TrackingError(horizontal=radius)
    lowest = terrain.lowest_ground
    highest, deepest = raised(terrain, reach), lowered(lowest, reach)
    assert highest is not None
    level = derived(highest, heights=terrain.heights - lowest.heights, lowest=None)
    gap = level if lowest is terrain else raised(level, reach)
    assert gap is not None
    slope, lowest_slope = (
        derived(level, heights=more / radius)
        for more in (highest.heights - terrain.heights, lowest.heights - deepest.heights)
    )
    return GroundNearby(highest, deepest, gap, slope, lowest_slope)


class Lines(NamedTuple):
    """Straight lines whose height above ground changes linearly.

    Attributes
    ----------
    starts, ends
        (n, 3): x, y and the height above `Terrain.heights`, metres.
    sink
        How much lower they may begin, metres: at their ends it is 0.
    """

    starts: Floats
    ends: Floats
    sink: float = 0.0

    def places(self, line: Indices, share: Floats) -> Floats:
        """Return the points (..., 3) at shares (...) of lines (...)."""
        return self.starts[line] + share[..., None] * (self.ends - self.starts)[line]


class Band(NamedTuple):
    """An upright band along lines, which holds all altitudes that are flown; it is cut into pieces.

    Attributes
    ----------
    lines
        As given.
    line
        (m,) the line of each piece; the pieces of a line follow one another.
    shares
        (m, 2) where each piece begins and ends, as shares of the line.
    low, high
        (m, 2) z of the lower and of the upper edge at the begin and the end of each piece, metres; edges are straight.
    """

    lines: Lines
    line: Indices
    shares: Floats
    low: Floats
    high: Floats


class Strips(NamedTuple):
    """Parts of a band.

    Attributes
    ----------
    first, stop
        (k,) the first piece of each, and the one after its last.
    bottom, top
        (k,) shares of the band's thickness.
    """

    first: Indices
    stop: Indices
    bottom: Floats
    top: Floats

    @classmethod
    def of_lines(cls, band: Band) -> "Strips":
        """Return one strip for each line."""
        first = np.flatnonzero(np.r_[True, np.diff(band.line) > 0])
        return cls(first, np.r_[first[1:], len(band.line)], np.zeros(len(first)), np.ones(len(first)))

    @classmethod
    def middles(cls, band: Band) -> "Strips":
        """Return the middle of each piece, which has no thickness."""
        every, half = np.arange(len(band.line)), np.full(len(band.line), 0.5)
        return cls(every, every + 1, half, half)

    def of(self, some: NDArray[np.bool_]) -> "Strips":
        """Return some of the strips."""
        return Strips._make(column[some] for column in self)

    def quartered(self) -> "Strips":
        """Return the strips cut in four: along the line where there are several pieces, else in thickness."""
        count, long = self.stop - self.first, self.stop - self.first > 1
        parts = []
        for k in range(4):
            first = np.where(long, self.first + count * k // 4, self.first)
            stop = np.where(long, self.first + count * (k + 1) // 4, self.stop)
            bottom, top = (self.bottom + (self.top - self.bottom) * j / 4 for j in (k, k + 1))
            parts.append(Strips(first, stop, np.where(long, self.bottom, bottom), np.where(long, self.top, top)))
        joined = Strips._make(np.concatenate(columns) for columns in zip(*parts, strict=True))
        return joined.of(joined.stop > joined.first)


def covered(band: Band, strips: Strips) -> tuple[Floats, Floats, Floats]:
    """Return straight segments through strips, (k, 3) metres from and to, and how far the strips are above or below."""
    count = strips.stop - strips.first
    of, heads = np.repeat(np.arange(len(count)), count), np.cumsum(count) - count
    piece = strips.first[of] + np.arange(count.sum()) - heads[of]
    shares, thick = band.shares[piece], (band.high - band.low)[piece]
    middle = band.low[piece] + ((strips.bottom + strips.top) / 2)[of, None] * thick
    half = ((strips.top - strips.bottom) / 2)[of, None] * thick
    begin, end = shares[heads, 0], shares[heads + count - 1, 1]
    low, high = middle[heads, 0], middle[heads + count - 1, 1]
    along = (shares - begin[of, None]) / (end - begin)[of, None]
    off = middle - low[of, None] - along * (high - low)[of, None]
    above = np.maximum.reduceat((off + half).max(axis=1), heads)
    below = np.maximum.reduceat((half - off).max(axis=1), heads)
    line, lift = band.line[strips.first], (above - below) / 2
    starts, ends = band.lines.places(line, begin), band.lines.places(line, end)
    starts[:, 2], ends[:, 2] = low + lift, high + lift
    return starts, ends, (above + below) / 2


@dataclass(frozen=True, eq=False)
class TerrainFollowing:
    """The altitudes and heights of flights that follow one terrain.

    Attributes
    ----------
    terrain
        As given.
    error
        How far the flown position may be from the nominal one.
    """

    terrain: Terrain
    error: TrackingError
    _nearby: dict[tuple[float, bool], GroundNearby] = field(default_factory=dict)

    def nearby(self, near: float, strays: bool) -> GroundNearby:
        """Return what the ground is within `near` metres, or a little more, and the error where that counts."""
        key = growth_of(near), strays
        if key not in self._nearby:
            self._nearby[key] = ground_nearby(self.terrain, key[0], self.error if strays else TrackingError())
        return self._nearby[key]

    def above(self, points: Floats) -> Floats:
        """Return points (n, 3) metres with their heights above ground instead of z."""
        return np.column_stack([points[:, :2], points[:, 2] - self.terrain.height(points[:, :2])])

    def band(self, lines: Lines, near: float, strays: bool) -> Band:
        """Return the altitudes that may be flown along lines, by a UAV that is within `near` metres of them."""
        ground = self.nearby(near, strays)
        line, shares = pieces(self.terrain, lines)
        for last in (False, True):
            at = np.column_stack([shares[:, 0], shares.mean(axis=1), shares[:, 1]])
            places = lines.places(line[:, None], at)
            edges = np.stack([surface.height(places[..., :2]) for surface in (ground.lowest, ground.highest)])
            sag = np.abs(edges[..., 0] - 2 * edges[..., 1] + edges[..., 2]) / 2  # of what is quadratic in a piece
            cuts = np.minimum(np.ceil(np.sqrt(sag.max(axis=0) / FINE)), MOST_CUTS).astype(np.intp)
            if last or cuts.max() <= 1:
                break
            line, shares = _cut(line, shares, np.maximum(cuts, 1))
        low, high = edges[..., ::2] + [[[-1]], [[1]]] * sag[..., None] + places[:, ::2, 2]
        return Band(lines, line, shares, low - lines.sink * (1 - shares), high)

    def least(self, lines: Lines, taken: Terrain) -> tuple[float, Floats]:
        """Return the least of the lines' heights above ground less what a surface takes; and where that is, (3,) m."""
        line, shares = pieces(self.terrain, lines)
        at = np.column_stack([shares[:, 0], shares.mean(axis=1), shares[:, 1]])
        places = lines.places(line[:, None], at)
        left = places[..., 2] - lines.sink * (1 - at) - taken.height(places[..., :2])
        sag = np.abs(left[:, 0] - 2 * left[:, 1] + left[:, 2]) / 8
        k, j = np.unravel_index(int(np.argmin(left - sag[:, None])), left.shape)
        place = places[k, j]
        return float(left[k, j] - sag[k]), np.r_[place[:2], place[2] + self.terrain.height(place[:2])]


def pieces(terrain: Terrain, lines: Lines) -> tuple[Indices, Floats]:
    """Return pieces of lines that cross no line of a terrain's grid: the line of each, (m,), and its shares, (m, 2)."""
    count = len(lines.starts)
    line, share = [np.repeat(np.arange(count), 2)], [np.tile([0.0, 1.0], count)]
    for axis in range(2):
        last = terrain.heights.shape[axis] - 1
        a, b = ((ends[:, axis] - terrain.origin[axis]) / terrain.step[axis] for ends in (lines.starts, lines.ends))
        first = np.ceil(np.clip(np.minimum(a, b), 0, last))
        crossed = np.floor(np.clip(np.maximum(a, b), 0, last)) - first + 1
        times = np.where(a == b, 0, np.maximum(crossed, 0)).astype(np.intp)
        of = np.repeat(np.arange(count), times)
        index = first[of] + np.arange(times.sum()) - (np.cumsum(times) - times)[of]
        line.append(of)
        share.append((index - a[of]) / (b - a)[of])
    lines_of, shares = np.concatenate(line), np.clip(np.concatenate(share), 0.0, 1.0)
    order = np.lexsort((shares, lines_of))
    lines_of, shares = lines_of[order], shares[order]
    some = (lines_of[1:] == lines_of[:-1]) & (shares[1:] > shares[:-1])
    return lines_of[:-1][some], np.column_stack([shares[:-1], shares[1:]])[some]


def _cut(line: Indices, shares: Floats, cuts: Indices) -> tuple[Indices, Floats]:
    """Return pieces cut into equal parts, (m,) numbers of which are given."""
    of = np.repeat(np.arange(len(line)), cuts)
    number = np.arange(cuts.sum()) - (np.cumsum(cuts) - cuts)[of]
    size = (shares[:, 1] - shares[:, 0]) / cuts
    begin = shares[of, 0] + number * size[of]
    end = np.where(number + 1 == cuts[of], shares[of, 1], begin + size[of])
    return line[of], np.column_stack([begin, end])
