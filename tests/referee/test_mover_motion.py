"""Movers lie within the stated error of the referee's polynomial pieces, and the error is no larger than rounding asks.

The truth is counted in extended precision, and for straight legs in fractions.
"""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings

import skyverse as sky
from movers import motions
from skyverse.referee.mover_motion import LONGEST, MAX_PIECES, enclosed_motion

EPS = float(np.finfo(float).eps)
TURN = 2 * np.longdouble("3.14159265358979323846264338327950288")
END = 20.0


def on_legs(motion, t):
    """Where a motion along straight legs is at an instant: fractions, (3,)."""
    times = [Fraction(one) for one in motion.times]
    length, since = times[-1] - times[0], Fraction(t) - times[0]
    if motion.then == "repeats" and since > 0:
        since %= length
    if motion.then == "returns" and since > 0:
        since = length - abs(since % (2 * length) - length)
    points = [[Fraction(x) for x in point] for point in motion.points]
    for k, (begin, until) in enumerate(pairwise(times)):
        if since <= until - times[0]:
            share = max(since - begin + times[0], Fraction(0)) / (until - begin)
            return [a + share * (b - a) for a, b in zip(points[k], points[k + 1], strict=True)]
    return points[-1]


def on_closed_curve(motion, t):
    """Where a sum of sines and cosines is at an instant, (3,) in extended precision."""
    angle = TURN * np.longdouble(t) / np.longdouble(motion.period)
    terms = zip(motion.cosine, motion.sine, strict=True)
    turned = [
        np.cos(k * angle) * np.array(c, "g") + np.sin(k * angle) * np.array(s, "g") for k, (c, s) in enumerate(terms, 1)
    ]
    return np.array(motion.centre, "g") + sum(turned)


def away(motion, known, k, t):
    """How far the motion is from piece k at an instant, along the axis where that is most, metres."""
    if isinstance(motion, sky.WaypointMotion):
        local = Fraction(t) - Fraction(known.begins[k])
        at = [sum(Fraction(x) * local**j for j, x in enumerate(row)) for row in known.pieces[k].T.tolist()]
        return float(max(abs(a - b) for a, b in zip(at, on_legs(motion, t), strict=True)))
    local = np.longdouble(t) - np.longdouble(known.begins[k])
    at = sum(known.pieces[k, j] * local**j for j in range(known.pieces.shape[1]))
    if isinstance(motion, sky.PolynomialMotion):  # given as it is judged, but where it rests
        return float(np.abs(at - motion.at(t)[0]).max()) - 1e-12 * (1 + float(np.abs(at).max()))
    closed = motion.as_periodic if isinstance(motion, sky.CircularMotion) else motion
    return float(np.abs(at - on_closed_curve(closed, t)).max())


def most_error(motion):
    """The error that the referee says it needs at most, metres."""
    if isinstance(motion, sky.PolynomialMotion):
        return 0.0
    if isinstance(motion, sky.WaypointMotion):
        steps = np.linalg.norm(np.diff(motion.points, axis=0), axis=1)
        fastest = max(steps / np.diff(motion.times), default=0.0)
        return 200 * EPS * float(np.abs(motion.points).max() + 4 * fastest * (END + np.abs(motion.times).max()))
    closed = motion.as_periodic if isinstance(motion, sky.CircularMotion) else motion
    terms = np.linalg.norm(closed.cosine, axis=1) + np.linalg.norm(closed.sine, axis=1)
    turns = 1 + END / closed.period
    quick = 2 * np.pi * len(terms) * END / closed.period / LONGEST
    remainder = 5.5e-9 * min(quick, 1.0) ** 9 * terms.sum()
    return remainder + 500 * EPS * turns * len(terms) * float(np.abs(closed.centre).max() + terms.sum())


SLOW = sky.CircularMotion(centre=(3, -4, 5), radius=10, period=1e6)
HASTY = sky.CircularMotion(centre=(3, -4, 5), radius=2, period=0.5)
FAR = sky.WaypointMotion(points=[(1e6, 0, 0), (1e6 + 50, 1e3, 7)], times=[-3.0, 4.1], then="returns")
THERE_AND_BACK = sky.WaypointMotion(
    points=[(0, 0, 0), (1, 3, 0), (1, 0, 2), (9, 0, 0)], times=[0.1, 1 / 3, 2 / 3, 4.3], then="returns"
)
ROUNDS = sky.WaypointMotion(points=[(0, 0, 0), (1, 3, 0), (0, 0, 0)], times=[6.0, 7.3, 8.1], then="repeats")
LATE = sky.WaypointMotion(points=[(0, 0, 0), (1, 3, 0)], times=[30.0, 31.0], then="returns")
PIECES = sky.PolynomialMotion(
    knots=[2.0, 3.0, 15.0], coefficients=[[(1, 2, 3), (1, 0, 0), (0, 1, 0), (0, 0, 2)], [(2, 3, 5), (0.5, 0.25, 0)]]
)


@given(motions)
@settings(max_examples=20)
@example(SLOW)
@example(HASTY)
@example(FAR)
@example(THERE_AND_BACK)
@example(ROUNDS)
@example(LATE)
@example(PIECES)
def test_movers_lie_within_the_error_of_their_pieces_and_it_is_small(motion):
    known = enclosed_motion(motion, END)
    assert known.knots[0] == 0
    assert known.knots[-1] == END
    assert (np.diff(known.knots) > 0).all()
    last = len(known.error) - 1
    for k in {*range(0, last, 1 + last // 25), last}:
        for share in (0.03, 0.5, 0.97):
            t = float(known.knots[k] + share * (known.knots[k + 1] - known.knots[k]))
            assert away(motion, known, k, t) <= known.error[k]
    assert known.error.max() <= most_error(motion)


@pytest.mark.parametrize("then", ["repeats", "returns"])
def test_a_motion_of_too_many_turns_is_not_enclosed(then):
    restless = sky.WaypointMotion(points=[(0, 0, 0), (1, 0, 0), (0, 0, 0)], times=[0, 0.01, 0.02], then=then)
    assert enclosed_motion(restless, 0.005 * MAX_PIECES) is not None
    assert enclosed_motion(restless, 0.02 * MAX_PIECES) is None
