"""Where the whole fleet is at every instant, and how near two of its UAVs are to each other.

UAVs stand still before and after their trajectories. With semi-axes h and v, the larger ones of two UAVs, their
nearness is sqrt((dx^2 + dy^2) / h^2 + dz^2 / v^2); it is 1 on the ellipsoid of separation and 0 where both are at one
place.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.timed_shapes import JUDGED_STAY
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.polynomial import Polynomials, bernstein, squared
from skyverse.referee.tolerances import LET_PASS, MACHINE_EPSILON

MAX_SLICES = 256
"""Slices of time in which the boxes about the UAVs' motions are compared."""


class FleetMotion(NamedTuple):
    """The fleet's motion from 0 s until a while after the last UAV has arrived.

    Attributes
    ----------
    uavs
        The indices of the UAVs whose motion is known.
    knots
        Of each UAV, (n + 1,) seconds, from 0 to the common end.
    first
        Of each UAV, the index of its first piece.
    begins, pieces
        (p,) seconds, and (p, degree + 1, 3) metres: all UAVs' pieces, one UAV's after another's.
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
        """Return the indices of the pieces that the k-th UAV flies right after instants."""
        return self.first[k] + np.searchsorted(self.knots[k][:-1], instants, side="right") - 1

    def shifted(self, piece: Indices, instants: Floats) -> Floats:
        """Return pieces (m,) as polynomials of the time since other instants (m,), by Taylor's shift."""
        rows, since = self.pieces[piece], (instants - self.begins[piece])[:, None]
        degree = rows.shape[1] - 1
        for i in range(degree):
            for j in range(degree - 1, i - 1, -1):
                rows[:, j] += since * rows[:, j + 1]
        return rows

    def shift_error(self, piece: Indices, ends: Floats) -> Floats:
        """Return bounds (m, 3) on the rounding errors of shifted pieces (m,) until `ends`, (m,) seconds; metres."""
        until = (ends - self.begins[piece])[:, None, None] ** np.arange(self.pieces.shape[1])[None, :, None]
        return 4 * self.pieces.shape[1] * MACHINE_EPSILON * np.sum(np.abs(self.pieces[piece]) * until, axis=1)

    def positions_between(self, k: int, edges: Floats) -> list[Polynomials]:
        """Return x, y, z of the k-th UAV between consecutive edges (n + 1,), which must include all its knots."""
        piece = self.piece(k, edges[:-1])
        parts = bernstein(self.shifted(piece, edges[:-1]), np.diff(edges))
        return _with_error(parts, self.shift_error(piece, edges[1:]))

    def difference(self, first: Indices, second: Indices, begins: Floats, ends: Floats) -> list[Polynomials]:
        """Return x, y, z from second to first pieces of (m,) pairs, between instants (m,), seconds."""
        rows = self.shifted(first, begins) - self.shifted(second, begins)
        error = self.shift_error(first, ends) + self.shift_error(second, ends)
        return _with_error(bernstein(rows, ends - begins), error)


def _with_error(parts: list[Polynomials], error: Floats) -> list[Polynomials]:
    """Return x, y, z with errors (n, 3) added to those that they have."""
    return [Polynomials(part.b, part.error + error[:, axis]) for axis, part in enumerate(parts)]


def judged_until(curves: Sequence[PolynomialCurve | None], stay: float = JUDGED_STAY) -> float:
    """Return the instant, in seconds, until which a fleet is judged: `stay` seconds after its last arrival."""
    return float(max((curve.knots[-1] for curve in curves if curve is not None), default=0.0)) + stay


