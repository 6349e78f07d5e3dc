"""Judges clearance: of curves at every instant, and of straight paths."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.referee.boxes import deepest_in_boxes
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.judgement import Incursion
from skyverse.referee.polynomial import Polynomials
from skyverse.referee.solids import GrownSolids
from skyverse.referee.subdivision import Peaks, find_peaks
from skyverse.referee.world import RefereeWorld


class Deepest(NamedTuple):
    """The bounds on depths over all pieces, one question; and the deepest place, if anything is too close."""

    peaks: Peaks
    incursion: Incursion | None


def judge_curve(world: RefereeWorld, curve: PolynomialCurve, position: list[Polynomials]) -> Deepest:
    """Judge the clearance of a curve at every instant; `position` holds its x, y, z as polynomials."""
    b = np.stack([part.b for part in position], axis=2)
    error = np.max([part.error for part in position], axis=0)
    return _combined(world, [_judge_kind(kind, b, error, curve) for kind in (world.boxes, *world.others)])


def judge_segments(world: RefereeWorld, starts: Floats, ends: Floats) -> Deepest:
    """Judge the clearance of segments between starts and ends, (n, 3) metres, as pieces of degree 1."""
    b, exact, curve = _straight(starts, ends)
    in_boxes = Deepest(_combined_peaks([]), deepest_in_boxes(world.boxes, starts, ends))
    return _combined(world, [in_boxes, *(_judge_kind(kind, b, exact, curve) for kind in world.others)])


def incursions(world: RefereeWorld, starts: Floats, ends: Floats) -> list[Incursion | None]:
    """Return of each segment between starts and ends, (n, 3) metres, the deepest place, if anything is too close."""
    each = [[deepest_in_boxes(world.boxes, starts[k : k + 1], ends[k : k + 1])] for k in range(len(starts))]
    b, exact, curve = _straight(starts, ends)
    for kind in world.others:
        for found in _peaks_of_kind(kind, b, exact, curve, np.arange(len(starts)))[1]:
            each[found.segment].append(found)
    return [_deepest(world, some) for some in each]


def _straight(starts: Floats, ends: Floats) -> tuple[Floats, Floats, PolynomialCurve]:
    """Return segments as pieces of degree 1: their Bernstein coefficients, the errors of these, and the curve."""
    curve = PolynomialCurve(np.arange(len(starts) + 1.0), np.stack([starts, ends - starts], axis=1))
    return np.stack([starts, ends], axis=1), np.zeros(len(starts)), curve


def _judge_kind(kind: GrownSolids, b: Floats, error: Floats, curve: PolynomialCurve) -> Deepest:
    """Judge all pieces of a curve, (n, degree + 1, 3) with errors (n,), against all shapes of one kind."""
    peaks, found = _peaks_of_kind(kind, b, error, curve, np.zeros(len(b), dtype=np.intp))
    return Deepest(peaks, found[0] if found else None)


def _peaks_of_kind(
    kind: GrownSolids, b: Floats, error: Floats, curve: PolynomialCurve, question: Indices
) -> tuple[Peaks, list[Incursion]]:
    """Return the peaks of questions about the pieces of a curve, one for each piece, and the deepest places of each."""
    wrong = kind.error(b, error)
    if b.shape[1] == 2:
        pairs = kind.tree.near_segments(b[:, 0], b[:, 1], wrong)
    else:
        pairs = kind.tree.overlapping(b.min(axis=1) - wrong[:, None], b.max(axis=1) + wrong[:, None])
    piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
    if not len(piece):
        return _combined_peaks([]), []

    def depth(part: Floats, pair: Indices) -> Floats:
        return kind.depth(part, shape[pair])

    peaks = find_peaks(b[piece], wrong[piece], depth, question[piece], int(question.max()) + 1)
    found = []
    for one in np.flatnonzero(peaks.refuted).tolist():
        pair, share = peaks.place(one)
        k, of = int(piece[pair]), int(shape[pair])
        position = curve.motion(k, share * float(curve.durations[k]))[0]  # without Bernstein coefficients
        if kind.depth(position[None, None], np.array([of]))[0] > 0:
            gap, number = kind.gap(position, of), int(kind.obstacle[of])
            found.append(Incursion(gap, kind.clearance, number, k, share, position))
    # callers ask which piece it was, not which pair of a piece and a shape
    stuck = np.where(peaks.stuck >= 0, piece[peaks.stuck], peaks.stuck)
    return peaks._replace(piece=piece[peaks.piece], stuck=stuck), found


def _combined(world: RefereeWorld, judged: list[Deepest]) -> Deepest:
    """Return the judgements of all kinds of shapes as one, with the deepest place of them all."""
    deepest = _deepest(world, [one.incursion for one in judged])
    return Deepest(_combined_peaks([one.peaks for one in judged]), deepest)


def _deepest(world: RefereeWorld, found: list[Incursion | None]) -> Incursion | None:
    """Return the deepest of some places, if there is one.

    What is said of it counts the tracking error as a part of the gap, and not of the clearance.
    """
    deepest = max((one for one in found if one is not None), key=lambda one: one.depth, default=None)
    if deepest is not None and deepest.obstacle >= 0 and world.error.horizontal:
        aside = world.error.horizontal
        deepest = replace(deepest, gap=deepest.gap - aside, required=deepest.required - aside)
    return deepest


def _combined_peaks(each: list[Peaks]) -> Peaks:
    """Return the highest of all peaks, the first place that stayed undecided, and all halvings."""
    nothing = find_peaks(np.zeros((0, 1)), np.zeros(0))
    highest = max(each, key=lambda peaks: float(peaks.value[0]), default=nothing)
    stuck = next((peaks for peaks in each if peaks.stuck[0] >= 0), nothing)
    halvings = np.array([sum(int(peaks.halvings[0]) for peaks in each)])
    return highest._replace(stuck=stuck.stuck, stuck_share=stuck.stuck_share, halvings=halvings)
