"""Judges whether the fleet keeps apart: about each of two UAVs an ellipsoid is free of the other, at every instant."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from skyverse.referee.boxes import TOLERANCE, Floats, Ints, place, triple
from skyverse.referee.curve import Curve
from skyverse.referee.flight import FINE
from skyverse.referee.polynomial import DEPTH, Polynomials, greatest, halve, squared
from skyverse.referee.tracks import Tracks, near_pairs, relative, time_slices, tracks_of
from skyverse.result import Fault, Violation
from skyverse.scenario import Scenario

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
    """Intervals of time in each of which two UAVs fly one piece each: (m,) pair, pieces, seconds, 1 - nearness^2."""

    pair: Ints
    pieces: tuple[Ints, Ints]
    begins: Floats
    ends: Floats
    excess: Polynomials


def _cells(fleet: _Fleet, pairs: Ints, intervals: list[tuple[Floats, Floats]], forgiven: float) -> _Cells:
    of = np.repeat(np.arange(len(pairs)), [len(begins) for begins, _ in intervals])
    begins, ends = (np.concatenate(column) for column in zip(*intervals, strict=True))
    tracks = fleet.tracks
    first, second = (
        np.concatenate([tracks.piece(pair[side], some) for pair, (some, _) in zip(pairs, intervals, strict=True)])
        for side in (0, 1)
    )
    x, y, z = relative(tracks, first, second, begins, ends)
    i, j = pairs[of].T
    level, upright = fleet.across[i, j] - forgiven, fleet.above[i, j] - forgiven
    nearness = squared([_divided(x, level), _divided(y, level), _divided(z, upright)])
    return _Cells(of, (first, second), begins, ends, nearness * -1.0 + 1.0)


def _divided(part: Polynomials, by: Floats) -> Polynomials:
    return Polynomials(part.b / by[:, None], part.error / by + 4e-16 * part.size / by)


def _judge_pairs(fleet: _Fleet, pairs: Ints, slices: list[Ints]) -> tuple[list[Violation], int]:
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
            meeting = _meeting(fleet, cells, peaks.piece[k], peaks.share[k])
            found.append(_too_close(fleet, pairs[k], meeting, Fault.SEPARATION))
        else:
            meeting = _meeting(fleet, cells, peaks.stuck[k], peaks.stuck_share[k])
            found.append(_undecided(fleet, pairs[k], meeting, int(peaks.halvings[k])))
    return found, int(peaks.halvings.sum())


def _common(fleet: _Fleet, i: int, j: int) -> tuple[Floats, Floats]:
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


def _given(fleet: _Fleet, i: int, j: int) -> tuple[bool, bool]:
    """Tell whether two UAVs are given too close at their starts, and, where both fly, at their targets."""
    scenario, tracks = fleet.scenario, fleet.tracks
    uavs = [tracks.uavs[k] for k in (i, j)]
    keep = np.array([fleet.across[i, j], fleet.across[i, j], fleet.above[i, j]])

    def near(places: list[tuple[float, float, float]]) -> bool:
        return float(np.sum((np.subtract(places[0], places[1]) / keep) ** 2)) < 1

    starts = near([scenario.uavs[uav].start for uav in uavs])
    both_fly = all(len(tracks.knots[k]) > 2 for k in (i, j))
    targets = [scenario.targets[target].position for uav in uavs if (target := fleet.targets[uav]) is not None]
    return starts, both_fly and len(targets) == 2 and near(targets)


def _judge_given(fleet: _Fleet, pair: Ints, starts: bool, ends: bool) -> Iterator[Violation]:
    """Judge a pair given too close: nobody is to blame until it is first apart, or from when it is last apart on."""
    begin, end = 0.0, fleet.tracks.end
    whole = _common(fleet, *pair[0])
    cells = _cells(fleet, pair, [whole], 0.0)
    apart = _first_apart(cells) if starts else begin
    again = max(apart, -_first_apart(_reversed(cells))) if ends else end
    for fault, spans in (
        (Fault.GIVEN, [(begin, apart), (again, end)]),
        (Fault.SEPARATION, [(apart, again)]),
    ):
        intervals = [_within(whole, *span) for span in spans]
        some = np.concatenate([begins for begins, _ in intervals]), np.concatenate([ends for _, ends in intervals])
        if not len(some[0]):
            continue
        within = _cells(fleet, pair, [some], TOLERANCE)
        peaks = greatest(within.excess.b, within.excess.error, 0.0, FINE)
        if peaks.refuted(0.0)[0]:
            yield _too_close(fleet, pair[0], _meeting(fleet, within, peaks.piece[0], peaks.share[0]), fault)
        elif not peaks.proven(0.0)[0]:
            meeting = _meeting(fleet, within, peaks.stuck[0], peaks.stuck_share[0])
            yield _undecided(fleet, pair[0], meeting, int(peaks.halvings[0]))


def _within(intervals: tuple[Floats, Floats], begin: float, end: float) -> tuple[Floats, Floats]:
    begins, ends = np.maximum(intervals[0], begin), np.minimum(intervals[1], end)
    some = begins < ends
    return begins[some], ends[some]


def _reversed(cells: _Cells) -> _Cells:
    excess = Polynomials(cells.excess.b[::-1, ::-1], cells.excess.error[::-1])
    first, second = cells.pieces
    return _Cells(cells.pair, (first[::-1], second[::-1]), -cells.ends[::-1], -cells.begins[::-1], excess)


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


def _too_close(fleet: _Fleet, pair: Ints, meeting: _Meeting, fault: Fault) -> Violation:
    i, j = (int(k) for k in pair)
    uavs = fleet.tracks.uavs[i], fleet.tracks.uavs[j]
    time, first, second = meeting
    across, above = fleet.across[i, j], fleet.above[i, j]
    apart, middle = first - second, (first + second) / 2
    nearness = float(np.linalg.norm(apart / [across, across, above]))
    metres = float(np.linalg.norm(apart))
    deed = f"come within {metres:.6g} m of each other"
    if time == 0:
        deed = f"are {metres:.6g} m apart already at the start,"
    why = ", as their starts or targets are given" if fault is Fault.GIVEN else ""
    names = " and ".join(fleet.scenario.uavs[uav].name for uav in uavs)
    message = (
        f"{names} {deed} at t = {time:.6g} s, around {place(middle)}{why}: {nearness:.6g} of the separation, "
        f"{across:.6g} m across and {above:.6g} m above."
    )
    return Violation(fault, uavs, message, time, triple(middle))


def _undecided(fleet: _Fleet, pair: Ints, meeting: _Meeting, halvings: int) -> Violation:
    i, j = (int(k) for k in pair)
    uavs = fleet.tracks.uavs[i], fleet.tracks.uavs[j]
    time, middle = meeting.time, (meeting.first + meeting.second) / 2
    names = " and ".join(fleet.scenario.uavs[uav].name for uav in uavs)
    message = (
        f"Whether {names} keep their separation could not be decided at t = {time:.6g} s, around {place(middle)}, "
        f"by cutting pieces in two {halvings} times."
    )
    return Violation(Fault.UNDECIDED, uavs, message, time, triple(middle))
