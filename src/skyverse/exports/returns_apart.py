"""Whether returning UAVs keep their separation: from the paths of others, and from each other, from any instants."""

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.flown_legs import Parts
from skyverse.exports.return_destinations import ACCEPTANCE
from skyverse.exports.return_home import Return
from skyverse.exports.return_lines import ReturnLines, single
from skyverse.exports.separation import beyond, kept_distance, path_box
from skyverse.exports.timing import TimingTolerance, timed_path
from skyverse.exports.way_home import LARGEST_PART
from skyverse.model.scenario import Scenario
from skyverse.model.timed_path import TimedPath
from skyverse.numerics.tolerances import MAVLINK_ROUNDING
from skyverse.referee.timed_paths import KeptDistance, pieces_apart

SMALLEST_CROSSING = 0.25
"""Metres: half the length of the shortest part of a flight of which it is asked what its returns come near to."""
MOST_PAIRS = 4_000_000
"""Pairs of lines of two returning UAVs that are compared at once before they count as not apart."""


class SweptReturns:
    """All that one UAV may fly when it returns, from any instant: what its returns sweep.

    Parameters
    ----------
    back
        How it returns.
    """

    def __init__(self, back: Return) -> None:
        self.back, self.uav = back, back.plan.route.uav
        self.parts = back.way.legs.whole(2 * LARGEST_PART)
        tops = np.column_stack([back.way.places[:, :2], back.way.column])
        off = MAVLINK_ROUNDING + ACCEPTANCE[back.plan.autopilot.name].radius
        self.landings = timeless(tops, back.way.places, np.full(len(tops), off))

    @cached_property
    def lines(self) -> tuple[ReturnLines, NDArray[np.intp]]:
        """The lines from all parts of the flight, and the part of each."""
        return self.back.way.lines(self.parts)

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """The least and the greatest corner, (3,) metres each, of the box around all of it."""
        (low, high), (lowest, highest) = path_box(swept(self.lines[0])), path_box(self.landings)
        return np.minimum(low, lowest), np.maximum(high, highest)

    def near(self, path: TimedPath, keep: KeptDistance) -> bool:
        """Tell whether it is not proven that a return keeps a distance from a whole path.

        Parts of the flight whose returns may come too near are halved until they are small.
        """
        if beyond(self.box, path_box(path), keep):
            return False
        if not pieces_apart(self.landings, path, keep).all():
            return True
        parts: Parts | None = self.parts
        lines, part = self.lines
        while parts is not None and len(parts.leg):
            near = ~pieces_apart(swept(lines), path, keep)
            if not pieces_apart(swept(single(lines.of(near))), path, keep).all():
                return True
            parts = self._halved(parts, part[near])
            lines, part = (lines, part) if parts is None else self.back.way.lines(parts)
        return parts is None

    def meets(self, other: "SweptReturns", keep: KeptDistance) -> bool:
        """Tell whether it is not proven that two UAVs keep a distance when both return, from any instants."""
        if beyond(self.box, other.box, keep):
            return False
        if self.near(other.landings, keep) or other.near(self.landings, keep):
            return True
        (a, part), (b, others) = self.lines, other.lines
        parts, their = self.parts, other.parts
        while len(a.growth) * len(b.growth) <= MOST_PAIRS:
            near, theirs = ~pieces_apart(swept(a), swept(b), keep), ~pieces_apart(swept(b), swept(a), keep)
            if not near.any():
                return False
            if not pieces_apart(swept(single(a.of(near))), swept(single(b.of(theirs))), keep).all():
                return True
            mine, halves = self._halved(parts, part[near]), other._halved(their, others[theirs])
            if mine is None or halves is None:
                return True
            parts, their = mine, halves
            (a, part), (b, others) = self.back.way.lines(parts), other.back.way.lines(their)
        return True

    def _halved(self, parts: Parts, some: NDArray[np.intp]) -> Parts | None:
        """Return the halves of some parts, ``None`` if they are small already."""
        return self.back.way.halved(parts.of(np.unique(some)), SMALLEST_CROSSING)


def paths_crossed(
    scenario: Scenario, plans: Sequence[FlightPlan], returns: Sequence[SweptReturns], tolerance: TimingTolerance
) -> dict[int, tuple[int, ...]]:
    """Return of each UAV that may return, by its index, those from whose whole paths its separation is not proven.

    Returns from all of its flight count, and the descents down to where the UAV lands.
    """
    paths = {plan.route.uav: timed_path(scenario, plan, tolerance) for plan in plans}

    def crosses(one: SweptReturns, other: int) -> bool:
        return one.near(paths[other], kept_distance(scenario, one.uav, other))

    return {one.uav: tuple(uav for uav in paths if uav != one.uav and crosses(one, uav)) for one in returns}


def returns_apart(scenario: Scenario, returns: Sequence[SweptReturns]) -> dict[tuple[int, int], bool]:
    """Tell of each two UAVs whether it is proven that they keep their separation when both return.

    Each may return at any instant of its flight: what both may fly is apart in space.
    """
    return {
        (one.uav, other.uav): not one.meets(other, kept_distance(scenario, one.uav, other.uav))
        for one, other in combinations(returns, 2)
    }


def swept(lines: ReturnLines) -> TimedPath:
    """Return lines of returns as pieces of a path at any time."""
    return timeless(lines.starts, lines.ends, lines.growth + np.hypot(*lines.lax.T))


def timeless(starts: Floats, ends: Floats, growth: Floats) -> TimedPath:
    """Return lines between (m, 3) metres, which are thickened by (m,) metres, as pieces of a path at any time."""
    times = np.zeros((len(growth), 2))
    return TimedPath(starts, ends, times, times, np.repeat(growth[:, None], 2, axis=1))
