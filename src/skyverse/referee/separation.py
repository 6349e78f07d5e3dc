"""Judges whether all UAVs keep their separation: of each two, one stays out of an ellipsoid about the other."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Indices
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Violation
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.fleet_motion import fleet_motion, near_pairs
from skyverse.referee.given_conflicts import given_meetings, judge_given
from skyverse.referee.pair_motion import FleetSeparation, fleet_separation
from skyverse.referee.pair_violations import unproven
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tolerances import LET_PASS

PAIRS_AT_ONCE = 2000
"""Pairs of UAVs judged together, which bounds the memory."""


class JudgedSeparation(NamedTuple):
    """The violations, at most one of each kind for a pair of UAVs, and how often pieces were cut in two."""

    violations: list[Violation]
    halvings: int


def judge_separation(
    scenario: Scenario, targets: Sequence[int | None], curves: Sequence[PolynomialCurve | None], unknown: set[int]
) -> JudgedSeparation:
    """Judge every pair of UAVs at every instant.

    Parameters
    ----------
    scenario
        What was given.
    targets, curves
        The index of each UAV's target, and its motion; ``None`` where it has none.
    unknown
        The UAVs whose motion is not known; they are left out.
    """
    motion = fleet_motion(scenario, curves, unknown)
    if len(motion.uavs) < 2:
        return JudgedSeparation([], 0)
    fleet = fleet_separation(scenario, targets, motion)
    near = np.concatenate(list(near_pairs(motion, fleet.edges, fleet.across, fleet.above)))
    order = np.lexsort(near.T[::-1])
    pairs, begins = np.unique(near[order, :2], axis=0, return_index=True)
    slices = np.split(near[order, 2], begins[1:])
    violations: list[Violation] = []
    halvings = 0
    for k in range(0, len(pairs), PAIRS_AT_ONCE):
        judged = _judge_pairs(fleet, pairs[k : k + PAIRS_AT_ONCE], slices[k : k + PAIRS_AT_ONCE])
        violations += judged.violations
        halvings += judged.halvings
    return JudgedSeparation(violations, halvings)


def _judge_pairs(fleet: FleetSeparation, pairs: Indices, slices: list[Indices]) -> JudgedSeparation:
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
        starts, targets = given_meetings(fleet, pairs[k]) if peaks.refuted[k] else (None, None)
        if starts or targets:
            violations += judge_given(fleet, pairs[k : k + 1], starts, targets)
        else:
            violations.append(unproven(fleet, pairs[k], pieces, peaks, int(k)))
    return JudgedSeparation(violations, int(peaks.halvings.sum()))
