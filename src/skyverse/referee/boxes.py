"""Where a UAV may not be: the grown boxes and what is outside the bounds, tested exactly; and what is near what."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Box, Voxels
from skyverse.referee.voxels import covered, merged

TOLERANCE = 1e-6
"""Metres: what is wrong by no more than this is let pass."""
GROUND = -1
"""The ground's number among the obstacles."""


class Closest(NamedTuple):
    """Where something is deepest inside a grown obstacle, or too close to the ground.

    Attributes
    ----------
    gap
        Metres to the obstacle itself, as it is grown: of a box along the axis where they are most, of upright shapes
        level or along z, above the ground along z; negative inside it.
    obstacle, segment
        Their indices; `GROUND` is the ground.
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

    def sentence(self, subject: str, where: str, scenario: Scenario) -> str:
        """Say that `subject` comes too close, `where`."""
        if self.obstacle == GROUND:
            deed = f"only {self.gap:.6g} m above ground" if self.gap >= 0 else f"{-self.gap:.6g} m below ground"
            deed = f"is {deed}"
        elif self.gap < 0:
            deed = f"is {-self.gap:.6g} m inside {_called(scenario, self.obstacle)}"
        else:
            deed = f"comes within {self.gap:.6g} m of {_called(scenario, self.obstacle)}"
        keep = keeps(scenario, self.obstacle)
        return f"{subject} {deed} {where}, position {place(self.position)}; {keep:.6g} m are required."

    def depth(self, scenario: Scenario) -> float:
        """Return how far inside the grown obstacle it is, metres."""
        return keeps(scenario, self.obstacle) - self.gap


def keeps(scenario: Scenario, obstacle: int) -> float:
    """Return the clearance of an obstacle or the ground, metres."""
    return scenario.ground_clearance if obstacle == GROUND else scenario.clearance


def _called(scenario: Scenario, obstacle: int) -> str:
    shape = scenario.obstacles[obstacle]
    words = [word for word in (shape.kind, shape.name and f"{shape.name!r}") if word]
    return f"obstacle {obstacle}" + (f" ({' '.join(words)})" if words else "")


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
    """(m, 3) corners of boxes, and of what is shut: grown by the clearance, less the tolerance.

    `obstacle` (m,) says to which each belongs.
    """

    low: Floats
    high: Floats
    shut_low: Floats
    shut_high: Floats
    obstacle: Indices

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of what is shut."""
        return self.shut_low, self.shut_high

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths, and of hulls: those of places, and rounding at the boxes' faces."""
        faces: Floats = error + float(np.abs([self.shut_low, self.shut_high]).max(initial=0.0)) * 4e-16
        return faces

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts of pieces may be inside a box: what is not, is on one side of it along some axis."""
        low, high = self.shut_low[which], self.shut_high[which]
        deep: Floats = np.minimum(part.max(axis=1) - low, high - part.min(axis=1)).min(axis=1)
        return deep

    def gap(self, position: Floats, which: int) -> float:
        """Return the distance of one position to a box as given, along its worst axis, negative inside; metres."""
        return float(_gap(position[None], self.low[which], self.high[which])[0])


def shut_boxes(scenario: Scenario) -> Boxes:
    """Return the scenario's boxes, also those of voxels."""
    lows, highs, obstacles = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, dtype=np.intp)]
    for number, shape in enumerate(scenario.obstacles):
        if isinstance(shape, Box):
            lows.append(np.array([shape.min]))
            highs.append(np.array([shape.max]))
        elif isinstance(shape, Voxels):
            first, beyond = (merged if scenario.clearance > TOLERANCE else covered)(shape.occupied)
            lows.append(np.array(shape.origin) + first * np.array(shape.step))
            highs.append(np.array(shape.origin) + beyond * np.array(shape.step))
        else:
            continue
        obstacles.append(np.full(len(lows[-1]), number))
    low, high = np.concatenate(lows), np.concatenate(highs)
    grown_low, grown_high = low - scenario.clearance, high + scenario.clearance
    # A wall thinner than the tolerance is still a wall: only a part of its thickness is forgiven.
    forgiven = np.minimum(TOLERANCE, (grown_high - grown_low) / 4)
    return Boxes(low, high, grown_low + forgiven, grown_high - forgiven, np.concatenate(obstacles))


