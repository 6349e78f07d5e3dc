"""Two UAVs of a fleet: how near they are to each other, as a share of the separation that they must keep.

With semi-axes h and v, the larger ones of both UAVs, the nearness is sqrt((dx^2 + dy^2) / h^2 + dz^2 / v^2); it is 1 on
the ellipsoid of separation and 0 where both are at one place.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.referee.fleet_motion import FleetMotion, time_slices
from skyverse.referee.polynomial import Polynomials, squared
from skyverse.referee.tolerances import LET_PASS, TWO_ROUNDINGS

Intervals = tuple[Floats, Floats]
"""When intervals begin and end, (n,) seconds each."""


class Meeting(NamedTuple):
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
    scenario, targets
        What was given, and the index of each UAV's target, ``None`` for those without one.
    motion, edges
        The motion, and the edges of slices of time, seconds.
    across, above
        (n, n) metres to be kept horizontally and vertically; 0 where nothing must be kept.
    """

    scenario: Scenario
    targets: Sequence[int | None]
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
        nearness = squared([_divided(x, level), _divided(y, level), _divided(z, upright)])
        return SharedPieces(of, (first, second), begins, ends, nearness * -1.0 + 1.0, share)

    def meeting(self, pieces: SharedPieces, interval: int, fraction: float) -> Meeting:
        """Return where the two UAVs of an interval are at a fraction of it."""
        begin, end = pieces.begins[interval], pieces.ends[interval]
        time = np.array([begin + fraction * (end - begin)])
        first, second = (self.motion.shifted(piece[[interval]], time)[0, 0] for piece in pieces.pieces)
        return Meeting(float(time[0]), first, second)

    def nearness(self, pair: Indices, meeting: Meeting, share: float = 1.0, let_pass: float = 0.0) -> float:
        """Return how near two UAVs are, relative to a share of their separation less what is let pass, metres."""
        across, above = share * self.across[*pair] - let_pass, share * self.above[*pair] - let_pass
        return math.hypot(*((meeting.first - meeting.second) / [across, across, above]))


def fleet_separation(scenario: Scenario, targets: Sequence[int | None], motion: FleetMotion) -> FleetSeparation:
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
    return FleetSeparation(scenario, targets, motion, time_slices(motion), keep[..., 0], keep[..., 1])


def _divided(part: Polynomials, by: Floats) -> Polynomials:
    """Return each row of polynomials divided by a number, (n,)."""
    return Polynomials(part.b / by[:, None], part.error / by + TWO_ROUNDINGS * part.size / by)