def fleet_motion(
    scenario: Scenario, curves: Sequence[PolynomialCurve | None], unknown: set[int], stay: float = JUDGED_STAY
) -> FleetMotion:
    """Return the motion of all UAVs except the `unknown` ones; a UAV without a curve stands at its start.

    It ends `stay` seconds after the last UAV has arrived.
    """
    end = judged_until(curves, stay)
    uavs = [uav for uav in range(len(scenario.uavs)) if uav not in unknown]
    degree = max((curve.pieces.shape[1] for curve in curves if curve is not None), default=1)
    knots: list[Floats] = []
    first: list[int] = []
    begins: list[Floats] = []
    pieces: list[Floats] = []
    for uav in uavs:
        curve = curves[uav]
        waiting = np.zeros((1, degree, 3))
        waiting[0, 0] = scenario.uavs[uav].start
        times, rows = np.array([0.0]), [waiting]
        if curve is not None:
            times, rows = curve.knots, [np.pad(curve.pieces, ((0, 0), (0, degree - curve.pieces.shape[1]), (0, 0)))]
            if times[0] > 0:
                times, rows = np.r_[0.0, times], [waiting, *rows]
            parked = np.zeros((1, degree, 3))
            parked[0, 0] = curve.motion(len(curve.pieces) - 1, float(curve.durations[-1]))[0]
            rows.append(parked)
        first.append(sum(len(row) for row in pieces))
        knots.append(np.r_[times, end])
        begins.append(times)
        pieces.append(np.concatenate(rows))
    if not uavs:
        return FleetMotion([], [], [], np.zeros(0), np.zeros((0, degree, 3)))
    return FleetMotion(uavs, knots, first, np.concatenate(begins), np.concatenate(pieces))


def time_slices(motion: FleetMotion) -> Floats:
    """Return the edges of at most `MAX_SLICES` slices of time, each with about as many knots as any other; seconds."""
    edges = np.unique(np.concatenate(motion.knots))
    return edges[np.unique(np.linspace(0, len(edges) - 1, MAX_SLICES + 1).round().astype(int))]


def slice_boxes(motion: FleetMotion, edges: Floats) -> Floats:
    """Return low and high corners (2, k, n, 3), metres, of boxes about each UAV in slices of time, by their edges."""
    low, high = corners = np.empty((2, len(motion.uavs), len(edges) - 1, 3))
    for k, knots in enumerate(motion.knots):
        cuts = np.union1d(edges, knots)
        inside = np.searchsorted(cuts[:-1], edges[:-1])  # every slice begins at a cut
        for axis, part in enumerate(motion.positions_between(k, cuts)):
            low[k, :, axis] = np.minimum.reduceat(part.b.min(axis=1) - part.error, inside)
            high[k, :, axis] = np.maximum.reduceat(part.b.max(axis=1) + part.error, inside)
    return corners


def near_pairs(motion: FleetMotion, edges: Floats, across: Floats, above: Floats) -> Iterator[Indices]:
    """Yield (m, 3) indices of two UAVs and of a slice of time in which boxes about their motions come too close.

    Parameters
    ----------
    motion
        The fleet's motion.
    edges
        (n + 1,) seconds, the edges of the slices.
    across, above
        (k, k) metres to be kept horizontally and vertically between each two UAVs; 0 where nothing must be kept.
    """
    low, high = slice_boxes(motion, edges)
    matter = np.triu(across > 0, 1)
    for s in range(len(edges) - 1):
        i, j = np.nonzero(matter & ~(low[:, None, s, 0] - high[None, :, s, 0] >= across))
        for axis, keep in ((0, across), (1, across), (2, above)):
            separate = (low[i, s, axis] - high[j, s, axis] >= keep[i, j]) | (
                low[j, s, axis] - high[i, s, axis] >= keep[i, j]
            )
            i, j = i[~separate], j[~separate]
        yield np.column_stack([i, j, np.full(len(i), s)])


Intervals = tuple[Floats, Floats]
"""When intervals begin and end, (n,) seconds each."""


class PairPositions(NamedTuple):
    """An instant, seconds, and where two UAVs are then, (3,) metres, evaluated without Bernstein coefficients."""

    time: float
    first: Floats
    second: Floats


class SharedPieces(NamedTuple):
    """Intervals of time in each of which two UAVs fly one piece each.

    Attributes
    ----------
    pair
        (m,) the question that the interval belongs to.
    pieces
        (m,) and (m,) the pieces of both UAVs.
    begins, ends
        (m,) seconds.
    excess
        1 - (nearness / share)^2 of the m intervals.
    share
        (m,) share of the separation that must be kept.
    """

    pair: Indices
    pieces: tuple[Indices, Indices]
    begins: Floats
    ends: Floats
    excess: Polynomials
    share: Floats


