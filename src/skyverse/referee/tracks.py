"""Where the whole fleet is at every instant: trajectories, and standing still before and after them."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.referee.curve import Curve
from skyverse.referee.polynomial import EPS, Polynomials, bernstein

SLICES = 256


class Tracks(NamedTuple):
    """The fleet's motion from 0 to when all have stood still for a second.

    Attributes
    ----------
    uavs
        Which UAVs these are: those of which the motion is known.
    knots
        Of each UAV, (n + 1,) seconds, from 0 to the common end.
    first
        Of each UAV, the index of its first piece.
    begins, pieces
        (p,) seconds, and (p, degree + 1, 3) metres: all UAVs' pieces, one after another.
    """

    uavs: list[int]
    knots: list[Floats]
    first: list[int]
    begins: Floats
    pieces: Floats

    @property
    def end(self) -> float:
        """The common end, seconds."""
        return float(self.knots[0][-1])

    def piece(self, k: int, instants: Floats) -> Indices:
        """Return which pieces the k-th UAV flies right after some instants."""
        piece: Indices = self.first[k] + np.searchsorted(self.knots[k][:-1], instants, side="right") - 1
        return piece

    def begun_at(self, piece: Indices, instants: Floats) -> Floats:
        """Return pieces (m,) in the time since other instants (m,): Taylor's shift."""
        rows, since = self.pieces[piece], (instants - self.begins[piece])[:, None]
        degree = rows.shape[1] - 1
        for i in range(degree):
            for j in range(degree - 1, i - 1, -1):
                rows[:, j] += since * rows[:, j + 1]
        return rows

    def shift_error(self, piece: Indices, ends: Floats) -> Floats:
        """Return what a shift may have got wrong on pieces (m,) until `ends`, (m, 3) metres."""
        until = (ends - self.begins[piece])[:, None, None] ** np.arange(self.pieces.shape[1])[None, :, None]
        error: Floats = 4 * self.pieces.shape[1] * EPS * np.sum(np.abs(self.pieces[piece]) * until, axis=1)
        return error

    def cells(self, k: int, edges: Floats) -> list[Polynomials]:
        """Return x, y, z of the k-th UAV between edges (n + 1,), among which all its knots there must be."""
        piece = self.piece(k, edges[:-1])
        parts = bernstein(self.begun_at(piece, edges[:-1]), np.diff(edges))
        return _with(parts, self.shift_error(piece, edges[1:]))


def _with(parts: list[Polynomials], error: Floats) -> list[Polynomials]:
    return [Polynomials(part.b, part.error + error[:, axis]) for axis, part in enumerate(parts)]


def relative(tracks: Tracks, first: Indices, second: Indices, begins: Floats, ends: Floats) -> list[Polynomials]:
    """Return x, y, z from one to another of (m,) pairs of pieces, between instants."""
    rows = tracks.begun_at(first, begins) - tracks.begun_at(second, begins)
    error = tracks.shift_error(first, ends) + tracks.shift_error(second, ends)
    return _with(bernstein(rows, ends - begins), error)


def tracks_of(scenario: Scenario, curves: Sequence[Curve | None], unknown: set[int]) -> Tracks:
    """Return the motion of all but the `unknown`; those without a curve stand at their start."""
    end = max((curve.knots[-1] for curve in curves if curve is not None), default=0.0) + 1.0
    uavs = [uav for uav in range(len(scenario.uavs)) if uav not in unknown]
    degree = max((curve.pieces.shape[1] for curve in curves if curve is not None), default=1)
    knots: list[Floats] = []
    first: list[int] = []
    begins: list[Floats] = []
    pieces: list[Floats] = []
    for uav in uavs:
        curve = curves[uav]
        place = np.zeros((1, degree, 3))
        place[0, 0] = scenario.uavs[uav].start
        times, rows = np.array([0.0]), [place]
        if curve is not None:
            times, rows = curve.knots, [np.pad(curve.pieces, ((0, 0), (0, degree - curve.pieces.shape[1]), (0, 0)))]
            if times[0] > 0:
                times, rows = np.r_[0.0, times], [place, *rows]
            parked = np.zeros((1, degree, 3))
            parked[0, 0] = curve.motion(len(curve.pieces) - 1, float(curve.durations[-1]))[0]
            rows.append(parked)
        first.append(sum(len(row) for row in pieces))
        knots.append(np.r_[times, end])
        begins.append(times)
        pieces.append(np.concatenate(rows))
    if not uavs:
        return Tracks([], [], [], np.zeros(0), np.zeros((0, degree, 3)))
    return Tracks(uavs, knots, first, np.concatenate(begins), np.concatenate(pieces))


def time_slices(tracks: Tracks) -> Floats:
    """Return the edges of at most so many slices of time, each with about as many knots."""
    edges = np.unique(np.concatenate(tracks.knots))
    some: Floats = edges[np.unique(np.linspace(0, len(edges) - 1, SLICES + 1).round().astype(int))]
    return some


def near_pairs(tracks: Tracks, edges: Floats, across: Floats, above: Floats) -> Iterator[Indices]:
    """Yield (m, 3) indices of two UAVs and a slice of time in which their boxes come too close.

    `across` and `above` are (n, n) metres to be kept between each two, 0 where none are.
    """
    low, high = np.empty((2, len(tracks.uavs), len(edges) - 1, 3))
    for k, knots in enumerate(tracks.knots):
        cuts = np.union1d(edges, knots)
        inside = np.searchsorted(cuts[:-1], edges[:-1])  # every slice begins at a cut
        for axis, part in enumerate(tracks.cells(k, cuts)):
            low[k, :, axis] = np.minimum.reduceat(part.b.min(axis=1) - part.error, inside)
            high[k, :, axis] = np.maximum.reduceat(part.b.max(axis=1) + part.error, inside)
    matter = np.triu(across > 0, 1)
    for s in range(len(edges) - 1):
        i, j = np.nonzero(matter & ~(low[:, None, s, 0] - high[None, :, s, 0] >= across))
        for axis, keep in ((0, across), (1, across), (2, above)):
            apart = (low[i, s, axis] - high[j, s, axis] >= keep[i, j]) | (
                low[j, s, axis] - high[i, s, axis] >= keep[i, j]
            )
            i, j = i[~apart], j[~apart]
        yield np.column_stack([i, j, np.full(len(i), s)])
