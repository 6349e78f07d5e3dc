"""The parts of a curve's pieces that are flown while zones are active."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.active_times import active_spans
from skyverse.model.shapes import Shape
from skyverse.referee.tolerances import MACHINE_EPSILON


class ActiveParts(NamedTuple):
    """Parts of pieces, of pairs of a piece and a zone: those in which the zone is active.

    Attributes
    ----------
    pair
        (m,) the number of the pair.
    begin, end
        (m,) the shares of the piece between which the part lies.
    """

    pair: Indices
    begin: Floats
    end: Floats


def active_parts(knots: Floats, piece: Indices, zone: Indices, zones: Sequence[Shape]) -> ActiveParts:
    """Return in which parts of pieces zones are active, made longer by what rounding may take off them.

    Parameters
    ----------
    knots
        (n + 1,) seconds between which the n pieces lie.
    piece, zone
        (k,) pairs of a piece and a zone, by their numbers.
    zones
        The zones; one without active times is always active.
    """
    begins, seconds = knots[:-1][piece], np.diff(knots)[piece]
    slack = 8 * MACHINE_EPSILON * float(np.abs(knots).max(initial=0.0)) / seconds
    found: list[tuple[Indices, Floats, Floats]] = []
    for number in np.unique(zone).tolist():
        own = np.flatnonzero(zone == number)
        for since, until in active_spans(zones[number].active):
            begin = np.clip((since - begins[own]) / seconds[own] - slack[own], 0.0, 1.0)
            end = np.clip((until - begins[own]) / seconds[own] + slack[own], 0.0, 1.0)
            some = begin < end
            found.append((own[some], begin[some], end[some]))
    if not found:
        return ActiveParts(np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(0))
    return ActiveParts(*(np.concatenate(column) for column in zip(*found, strict=True)))


def restricted(b: Floats, begin: Floats, end: Floats) -> Floats:
    """Return Bernstein coefficients (m, degree + 1, d) on parts of their intervals, by de Casteljau's algorithm.

    Those of the whole interval, from 0 to 1, stay exactly as they are; see `restriction_error`.
    """
    degree = b.shape[1] - 1
    first, last = b.copy(), end[:, None, None]
    rows = b
    for k in range(1, degree + 1):
        rows = rows[:, :-1] * (1.0 - last) + rows[:, 1:] * last
        first[:, k] = rows[:, 0]
    part, share = first.copy(), (begin / end)[:, None, None]
    rows = first
    for k in range(1, degree + 1):
        rows = rows[:, :-1] * (1.0 - share) + rows[:, 1:] * share
        part[:, degree - k] = rows[:, -1]
    return part


def restriction_error(b: Floats) -> Floats:
    """Return bounds (m,) on what rounding adds to coefficients (m, degree + 1, d) when they are restricted."""
    return 8 * b.shape[1] * MACHINE_EPSILON * np.abs(b).max(axis=(1, 2), initial=0.0)