class FleetSeparation(NamedTuple):
    """The fleet's motion and the separation of each two of its UAVs, which are numbered as in the motion.

    Attributes
    ----------
    scenario, ends
        What was given, and where each UAV's flight must end, (3,) metres, ``None`` for those without a target.
    motion, edges
        The motion, and the edges of slices of time, seconds.
    across, above
        (n, n) metres to be kept horizontally and vertically; 0 where nothing must be kept.
    """

    scenario: Scenario
    ends: Sequence[tuple[float, float, float] | None]
    motion: FleetMotion
    edges: Floats
    across: Floats
    above: Floats

    def common_intervals(self, i: int, j: int) -> Intervals:
        """Return the intervals between all knots of two UAVs and all edges of slices."""
        edges = np.unique(np.concatenate([self.motion.knots[i], self.motion.knots[j], self.edges]))
        return edges[:-1], edges[1:]

    def shared_pieces(
        self, pairs: Indices, intervals: list[Intervals], let_pass: float, shares: Floats | float = 1.0
    ) -> SharedPieces:
        """Return what (n, 2) pairs fly in intervals of each, where they must keep (n,) shares of the separation.

        Both semi-axes are taken shorter by `let_pass`, metres.
        """
        of = np.repeat(np.arange(len(pairs)), [len(begins) for begins, _ in intervals])
        begins, ends = (np.concatenate(column) for column in zip(*intervals, strict=True))
        first, second = (
            np.concatenate(
                [self.motion.piece(pair[side], some) for pair, (some, _) in zip(pairs, intervals, strict=True)]
            )
            for side in (0, 1)
        )
        x, y, z = self.motion.difference(first, second, begins, ends)
        i, j = pairs[of].T
        share = np.broadcast_to(shares, len(pairs))[of]
        level, upright = share * self.across[i, j] - let_pass, share * self.above[i, j] - let_pass
        wide, tall = (Polynomials(1.0 / axis[:, None], 2 * MACHINE_EPSILON / axis) for axis in (level, upright))
        nearness = squared([x * wide, y * wide, z * tall])
        return SharedPieces(of, (first, second), begins, ends, nearness * -1.0 + 1.0, share)

    def meeting(self, pieces: SharedPieces, interval: int, fraction: float) -> PairPositions:
        """Return where the two UAVs of an interval are at a fraction of it."""
        begin, end = pieces.begins[interval], pieces.ends[interval]
        time = np.array([begin + fraction * (end - begin)])
        first, second = (self.motion.shifted(piece[[interval]], time)[0, 0] for piece in pieces.pieces)
        return PairPositions(float(time[0]), first, second)

    def nearness(self, pair: Indices, meeting: PairPositions, share: float = 1.0, let_pass: float = 0.0) -> float:
        """Return how near two UAVs are, relative to a share of their separation less what is let pass, metres."""
        across, above = share * self.across[*pair] - let_pass, share * self.above[*pair] - let_pass
        return math.hypot(*((meeting.first - meeting.second) / [across, across, above]))


def fleet_separation(
    scenario: Scenario, ends: Sequence[tuple[float, float, float] | None], motion: FleetMotion
) -> FleetSeparation:
    """Return the separation of each two UAVs whose motion is known: the larger one, grown by both tracking errors.

    The difference of the flown positions is within an upright cylinder about the difference of the nominal ones. Its
    radius h and half its height v are the sums of both errors. An ellipsoid through its rim that has the shape of the
    separation, with semi-axes a and b, is s = hypot(h / a, v / b) times as large as the separation. What is outside of
    1 + s times the separation is outside of the separation wherever both UAVs are within their errors.
    """
    ellipsoids = np.array([scenario.uavs[uav].ellipsoid for uav in motion.uavs])
    keep = np.maximum(ellipsoids[:, None], ellipsoids[None])
    strays = [scenario.uavs[uav].tracking_error for uav in motion.uavs]
    errors = np.reshape([(stray.horizontal, stray.vertical) for stray in strays], (len(strays), 2))
    keep[(keep <= LET_PASS).any(axis=2)] = 0.0  # without a separation none is kept
    rim = np.divide(errors[:, None] + errors[None], keep, np.zeros_like(keep), where=keep > 0)
    keep *= 1.0 + np.hypot(rim[..., :1], rim[..., 1:])
    return FleetSeparation(scenario, ends, motion, time_slices(motion), keep[..., 0], keep[..., 1])
