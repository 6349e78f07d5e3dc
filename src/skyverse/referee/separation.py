"""Judges whether all UAVs keep their separation: of each two, one stays out of an ellipsoid about the other."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from skyverse._typing import Indices
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.fleet_motion import (
    FleetSeparation,
    Intervals,
    PairPositions,
    SharedPieces,
    fleet_motion,
    fleet_separation,
    near_pairs,
)
from skyverse.referee.judgement import Judgement, position_text, position_tuple
from skyverse.referee.overlaps import blocks
from skyverse.referee.polynomial import Polynomials, halve
from skyverse.referee.subdivision import MAX_DEPTH, Peaks, find_peaks
from skyverse.referee.tolerances import LET_PASS

PAIRS_AT_ONCE = 2000
"""Pairs of UAVs judged together, which bounds the memory."""


def judge_separation(
    scenario: Scenario,
    ends: Sequence[tuple[float, float, float] | None],
    curves: Sequence[PolynomialCurve | None],
    unknown: set[int],
) -> Judgement:
    """Judge every pair of UAVs at every instant.

    Parameters
    ----------
    scenario
        What was given.
    ends, curves
        Where each UAV's flight must end, (3,) metres, and its motion; ``None`` where it has none.
    unknown
        The UAVs whose motion is not known; they are left out.
    """
    motion = fleet_motion(scenario, curves, unknown)
    if len(motion.uavs) < 2:
        return Judgement([], 0)
    fleet = fleet_separation(scenario, ends, motion)
    near = np.concatenate(list(near_pairs(motion, fleet.edges, fleet.across, fleet.above)))
    order = np.lexsort(near.T[::-1])
    pairs, begins = np.unique(near[order, :2], axis=0, return_index=True)
    slices = np.split(near[order, 2], begins[1:])
    violations: list[Violation] = []
    halvings = 0
    for block in blocks(len(pairs), PAIRS_AT_ONCE):
        judged = _judge_pairs(fleet, pairs[block], slices[block])
        violations += judged.violations
        halvings += judged.halvings
    return Judgement(violations, halvings)


def _judge_pairs(fleet: FleetSeparation, pairs: Indices, slices: list[Indices]) -> Judgement:
    """Judge (n, 2) pairs, each in some slices of time."""
    intervals = []
    for (i, j), some in zip(pairs, slices, strict=True):
        begins, ends = fleet.common_intervals(i, j)
        wanted = np.zeros(len(fleet.edges), dtype=bool)
        wanted[some] = True
        inside = wanted[np.searchsorted(fleet.edges, begins, side="right") - 1]
        intervals.append((begins[inside], ends[inside]))
    pieces = fleet.shared_pieces(pairs, intervals, LET_PASS)
    peaks = find_peaks(pieces.excess.b, pieces.excess.error, question=pieces.pair, questions=len(pairs))
    violations: list[Violation] = []
    for k in np.flatnonzero(~peaks.proven):
        starts, targets = _given_meetings(fleet, pairs[k]) if peaks.refuted[k] else (None, None)
        if starts or targets:
            violations += _judge_given(fleet, pairs[k : k + 1], starts, targets)
        else:
            violations.append(_unproven(fleet, pairs[k], pieces, peaks, int(k)))
    return Judgement(violations, int(peaks.halvings.sum()))


def _given_meetings(fleet: FleetSeparation, pair: Indices) -> tuple[PairPositions | None, PairPositions | None]:
    """Return the starts, and, where both UAVs fly, the ends of a pair (2,), each where they are given too close."""
    i, j = pair
    scenario, motion = fleet.scenario, fleet.motion
    uavs = [motion.uavs[k] for k in (i, j)]
    starts = PairPositions(0.0, *(np.array(scenario.uavs[uav].start) for uav in uavs))
    targets = None
    places = [np.array(end) for uav in uavs if (end := fleet.ends[uav]) is not None]
    if len(places) == 2 and all(len(motion.knots[k]) > 2 for k in (i, j)):
        targets = PairPositions(float(max(motion.knots[k][-2] for k in (i, j))), *places)

    def too_near(meeting: PairPositions | None) -> PairPositions | None:
        return meeting if meeting and fleet.nearness(pair, meeting, let_pass=LET_PASS) < 1 else None

    return too_near(starts), too_near(targets)


def _judge_given(
    fleet: FleetSeparation, pair: Indices, starts: PairPositions | None, targets: PairPositions | None
) -> Iterator[Violation]:
    """Judge a pair (1, 2) whose starts or targets are given too close.

    Until the UAVs first keep their separation, and from when they last keep it, they are excused as long as they are no
    nearer to each other than given.
    """
    end = fleet.motion.end
    near = [fleet.nearness(pair[0], given) if given else np.inf for given in (starts, targets)]
    nearest = starts if starts and near[0] <= near[1] else targets
    if nearest:
        yield _too_close(fleet, pair[0], nearest, Fault.GIVEN, ", as their starts or targets are given")
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
            yield _unproven(fleet, pair[0], within, peaks, 0)


def _within(intervals: Intervals, begin: float, end: float) -> Intervals:
    """Return the parts of intervals between two instants, seconds."""
    begins, ends = np.maximum(intervals[0], begin), np.minimum(intervals[1], end)
    some = begins < ends
    return begins[some], ends[some]


def _reversed(pieces: SharedPieces) -> SharedPieces:
    """Return the same motion backwards in time."""
    back = np.arange(len(pieces.begins))[::-1]
    excess = Polynomials(pieces.excess.b[back, ::-1], pieces.excess.error[back])
    first, second = pieces.pieces
    return SharedPieces(
        pieces.pair, (first[back], second[back]), -pieces.ends[back], -pieces.begins[back], excess, pieces.share
    )


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


def _unproven(fleet: FleetSeparation, pair: Indices, pieces: SharedPieces, peaks: Peaks, k: int) -> Violation:
    """Return what is wrong with a pair of UAVs, whose separation is the k-th question and was not proven."""
    place = peaks.place(k)
    meeting, share = fleet.meeting(pieces, *place), float(pieces.share[place[0]])
    if peaks.refuted[k] and fleet.nearness(pair, meeting, share, LET_PASS) < 1:
        why = ", nearer than their starts or targets are given" if share < 1 else ""
        return _too_close(fleet, pair, meeting, Fault.SEPARATION, why)
    return _undecided(fleet, pair, meeting, int(peaks.halvings[k]))


def _too_close(fleet: FleetSeparation, pair: Indices, meeting: PairPositions, fault: Fault, why: str) -> Violation:
    """Return the violation of a pair at a meeting; `why` is added to the message."""
    i, j = (int(k) for k in pair)
    time, first, second = meeting
    middle, metres = (first + second) / 2, math.dist(first, second)
    deed = f"come within {metres:.6g} m of each other"
    if time == 0:
        deed = f"are {metres:.6g} m apart already at the start,"
    message = (
        f"{_names(fleet, i, j)} {deed} at t = {time:.6g} s, around {position_text(middle)}{why}: "
        f"{fleet.nearness(pair, meeting):.6g} of the separation, {fleet.across[i, j]:.6g} m to the side and "
        f"{fleet.above[i, j]:.6g} m above."
    )
    return Violation(fault, _uavs(fleet, i, j), message, time, position_tuple(middle))


def _undecided(fleet: FleetSeparation, pair: Indices, meeting: PairPositions, halvings: int) -> Violation:
    i, j = (int(k) for k in pair)
    middle = (meeting.first + meeting.second) / 2
    message = (
        f"Whether {_names(fleet, i, j)} keep their separation could not be decided at t = {meeting.time:.6g} s, "
        f"around {position_text(middle)}, by cutting pieces in two {halvings} times."
    )
    return Violation(Fault.UNDECIDED, _uavs(fleet, i, j), message, meeting.time, position_tuple(middle))


def _uavs(fleet: FleetSeparation, i: int, j: int) -> tuple[int, int]:
    return fleet.motion.uavs[i], fleet.motion.uavs[j]


def _names(fleet: FleetSeparation, i: int, j: int) -> str:
    return " and ".join(fleet.scenario.uavs[uav].name for uav in _uavs(fleet, i, j))
