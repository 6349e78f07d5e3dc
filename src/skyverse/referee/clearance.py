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
    b, exact = np.stack([starts, ends], axis=1), np.zeros(len(starts))
    curve = PolynomialCurve(np.arange(len(starts) + 1.0), np.stack([starts, ends - starts], axis=1))
    in_boxes = Deepest(_combined_peaks([]), deepest_in_boxes(world.boxes, starts, ends))
    return _combined(world, [in_boxes, *(_judge_kind(kind, b, exact, curve) for kind in world.others)])


def _judge_kind(kind: GrownSolids, b: Floats, error: Floats, curve: PolynomialCurve) -> Deepest:
    """Judge all pieces of a curve, (n, degree + 1, 3) with errors (n,), against all shapes of one kind."""
    wrong = kind.error(b, error)
    if b.shape[1] == 2:
        pairs = kind.tree.near_segments(b[:, 0], b[:, 1], wrong)
    else:
        pairs = kind.tree.overlapping(b.min(axis=1) - wrong[:, None], b.max(axis=1) + wrong[:, None])
    piece, shape = np.concatenate([np.zeros((0, 2), dtype=np.intp), *pairs]).T
    if not len(piece):
        return Deepest(_combined_peaks([]), None)

    def depth(part: Floats, pair: Indices) -> Floats:
        return kind.depth(part, shape[pair])

    peaks = find_peaks(b[piece], wrong[piece], depth)
    incursion = None
    if peaks.refuted[0]:
        pair, share = peaks.place()
        k, of = int(piece[pair]), int(shape[pair])
        position = curve.motion(k, share * float(curve.durations[k]))[0]  # without Bernstein coefficients
        if kind.depth(position[None, None], np.array([of]))[0] > 0:
            gap, number = kind.gap(position, of), int(kind.obstacle[of])
            incursion = Incursion(gap, kind.clearance, number, k, share, position)
    # callers ask which piece it was, not which pair of a piece and a shape
    stuck = np.where(peaks.stuck >= 0, piece[peaks.stuck], peaks.stuck)
    return Deepest(peaks._replace(piece=piece[peaks.piece], stuck=stuck), incursion)


def _combined(world: RefereeWorld, judged: list[Deepest]) -> Deepest:
    """Return the judgements of all kinds of shapes as one, with the deepest place of them all.

    What is said of that place counts the tracking error as a part of the gap, and not of the clearance.
    """
    incursions = [one.incursion for one in judged if one.incursion is not None]
    deepest = max(incursions, key=lambda incursion: incursion.depth, default=None)
    if deepest is not None and deepest.obstacle >= 0 and world.error.horizontal:
        aside = world.error.horizontal
        deepest = replace(deepest, gap=deepest.gap - aside, required=deepest.required - aside)
    return Deepest(_combined_peaks([one.peaks for one in judged]), deepest)


def _combined_peaks(each: list[Peaks]) -> Peaks:
    """Return the highest of all peaks, the first place that stayed undecided, and all halvings."""
    nothing = find_peaks(np.zeros((0, 1)), np.zeros(0))
    highest = max(each, key=lambda peaks: float(peaks.value[0]), default=nothing)
    stuck = next((peaks for peaks in each if peaks.stuck[0] >= 0), nothing)
    halvings = np.array([sum(int(peaks.halvings[0]) for peaks in each)])
    return highest._replace(stuck=stuck.stuck, stuck_share=stuck.stuck_share, halvings=halvings)