def deepest(boxes: Boxes, starts: Floats, ends: Floats) -> Closest | None:
    """Return where segments between (n, 3) starts and ends are deepest in a grown box, if they are."""
    low, high, shut_low, shut_high, obstacle = boxes
    met = None
    for k in _entered(boxes, starts, ends):
        enter, leave = stay_inside(starts, ends, shut_low[k], shut_high[k])
        hits = np.flatnonzero(enter < leave)
        middle = ((enter + leave) / 2)[hits]
        gaps = _gap(starts[hits] + middle[:, None] * (ends - starts)[hits], low[k], high[k])
        s = hits[np.argmin(gaps)]
        along = np.linspace(enter[s], leave[s], 101)
        points = starts[s] + along[:, None] * (ends - starts)[s]
        gaps = _gap(points, low[k], high[k])
        i = int(np.argmin(gaps))
        if met is None or gaps[i] < met.gap:
            met = Closest(float(gaps[i]), int(obstacle[k]), int(s), float(along[i]), points[i])
    return met


def _entered(boxes: Boxes, starts: Floats, ends: Floats) -> Indices:
    """Return the indices of the boxes that some segment enters."""
    found = [np.zeros(0, dtype=np.intp)]
    for pairs in near(np.minimum(starts, ends), np.maximum(starts, ends), boxes.shut_low, boxes.shut_high):
        segment, box = pairs.T
        enter, leave = stay_inside(starts[segment], ends[segment], boxes.shut_low[box], boxes.shut_high[box])
        found.append(box[enter < leave])
    return np.unique(np.concatenate(found))


GROUP = 16


def near(low: Floats, high: Floats, shape_low: Floats, shape_high: Floats) -> Iterator[Indices]:
    """Yield (pairs, 2) indices of hulls (n, 3), (n, 3) and of those of shapes (m, 3), (m, 3) that overlap.

    First of so many hulls at once, one after another, then of each. Hulls that are not numbers overlap all.
    """
    bounds = np.arange(0, len(low), GROUP)
    group_low, group_high = np.minimum.reduceat(low, bounds), np.maximum.reduceat(high, bounds)
    some = np.flatnonzero(~_apart(group_low.min(axis=0), group_high.max(axis=0), shape_low, shape_high))
    at_once = max(1, 1_000_000 // len(bounds))
    for first in range(0, len(some), at_once):
        these = some[first : first + at_once]
        group, shape = np.nonzero(
            ~_apart(group_low[:, None], group_high[:, None], shape_low[None, these], shape_high[None, these])
        )
        for k in range(0, len(group), 1_000_000 // GROUP):
            member = (bounds[group[k : k + 1_000_000 // GROUP], None] + np.arange(GROUP)).ravel()
            of = np.repeat(these[shape[k : k + 1_000_000 // GROUP]], GROUP)
            member, of = member[member < len(low)], of[member < len(low)]
            both = ~_apart(low[member], high[member], shape_low[of], shape_high[of])
            yield np.column_stack([member[both], of[both]])


def _apart(low: Floats, high: Floats, other_low: Floats, other_high: Floats) -> NDArray[np.bool_]:
    """Tell which hulls (..., 3) do not overlap."""
    apart = (low[..., 0] >= other_high[..., 0]) | (high[..., 0] <= other_low[..., 0])
    for axis in (1, 2):
        apart |= (low[..., axis] >= other_high[..., axis]) | (high[..., axis] <= other_low[..., axis])
    return apart


def _gap(points: Floats, low: Floats, high: Floats) -> Floats:
    """Return the distance of (n, 3) points to a box along their worst axis, negative inside; (n,) metres."""
    gap: Floats = np.maximum(low - points, points - high).max(axis=1)
    return gap
