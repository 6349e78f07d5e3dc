"""Judges whether the fleet keeps apart: about each of two UAVs an ellipsoid is free of the other, at every instant."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.boxes import TOLERANCE, place, triple
from skyverse.referee.clearance import FINE
from skyverse.referee.curve import Curve
from skyverse.referee.polynomial import DEPTH, Peaks, Polynomials, greatest, halve, squared
from skyverse.referee.tracks import Tracks, near_pairs, relative, time_slices, tracks_of

AT_ONCE = 2000  # pairs


class Apart(NamedTuple):
    """Violations, at most one of each kind a pair, and how often pieces were cut in two."""

    violations: list[Violation]
    halvings: int


class _Fleet(NamedTuple):
    """What is asked: the tracks, slices of time, and (n, n) metres to be kept across and above."""

    scenario: Scenario
    targets: Sequence[int | None]
    tracks: Tracks
    edges: Floats
    across: Floats
    above: Floats


def judge_separation(
    scenario: Scenario, targets: Sequence[int | None], curves: Sequence[Curve | None], unknown: set[int]
) -> Apart:
    """Judge every pair of UAVs, but for those of which the motion is `unknown`."""
    tracks = tracks_of(scenario, curves, unknown)
    if len(tracks.uavs) < 2:
        return Apart([], 0)
    ellipsoids = np.array([scenario.uavs[uav].ellipsoid for uav in tracks.uavs])
    keep = np.maximum(ellipsoids[:, None], ellipsoids[None])
    keep[(keep <= TOLERANCE).any(axis=2)] = 0.0
    fleet = _Fleet(scenario, targets, tracks, time_slices(tracks), keep[..., 0], keep[..., 1])
    near = np.concatenate(list(near_pairs(tracks, fleet.edges, fleet.across, fleet.above)))
    order = np.lexsort(near.T[::-1])
    pairs, begins = np.unique(near[order, :2], axis=0, return_index=True)
    slices = np.split(near[order, 2], begins[1:])
    violations: list[Violation] = []
    halvings = 0
    for k in range(0, len(pairs), AT_ONCE):
        found, cut = _judge_pairs(fleet, pairs[k : k + AT_ONCE], slices[k : k + AT_ONCE])
        violations += found
        halvings += cut
    return Apart(violations, halvings)


class _Cells(NamedTuple):
    """Intervals of time in each of which two UAVs fly one piece each.

    (m,) pair, pieces, seconds, 1 - (nearness / kept)^2, and kept: which share of the separation must be.
    """

    pair: Indices
    pieces: tuple[Indices, Indices]
    begins: Floats
    ends: Floats
    excess: Polynomials
    kept: Floats


_Intervals = tuple[Floats, Floats]


def _cells(
    fleet: _Fleet, pairs: Indices, intervals: list[_Intervals], forgiven: float, shares: Floats | float = 1.0
) -> _Cells:
    """Return the cells of (n, 2) pairs in intervals of each, where they must keep (n,) shares of the separation."""
    of = np.repeat(np.arange(len(pairs)), [len(begins) for begins, _ in intervals])
    begins, ends = (np.concatenate(column) for column in zip(*intervals, strict=True))
    tracks = fleet.tracks
    first, second = (
        np.concatenate([tracks.piece(pair[side], some) for pair, (some, _) in zip(pairs, intervals, strict=True)])
        for side in (0, 1)
    )
    x, y, z = relative(tracks, first, second, begins, ends)
    i, j = pairs[of].T
    kept = np.broadcast_to(shares, len(pairs))[of]
    level, upright = kept * fleet.across[i, j] - forgiven, kept * fleet.above[i, j] - forgiven
    nearness = squared([_divided(x, level), _divided(y, level), _divided(z, upright)])
    return _Cells(of, (first, second), begins, ends, nearness * -1.0 + 1.0, kept)


def _divided(part: Polynomials, by: Floats) -> Polynomials:
    return Polynomials(part.b / by[:, None], part.error / by + 4e-16 * part.size / by)


def _judge_pairs(fleet: _Fleet, pairs: Indices, slices: list[Indices]) -> tuple[list[Violation], int]:
    intervals = []
    for (i, j), some in zip(pairs, slices, strict=True):
        begins, ends = _common(fleet, i, j)
        wanted = np.zeros(len(fleet.edges), dtype=bool)
        wanted[some] = True
        inside = wanted[np.searchsorted(fleet.edges, begins, side="right") - 1]
        intervals.append((begins[inside], ends[inside]))
    cells = _cells(fleet, pairs, intervals, TOLERANCE)
    peaks = greatest(cells.excess.b, cells.excess.error, 0.0, FINE, group=cells.pair, groups=len(pairs))
    found: list[Violation] = []
    for k in np.flatnonzero(~peaks.proven(0.0)):
        if peaks.refuted(0.0)[k]:
            given = _given(fleet, *pairs[k])
            if any(given):
                found += _judge_given(fleet, pairs[k : k + 1], *given)
                continue
        found.append(_found(fleet, pairs[k], cells, peaks, int(k)))
    return found, int(peaks.halvings.sum())


def _found(fleet: _Fleet, pair: Indices, cells: _Cells, peaks: Peaks, k: int) -> Violation:
    """Return what is wrong with a pair, of which the k-th question was not proven."""
    spot = peaks.stuck[k], peaks.stuck_share[k]
    if peaks.refuted(0.0)[k]:
        spot = peaks.piece[k], peaks.share[k]
        meeting, kept = _meeting(fleet, cells, *spot), float(cells.kept[spot[0]])
        if _nearness(fleet, pair, meeting, kept, TOLERANCE) < 1:
            why = ", nearer than their starts or targets are given" if kept < 1 else ""
            return _too_close(fleet, pair, meeting, Fault.SEPARATION, why)
    return _undecided(fleet, pair, _meeting(fleet, cells, *spot), int(peaks.halvings[k]))


def _common(fleet: _Fleet, i: int, j: int) -> _Intervals:
    edges = np.unique(np.concatenate([fleet.tracks.knots[i], fleet.tracks.knots[j], fleet.edges]))
    return edges[:-1], edges[1:]


class _Meeting(NamedTuple):
    """An instant, seconds, and where two UAVs are then, evaluated directly, (3,) metres."""

    time: float
    first: Floats
    second: Floats


def _meeting(fleet: _Fleet, cells: _Cells, cell: int, share: float) -> _Meeting:
    time = np.array([cells.begins[cell] + share * (cells.ends[cell] - cells.begins[cell])])
    first, second = (fleet.tracks.begun_at(piece[[cell]], time)[0, 0] for piece in cells.pieces)
    return _Meeting(float(time[0]), first, second)


def _nearness(fleet: _Fleet, pair: Indices, meeting: _Meeting, kept: float = 1.0, forgiven: float = 0.0) -> float:
    """Return how near two UAVs are, of a share of their separation less what is let pass."""
    across, above = kept * fleet.across[*pair] - forgiven, kept * fleet.above[*pair] - forgiven
    return float(np.linalg.norm((meeting.first - meeting.second) / [across, across, above]))


def _given(fleet: _Fleet, i: int, j: int) -> tuple[_Meeting | None, _Meeting | None]:
    """Return where two UAVs are given too close: their starts, and, where both fly, their targets."""
    scenario, tracks = fleet.scenario, fleet.tracks
    uavs = [tracks.uavs[k] for k in (i, j)]
    starts = _Meeting(0.0, *(np.array(scenario.uavs[uav].start) for uav in uavs))
    meetings: list[_Meeting | None] = [starts, None]
    places = [np.array(scenario.targets[target].position) for uav in uavs if (target := fleet.targets[uav]) is not None]
    if len(places) == 2 and all(len(tracks.knots[k]) > 2 for k in (i, j)):
        meetings[1] = _Meeting(float(max(tracks.knots[k][-2] for k in (i, j))), *places)
    pair = np.array([i, j])
    begin, end = (one if one and _nearness(fleet, pair, one, forgiven=TOLERANCE) < 1 else None for one in meetings)
    return begin, end


def _judge_given(fleet: _Fleet, pair: Indices, starts: _Meeting | None, ends: _Meeting | None) -> Iterator[Violation]:
    """Judge a pair given too close.

    Until it is first apart, or from when it is last apart on, nobody is to blame while it is no nearer than given.
    """
    end = fleet.tracks.end
    near = [_nearness(fleet, pair[0], given) if given else np.inf for given in (starts, ends)]
    nearest = starts if starts and near[0] <= near[1] else ends
    if nearest:
        yield _too_close(fleet, pair[0], nearest, Fault.GIVEN, ", as their starts or targets are given")
    whole = _common(fleet, *pair[0])
    cells = _cells(fleet, pair, [whole], 0.0)
    apart = _first_apart(cells) if starts else 0.0
    again = max(apart, -_first_apart(_reversed(cells))) if ends else end
    if apart == end:
        near[0] = min(near)  # never apart: both excuse all of it
    keep = min(fleet.across[*pair[0]], fleet.above[*pair[0]])
    some = [
        (span, share)
        for span, share in (
            (_within(whole, 0.0, apart), near[0]),
            (_within(whole, apart, again), 1.0),
            (_within(whole, again, end), near[1]),
        )
        if len(span[0]) and share * keep > TOLERANCE
    ]
    if some:
        spans, shares = zip(*some, strict=True)
        within = _cells(fleet, np.repeat(pair, len(some), axis=0), list(spans), TOLERANCE, np.array(shares))
        peaks = greatest(within.excess.b, within.excess.error, 0.0, FINE)
        if not peaks.proven(0.0)[0]:
            yield _found(fleet, pair[0], within, peaks, 0)


def _within(intervals: _Intervals, begin: float, end: float) -> _Intervals:
    begins, ends = np.maximum(intervals[0], begin), np.minimum(intervals[1], end)
    some = begins < ends
    return begins[some], ends[some]


def _reversed(cells: _Cells) -> _Cells:
    excess = Polynomials(cells.excess.b[::-1, ::-1], cells.excess.error[::-1])
    first, second = cells.pieces
    begins, ends = -cells.ends[::-1], -cells.begins[::-1]
    return _Cells(cells.pair, (first[::-1], second[::-1]), begins, ends, excess, cells.kept)


def _first_apart(cells: _Cells) -> float:
    """Return the first instant of the cells, in order, at which two UAVs are apart; else their end."""
    for b, error, begin, end in zip(cells.excess.b, cells.excess.error, cells.begins, cells.ends, strict=True):
        parts = [(b[None], begin, end, 0)]
        while parts:
            part, begins, ends, depth = parts.pop()
            if (part > error).all():
                continue
            if not part[0, 0] > error or np.ptp(part) <= 2 * error or depth == DEPTH:
                return float(begins)
            left, right = halve(part)
            middle = (begins + ends) / 2
            parts += [(right, middle, ends, depth + 1), (left, begins, middle, depth + 1)]
    return float(cells.ends[-1])


def _too_close(fleet: _Fleet, pair: Indices, meeting: _Meeting, fault: Fault, why: str) -> Violation:
    i, j = (int(k) for k in pair)
    uavs = fleet.tracks.uavs[i], fleet.tracks.uavs[j]
    time, first, second = meeting
    across, above = fleet.across[i, j], fleet.above[i, j]
    middle, metres = (first + second) / 2, float(np.linalg.norm(first - second))
    nearness = _nearness(fleet, pair, meeting)
    deed = f"come within {metres:.6g} m of each other"
    if time == 0:
        deed = f"are {metres:.6g} m apart already at the start,"
    names = " and ".join(fleet.scenario.uavs[uav].name for uav in uavs)
    message = (
        f"{names} {deed} at t = {time:.6g} s, around {place(middle)}{why}: {nearness:.6g} of the separation, "
        f"{across:.6g} m to the side and {above:.6g} m above."
    )
    return Violation(fault, uavs, message, time, triple(middle))


def _undecided(fleet: _Fleet, pair: Indices, meeting: _Meeting, halvings: int) -> Violation:
    i, j = (int(k) for k in pair)
    uavs = fleet.tracks.uavs[i], fleet.tracks.uavs[j]
    time, middle = meeting.time, (meeting.first + meeting.second) / 2
    names = " and ".join(fleet.scenario.uavs[uav].name for uav in uavs)
    message = (
        f"Whether {names} keep their separation could not be decided at t = {time:.6g} s, around {place(middle)}, "
        f"by cutting pieces in two {halvings} times."
    )
    return Violation(Fault.UNDECIDED, uavs, message, time, triple(middle))
