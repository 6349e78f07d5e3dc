"""Dubins paths: the shortest paths in the plane between two poses for a vehicle that moves forwards only.

It turns with a least radius. A shortest path is one of six words of three letters: L and R stand for a turn of the
least radius to the left and to the right, S for a straight line (L. E. Dubins, American Journal of Mathematics 79,
1957). Three of the words are solved by the centres of their first and last circles; the others are their mirror images.
"""

import math

import numpy as np

from skyverse._typing import Floats
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import SAME_CIRCLE

WORDS = ("LSL", "RSR", "LSR", "RSL", "LRL", "RLR")
"""By number; each odd one is the mirror image of the even one before it."""


@kernel
def all_words(x: float, y: float, heading: float, x1: float, y1: float, heading1: float, radius: float) -> Floats:
    """Return the metres (6, 3) of the letters of all words between two poses; infinite where a word has no path."""
    towards = math.atan2(y1 - y, x1 - x)
    apart = math.hypot(x1 - x, y1 - y) / radius
    lengths = np.empty((6, 3))
    for word in range(6):
        side = 1.0 if word % 2 == 0 else -1.0
        a, b = side * (heading - towards), side * (heading1 - towards)
        if word < 2:
            t, p, q = _lsl(apart, a, b)
        elif word < 4:
            t, p, q = _lsr(apart, a, b)
        else:
            t, p, q = _lrl(apart, a, b)
        lengths[word, 0], lengths[word, 1], lengths[word, 2] = radius * t, radius * p, radius * q
    return lengths


@kernel
def pose(
    x: float, y: float, heading: float, word: int, t: float, p: float, radius: float, s: float
) -> tuple[float, float, float]:
    """Return the pose after s metres of a word whose first two letters are t and p metres long."""
    side = 1.0 if word % 2 == 0 else -1.0
    x, y, heading = _arc(x, y, heading, side / radius, min(s, t))
    if s > t:
        middle = 0.0 if word < 4 else -side / radius
        x, y, heading = _arc(x, y, heading, middle, min(s - t, p))
    if s > t + p:
        last = -side if word in (2, 3) else side
        x, y, heading = _arc(x, y, heading, last / radius, s - t - p)
    return x, y, heading


@kernel
def curvature(word: int, letter: int, radius: float) -> float:
    """Return the signed curvature of a word's letter, 1/m, positive to the left."""
    side = 1.0 if word % 2 == 0 else -1.0
    if letter == 1:
        return 0.0 if word < 4 else -side / radius
    return -side / radius if letter == 2 and word in (2, 3) else side / radius


@inner
def _arc(x: float, y: float, heading: float, bend: float, s: float) -> tuple[float, float, float]:
    """Return the pose after s metres of a constant curvature, 1/m."""
    half = 0.5 * bend * s
    chord = s if half == 0.0 else s * math.sin(half) / half
    return x + chord * math.cos(heading + half), y + chord * math.sin(heading + half), heading + 2.0 * half


@inner
def _turn(angle: float) -> float:
    """Return an angle in [0, 2 pi); 0 for one that falls short of a full turn by rounding alone."""
    angle -= 2.0 * math.pi * math.floor(angle / (2.0 * math.pi))
    return angle if angle < 2.0 * math.pi - SAME_CIRCLE else 0.0


@inner
def _lsl(apart: float, a: float, b: float) -> tuple[float, float, float]:
    """Return the lengths of LSL in radii, between poses that many radii apart, headings against the line of both."""
    along, across = apart + math.sin(a) - math.sin(b), math.cos(b) - math.cos(a)  # from centre to centre
    gap = math.hypot(along, across)
    if gap < SAME_CIRCLE:  # both circles are one
        return _turn(b - a), 0.0, 0.0
    heading = math.atan2(across, along)
    return _turn(heading - a), gap, _turn(b - heading)


@inner
def _lsr(apart: float, a: float, b: float) -> tuple[float, float, float]:
    """Return the lengths of LSR; see `_lsl`."""
    along, across = apart + math.sin(a) + math.sin(b), -math.cos(a) - math.cos(b)
    square = along * along + across * across - 4.0
    if square < -SAME_CIRCLE:  # the circles overlap
        return math.inf, math.inf, math.inf
    straight = math.sqrt(max(square, 0.0))
    heading = math.atan2(across, along) + math.atan2(2.0, straight)
    return _turn(heading - a), straight, _turn(heading - b)


@inner
def _lrl(apart: float, a: float, b: float) -> tuple[float, float, float]:
    """Return the lengths of LRL; see `_lsl`."""
    along, across = apart + math.sin(a) - math.sin(b), math.cos(b) - math.cos(a)
    share = 0.25 * math.hypot(along, across)
    if share > 1.0 + SAME_CIRCLE:  # no circle touches both
        return math.inf, math.inf, math.inf
    share = min(share, 1.0)
    first = _turn(math.atan2(across, along) + math.acos(share) + 0.5 * math.pi - a)
    middle = 2.0 * math.pi - 2.0 * math.asin(share)  # a path with the shorter arc is never the shortest
    return first, middle, _turn(b - a - first + middle)
