"""The stated motions of movers as polynomial pieces that lie within a proven distance of them."""

import math
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.mover_motions import CircularMotion, MoverMotion, PeriodicMotion, PolynomialMotion, WaypointMotion
from skyverse.referee.tolerances import SUMS_ROUNDING

DEGREE = 8
"""The degree of the Taylor polynomials of closed curves."""
LONGEST = 0.5
"""Radians of a closed curve's fastest term that one Taylor polynomial covers; it is then off by 5.4e-9 of its size."""
MAX_PIECES = 100_000
"""Pieces of one mover, more of which are not judged."""


class EnclosedMotion(NamedTuple):
    """A motion between two instants.

    Attributes
    ----------
    knots
        (n + 1,) seconds.
    begins, pieces
        (n,) seconds and (n, degree + 1, 3) metres: piece k is the sum over j of ``pieces[k, j] * (t - begins[k])**j``.
    error
        (n,) metres that the motion is at most away from each piece.
    """

    knots: Floats
    begins: Floats
    pieces: Floats
    error: Floats


def enclosed_motion(motion: MoverMotion, end: float) -> EnclosedMotion | None:
    """Return a motion from 0 s to `end`, or ``None`` if it has more than `MAX_PIECES` pieces."""
    match motion:
        case WaypointMotion():
            return _straight(motion, end)
        case CircularMotion():
            return _closed(motion.as_periodic, end)
        case PeriodicMotion():
            return _closed(motion, end)
        case PolynomialMotion():
            return _polynomials(motion, end)


def _straight(motion: WaypointMotion, end: float) -> EnclosedMotion | None:
    """Return straight pieces between the instants at which the motion turns."""
    times = np.array(motion.times)
    length = float(times[-1] - times[0])
    turns = times
    if motion.then != "stays":
        laps = math.ceil((end - times[0]) / length)
        if laps * len(times) > MAX_PIECES:
            return None
        once = times[1:] - times[0]
        back = once if motion.then == "repeats" else np.append(length - once[-2::-1], length)
        turns = np.concatenate([times[:1], *(times[0] + k * length + (back if k % 2 else once) for k in range(laps))])
    knots = np.unique(np.concatenate([[0.0], turns[(turns > 0) & (turns < end)], [end]]))
    if len(knots) > MAX_PIECES:
        return None
    # positions are taken just inside of each piece's ends, since a motion that repeats or returns turns at the ends
    first, last = motion.at(knots[:-1]), motion.at(knots[1:])
    pieces = np.stack([first, (last - first) / np.diff(knots)[:, None]], axis=1)
    size = float(np.abs(np.array(motion.points)).max()) + float(np.abs(pieces[:, 1]).max()) * (end + abs(times[0]))
    return EnclosedMotion(knots, knots[:-1], pieces, np.full(len(pieces), SUMS_ROUNDING * size))


def _closed(motion: PeriodicMotion, end: float) -> EnclosedMotion | None:
    """Return Taylor polynomials about the beginnings of equal pieces, with Lagrange's bound on the remainder."""
    terms = np.arange(1, len(motion.cosine) + 1)
    rates = 2.0 * np.pi * terms / motion.period
    count = max(1, math.ceil(end * float(rates[-1]) / LONGEST))
    if count > MAX_PIECES:
        return None
    knots = np.linspace(0.0, end, count + 1)
    seconds = end / count
    cosine, sine = np.array(motion.cosine), np.array(motion.sine)
    angle = 2.0 * np.pi * ((knots[:-1] / motion.period) % 1.0)[:, None] * terms
    pieces = np.zeros((count, DEGREE + 1, 3))
    for power in range(DEGREE + 1):
        turned = angle + power * np.pi / 2  # each derivative of a sine or cosine turns it by a quarter
        weight = rates**power / math.factorial(power)
        pieces[:, power] = np.einsum("ij,jk->ik", np.cos(turned) * weight, cosine)
        pieces[:, power] += np.einsum("ij,jk->ik", np.sin(turned) * weight, sine)
    pieces[:, 0] += motion.centre
    size = np.hypot(np.linalg.norm(cosine, axis=1), np.linalg.norm(sine, axis=1))
    remainder = float(np.sum(size * (rates * seconds) ** (DEGREE + 1))) / math.factorial(DEGREE + 1)
    # the angle is rounded, by more the more turns have been made, and so are the sums
    turned_by = 2.0 * np.pi * (1.0 + end / motion.period) * float(np.sum(size * terms))
    rounding = SUMS_ROUNDING * (float(np.abs(motion.centre).max()) + turned_by)
    return EnclosedMotion(knots, knots[:-1], pieces, np.full(count, remainder + rounding))


def _polynomials(motion: PolynomialMotion, end: float) -> EnclosedMotion:
    """Return the pieces as they are given, and the point at rest before and after them."""
    degree = max(len(rows) for rows in motion.coefficients)
    pieces = np.zeros((len(motion.coefficients) + 2, degree, 3))
    pieces[[0, -1], 0] = motion.at([motion.knots[0], motion.knots[-1]])
    for k, rows in enumerate(motion.coefficients, 1):
        pieces[k, : len(rows)] = rows
    begins = np.array([motion.knots[0], *motion.knots])
    reach = np.clip([-np.inf, *motion.knots, np.inf], 0.0, end)
    some = reach[:-1] < reach[1:]
    knots = np.append(reach[:-1][some], end)
    return EnclosedMotion(knots, begins[some], pieces[some], np.zeros(int(some.sum())))
