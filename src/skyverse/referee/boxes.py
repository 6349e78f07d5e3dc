"""Where a UAV may not be: the grown obstacles and what is outside the bounds, tested exactly."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]

TOLERANCE = 1e-6
"""Metres: what is wrong by no more than this is let pass."""


class Closest(NamedTuple):
    """Where a polyline is deepest inside a grown obstacle.

    Attributes
    ----------
    gap
        Metres to the obstacle itself, along the axis where it is largest; negative inside it.
    obstacle, segment
        Their indices.
    fraction
        How far along the segment, 0 to 1.
    position
        (3,) metres.
    """

    gap: float
    obstacle: int
    segment: int
    fraction: float
    position: Floats

    def sentence(self, subject: str, where: str, clearance: float) -> str:
        """Say that `subject` comes too close, `where`."""
        if self.gap < 0:
            deed = f"is {-self.gap:.6g} m inside obstacle {self.obstacle}"
        else:
            deed = f"comes within {self.gap:.6g} m of obstacle {self.obstacle}"
        return f"{subject} {deed} {where}, position {place(self.position)}; {clearance:.6g} m are required."


def place(position: Floats) -> str:
    """Write a position, metres."""
    return "(" + ", ".join(f"{value:.6g}" for value in position) + ")"


def triple(position: Floats) -> tuple[float, float, float]:
    """Return a position as a violation holds it."""
    return float(position[0]), float(position[1]), float(position[2])


def array(value: object) -> Floats | None:
    """Return `value` as floats, ``None`` where it is no array of numbers."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        return None


def beyond_bounds(scenario: Scenario, positions: Floats) -> Floats:
    """Return how far (n, 3) positions are outside the bounds, along the worst axis of each; (n,) metres."""
    below = np.array(scenario.bounds.min) - positions
    above = positions - np.array(scenario.bounds.max)
    excess: Floats = np.maximum(np.maximum(below, above).max(axis=1), 0.0)
    return excess


def stay_inside(starts: Floats, ends: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Return the fractions (n,), (n,) at which segments enter and leave an open box: the slab method.

    A segment meets the box where it enters before it leaves.
    """
    direction = ends - starts
    moves = direction != 0
    divisor = np.where(moves, direction, 1.0)
    to_low, to_high = (low - starts) / divisor, (high - starts) / divisor
    between = (starts > low) & (starts < high)
    enters = np.where(moves, np.minimum(to_low, to_high), np.where(between, -np.inf, np.inf))
    leaves = np.where(moves, np.maximum(to_low, to_high), np.where(between, np.inf, -np.inf))
    return np.maximum(enters.max(axis=1), 0.0), np.minimum(leaves.min(axis=1), 1.0)


class Boxes(NamedTuple):
    """(m, 3) corners of the obstacles, and of what is shut: grown by the clearance, less the tolerance."""

    low: Floats
    high: Floats
    shut_low: Floats
    shut_high: Floats


def shut_boxes(scenario: Scenario) -> Boxes:
    """Return the scenario's obstacles."""
    low = np.array([box.min for box in scenario.obstacles]).reshape(-1, 3)
    high = np.array([box.max for box in scenario.obstacles]).reshape(-1, 3)
    grown_low, grown_high = low - scenario.clearance, high + scenario.clearance
    # A wall thinner than the tolerance is still a wall: only a part of its thickness is forgiven.
    forgiven = np.minimum(TOLERANCE, (grown_high - grown_low) / 4)
    return Boxes(low, high, grown_low + forgiven, grown_high - forgiven)


def deepest(boxes: Boxes, starts: Floats, ends: Floats) -> Closest | None:
    """Return where segments between (n, 3) starts and ends are deepest in a grown obstacle, if they are."""
    low, high, shut_low, shut_high = boxes
    met = None
    for k in _beside(boxes, starts, ends):
        enter, leave = stay_inside(starts, ends, shut_low[k], shut_high[k])
        hits = np.flatnonzero(enter < leave)
        if not len(hits):
            continue
        middle = ((enter + leave) / 2)[hits]
        gaps = _gap(starts[hits] + middle[:, None] * (ends - starts)[hits], low[k], high[k])
        s = hits[np.argmin(gaps)]
        along = np.linspace(enter[s], leave[s], 101)
        points = starts[s] + along[:, None] * (ends - starts)[s]
        gaps = _gap(points, low[k], high[k])
        i = int(np.argmin(gaps))
        if met is None or gaps[i] < met.gap:
            met = Closest(float(gaps[i]), int(k), int(s), float(along[i]), points[i])
    return met


def _beside(boxes: Boxes, starts: Floats, ends: Floats) -> Ints:
    """Return the indices of the boxes that meet the bounding box of any segment: no segment can enter another."""
    lowest, highest = np.minimum(starts, ends), np.maximum(starts, ends)
    some = np.flatnonzero(((boxes.shut_low < highest.max(axis=0)) & (boxes.shut_high > lowest.min(axis=0))).all(axis=1))
    meets = np.zeros(len(some), dtype=bool)
    at_once = max(1, 1_000_000 // len(starts))
    for first in range(0, len(some), at_once):
        these = slice(first, first + at_once)
        low, high = boxes.shut_low[some[these], None], boxes.shut_high[some[these], None]
        meets[these] = np.any(np.all((low < highest) & (high > lowest), axis=2), axis=1)
    return some[meets]


def _gap(points: Floats, low: Floats, high: Floats) -> Floats:
    """Return the distance of (n, 3) points to a box along their worst axis, negative inside; (n,) metres."""
    gap: Floats = np.maximum(low - points, points - high).max(axis=1)
    return gap
