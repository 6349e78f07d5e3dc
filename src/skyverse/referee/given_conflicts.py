"""Pairs of UAVs whose starts or targets are given too close: what that excuses, and what it does not."""

from collections.abc import Iterator

import numpy as np

from skyverse._typing import Indices
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.pair_motion import FleetSeparation, Intervals, Meeting, SharedPieces
from skyverse.referee.pair_violations import too_close, unproven
from skyverse.referee.polynomial import Polynomials, halve
from skyverse.referee.subdivision import MAX_DEPTH, find_peaks
from skyverse.referee.tolerances import LET_PASS


def given_meetings(fleet: FleetSeparation, pair: Indices) -> tuple[Meeting | None, Meeting | None]:
    """Return the starts, and, where both UAVs fly, the targets of a pair (2,), each where they are given too close."""
    i, j = pair
    scenario, motion = fleet.scenario, fleet.motion
    uavs = [motion.uavs[k] for k in (i, j)]
    starts = Meeting(0.0, *(np.array(scenario.uavs[uav].start) for uav in uavs))
    targets = None
    places = [np.array(scenario.targets[target].position) for uav in uavs if (target := fleet.targets[uav]) is not None]
    if len(places) == 2 and all(len(motion.knots[k]) > 2 for k in (i, j)):
        targets = Meeting(float(max(motion.knots[k][-2] for k in (i, j))), *places)

    def too_near(meeting: Meeting | None) -> Meeting | None:
        return meeting if meeting and fleet.nearness(pair, meeting, let_pass=LET_PASS) < 1 else None

    return too_near(starts), too_near(targets)


def judge_given(
    fleet: FleetSeparation, pair: Indices, starts: Meeting | None, targets: Meeting | None
) -> Iterator[Violation]:
    """Judge a pair (1, 2) whose starts or targets are given too close.

    Until the UAVs first keep their separation, and from when they last keep it, they are excused as long as they are no
    nearer to each other than given.
    """
    end = fleet.motion.end
    near = [fleet.nearness(pair[0], given) if given else np.inf for given in (starts, targets)]
    nearest = starts if starts and near[0] <= near[1] else targets
    if nearest:
        yield too_close(fleet, pair[0], nearest, Fault.GIVEN, ", as their starts or targets are given")
    whole = fleet.common_intervals(*pair[0])
    pieces = fleet.shared_pieces(pair, [whole], 0.0)
    separate = _first_separate(pieces) if starts else 0.0
    together = max(separate, -_first_separate(_reversed(pieces))) if targets else end
    if separate == end:
        near[0] = min(near)  # they never keep their separation, and both ends excuse all of it
    keep = min(fleet.across[*pair[0]], fleet.above[*pair[0]])
    spans = (
        (_within(whole, 0.0, separate), near[0]),
        (_within(whole, separate, together), 1.0),
        (_within(whole, together, end), near[1]),
    )
    some = [(span, share) for span, share in spans if len(span[0]) and share * keep > LET_PASS]
    if some:
        intervals, shares = zip(*some, strict=True)
        pairs = np.repeat(pair, len(some), axis=0)
        within = fleet.shared_pieces(pairs, list(intervals), LET_PASS, np.array(shares))
        peaks = find_peaks(within.excess.b, within.excess.error)
        if not peaks.proven[0]:
            yield unproven(fleet, pair[0], within, peaks, 0)


def _within(intervals: Intervals, begin: float, end: float) -> Intervals:
    """Return the parts of intervals between two instants, seconds."""
    begins, ends = np.maximum(intervals[0], begin), np.minimum(intervals[1], end)
    some = begins < ends
    return begins[some], ends[some]


def _reversed(pieces: SharedPieces) -> SharedPieces:
    """Return the same motion backwards in time."""
    excess = Polynomials(pieces.excess.b[::-1, ::-1], pieces.excess.error[::-1])
    first, second = pieces.pieces
    begins, ends = -pieces.ends[::-1], -pieces.begins[::-1]
    return SharedPieces(pieces.pair, (first[::-1], second[::-1]), begins, ends, excess, pieces.share)


def _first_separate(pieces: SharedPieces) -> float:
    """Return the first instant at which two UAVs keep their separation, or the end of the last interval; seconds."""
    for b, error, begin, end in zip(pieces.excess.b, pieces.excess.error, pieces.begins, pieces.ends, strict=True):
        parts = [(b[None], begin, end, 0)]
        while parts:
            part, begins, ends, depth = parts.pop()
            if (part > error).all():
                continue
            if not part[0, 0] > error or np.ptp(part) <= 2 * error or depth == MAX_DEPTH:
                return float(begins)
            left, right = halve(part)
            middle = (begins + ends) / 2
            parts += [(right, middle, ends, depth + 1), (left, begins, middle, depth + 1)]
    return float(pieces.ends[-1])
