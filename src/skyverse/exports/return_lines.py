"""Straight lines that returning UAVs fly, each for all returns from a part of a flight, and whether they are safe.

`space` searches, and the referee proves what is handed out. A line must keep a share of the clearance from obstacles
and ground, and stay in bounds and below the ceiling, with everything by which the UAV may be off it: the part of the
flight that it stands for, bent and rounded lines, and the tracking error.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from enum import IntEnum
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.leg_certificate import SEGMENTS_AT_ONCE
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import MIN_GROWTH, SURFACE_DEPTH
from skyverse.referee.clearance import judge_segments
from skyverse.referee.closed_above import SolidShapes
from skyverse.referee.column import without_below
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.world import referee_world
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import BESIDE, World

CLEARANCE_SHARE = 0.5
"""The share of the clearance that is kept on the way home: with the rest, parts of a flight may have a length."""
COLUMN_DECIMALS = 5
"""To 10 micrometres, lines that begin at the same place are in the same column."""
LINE_MARGIN = 1e-6
"""Metres that lines which are searched keep more than what the referee has yet to prove: more than rounding."""
BEYOND_BOUNDS = 1000.0
"""Metres by which bounds are widened where only obstacles are asked for."""


class Ground(IntEnum):
    """What is asked of a line beside obstacles and bounds."""

    NONE = 0
    """Nothing: other lines answer for it."""
    RULES = 1
    """It keeps above ground, and below the ceiling."""
    NEAR = 2
    """It keeps as far from the ground as from an obstacle: a climb begins where the flight itself keeps above it."""


class ReturnLines(NamedTuple):
    """Straight lines that a returning UAV flies.

    Attributes
    ----------
    starts, ends
        (m, 3) metres.
    growth
        (m,) metres by which a line is thickened, so that it stands for a whole part of the flight.
    aside, above
        (m,) metres: the same to the side, and up and down, which counts for ground and ceiling.
    low, high
        (m, 3) metres: corners of the box around all that the line stands for.
    ground
        (m,) what is asked of ground and ceiling, `Ground`.
    strays
        (m,) whether the tracking error counts. Lines in a column where the UAV takes off or lands are asked for twice:
        without the error, and with it among all but what lies below.
    roof
        (m,) metres: in the latter case, z of the highest roof that is exempt from the error, as is the ground; minus
        infinity elsewhere.
    lax
        (m, 2) metres by which the UAV may be beside the line, and above or below it, besides its tracking error: its
        autopilot accepts that, or it was off its path by the error when it was called back.
    """

    starts: Floats
    ends: Floats
    growth: Floats
    aside: Floats
    above: Floats
    low: Floats
    high: Floats
    ground: NDArray[np.intp]
    strays: NDArray[np.bool_]
    roof: Floats
    lax: Floats

    def of(self, some: NDArray[np.bool_] | NDArray[np.intp]) -> "ReturnLines":
        """Return some of the lines."""
        return ReturnLines._make(column[some] for column in self)


def joined(each: Sequence[ReturnLines]) -> ReturnLines:
    """Return all lines of several."""
    return ReturnLines._make(np.concatenate(columns) for columns in zip(*each, strict=True))


def single(lines: ReturnLines) -> ReturnLines:
    """Return lines that stand for themselves only."""
    none = np.zeros(len(lines.growth))
    low, high = np.minimum(lines.starts, lines.ends), np.maximum(lines.starts, lines.ends)
    return lines._replace(growth=none, aside=none, above=none, low=low, high=high)


class VerticalColumn(NamedTuple):
    """A vertical line at x, y, and z of the highest roof below it that is exempt from the tracking error; metres."""

    x: float
    y: float
    roof: float


class LineGroup(NamedTuple):
    """Lines that are asked for in the same world.

    Attributes
    ----------
    some
        (m,) which of the lines.
    ground
        How they are asked for above ground; `Ground.NONE` where they are asked for among the obstacles.
    deviation
        How far the UAV may be off them.
    growth
        Metres by which they are thickened beside.
    column
        The column in which they are, where what lies below is exempt.
    """

    some: NDArray[np.bool_]
    ground: Ground
    deviation: TrackingError
    growth: float
    column: VerticalColumn | None = None


class ReturnSpace:
    """What returning UAVs keep clear of; it remembers what it compiles.

    Parameters
    ----------
    scenario
        What is given.
    only_solids
        Whether nothing else counts: neither rules, which are the ceiling above ground and airspace, nor bounds.
    """

    def __init__(self, scenario: Scenario, *, only_solids: bool = False) -> None:
        self.only_solids = only_solids
        self.numbers = list(range(len(scenario.obstacles)))
        if only_solids:
            self.numbers = [k for k in self.numbers if scenario.obstacles[k].solid]
            solid = [
                derived(shape, closed_above=False) if shape.closed_above else shape
                for shape in (scenario.obstacles[k] for k in self.numbers)
            ]
            scenario = derived(scenario, obstacles=tuple(solid), max_height=None)
        terrain, bounds = scenario.terrain, scenario.bounds
        wide = Bounds(
            min=tuple(low - BEYOND_BOUNDS for low in bounds.min), max=tuple(high + BEYOND_BOUNDS for high in bounds.max)
        )
        kept = CLEARANCE_SHARE * scenario.clearance
        self.scenario = derived(scenario, bounds=wide) if only_solids else scenario
        self.bare = derived(scenario, clearance=kept, terrain=None, max_height=None, bounds=wide)
        self._asked = {Ground.NONE: self.bare}
        if terrain is not None:
            near = CLEARANCE_SHARE * min(scenario.clearance, scenario.ground_clearance)
            above = scenario.ground_clearance - (1 - CLEARANCE_SHARE) / CLEARANCE_SHARE * near
            for kind, least, most in ((Ground.RULES, above, scenario.max_height), (Ground.NEAR, near, None)):
                lowered = derived(terrain, clearance=least)
                self._asked[kind] = derived(self.bare, terrain=lowered, max_height=most, obstacles=())
        self._worlds: dict[tuple[Ground, TrackingError], World] = {}
        self._beside: dict[tuple[VerticalColumn, TrackingError, float], World] = {}

    @cached_property
    def solids(self) -> "ReturnSpace":
        """What is solid of it: obstacles but for airspace, and the ground."""
        return ReturnSpace(self.scenario, only_solids=True)

    def blocker(self, line: ReturnLines, error: TrackingError, widened: float) -> int | None:
        """Return the number of an obstacle that the middle of one short line is too near to, or ``None``."""
        (group, *_) = self._groups(line, error, np.ones(1, dtype=np.bool_))
        margin = group.growth + LINE_MARGIN + widened
        found = self._world(group).blocker(((line.starts + line.ends) / 2)[0], margin=margin)
        return None if found is None else self.numbers[found]

    def world(self, ground: Ground, error: TrackingError) -> World:
        """Return the ground and ceiling, or else the obstacles, for UAVs that stray by an error."""
        if (ground, error) not in self._worlds:
            self._worlds[ground, error] = World(self._asked[ground], error)
        return self._worlds[ground, error]

    def _world(self, group: LineGroup) -> World:
        world = self.world(group.ground, group.deviation)
        if group.column is None:
            return world
        key = group.column, group.deviation, group.growth
        if key not in self._beside:
            lift = group.column.roof + SURFACE_DEPTH
            self._beside[key] = world.beside(group.column, lift, group.growth + BESIDE)
        return self._beside[key]

    def free(self, lines: ReturnLines, error: TrackingError) -> NDArray[np.bool_]:
        """Tell for each line whether it is safe for a UAV with a tracking error, (m,)."""
        free = self.in_bounds(lines, error)
        for group in self._groups(lines, error, free):
            some, margin = group.some, group.growth + LINE_MARGIN
            free[some] &= self._world(group).segments_free(lines.starts[some], lines.ends[some], margin=margin)
        return free

    def in_bounds(self, lines: ReturnLines, error: TrackingError) -> NDArray[np.bool_]:
        """Tell for each line whether it is within bounds, (m,).

        Where a UAV may be beside a line, it has not left the way by which it came, which is a line of its own.
        """
        bounds = self.scenario.bounds
        reach = lines.strays[:, None] * np.array([error.horizontal, error.horizontal, error.vertical])
        reach[:, 2] += lines.lax[:, 1]
        below = reach.copy()
        below[lines.roof > -np.inf, 2] = 0.0
        within = (lines.low - below >= np.array(bounds.min) - SURFACE_DEPTH) & (
            lines.high + reach <= np.array(bounds.max) + SURFACE_DEPTH
        )
        return np.asarray(within.all(axis=1))

    def _groups(self, lines: ReturnLines, error: TrackingError, asked: NDArray[np.bool_]) -> Iterator[LineGroup]:
        """Yield which of the lines that are `asked` for, (m,), share a world."""
        growth, aside, above = (rounded_up(column) for column in (lines.growth, lines.aside, lines.above))
        held = lines.roof > -np.inf
        if (asked & held).any():
            columns = np.column_stack([lines.starts[:, :2].round(COLUMN_DECIMALS), lines.roof, growth, lines.lax])
            for key in _distinct(columns[asked & held]):
                x, y, roof, more, *lax = key
                column = VerticalColumn(x, y, roof)
                yield LineGroup(asked & (columns == key).all(axis=1), Ground.NONE, _strayed(error, *lax), more, column)
        kinds = np.column_stack([lines.lax, lines.strays])
        for kind in _distinct(kinds[asked & ~held]):
            *lax, strays = kind
            own = _strayed(error if strays else NO_ERROR, *lax)
            of = asked & (kinds == kind).all(axis=1) & ~held
            for more in np.unique(growth[of]).tolist():
                yield LineGroup(of & (growth == more), Ground.NONE, own, more)
            for ground in (Ground.RULES, Ground.NEAR) if len(self._asked) > 1 else ():
                held_up = of & (lines.ground == ground)
                for wide, tall in product(np.unique(aside[held_up]).tolist(), np.unique(above[held_up]).tolist()):
                    some = held_up & (aside == wide) & (above == tall)
                    if some.any():
                        yield LineGroup(some, ground, _strayed(own, wide, tall), 0.0)

    def proven(self, each: Sequence[tuple[TrackingError, ReturnLines]]) -> bool:
        """Tell whether the referee proves all lines of some UAVs, which have tracking errors."""
        wanted: dict[tuple[Ground, TrackingError, float, VerticalColumn | None], list[tuple[Floats, Floats]]] = (
            defaultdict(list)
        )
        for error, lines in each:
            if not self.in_bounds(lines, error).all():
                return False
            every = np.ones(len(lines.growth), dtype=np.bool_)
            for some, ground, deviation, growth, column in self._groups(lines, error, every):
                wanted[ground, deviation, growth, column].append((lines.starts[some], lines.ends[some]))
        shapes: dict[Ground, SolidShapes] = {}
        for (ground, deviation, growth, column), pairs in wanted.items():
            given = self._asked[ground]
            if given.terrain is not None:
                more = {"clearance": given.ground_clearance + growth}
                most = None if given.max_height is None else given.max_height - growth
                given = derived(given, terrain=derived(given.terrain, **more), max_height=most)
            given = derived(given, clearance=given.clearance + growth)
            columns = [np.concatenate(column) for column in zip(*pairs, strict=True)]
            once = np.unique(np.hstack(columns), axis=0)  # from most parts of a flight the descent is the same line
            starts, ends = once[:, :3], once[:, 3:]
            world = referee_world(given, deviation, shapes=shapes.get(ground))
            shapes[ground] = world.shapes
            if column is not None:
                world = without_below(world, np.array(column), column.roof + LET_PASS)
            for first in range(0, len(starts), SEGMENTS_AT_ONCE):
                batch = slice(first, first + SEGMENTS_AT_ONCE)
                judged = judge_segments(world, starts[batch], ends[batch])
                if judged.incursion is not None or not judged.peaks.proven[0]:
                    return False
        return True


def _distinct(rows: Floats) -> list[list[float]]:
    """Return the rows (n, k) that differ, in order; most are equal to the one before, which is cheap to see."""
    changes = np.ones(len(rows), dtype=np.bool_)
    changes[1:] = (rows[1:] != rows[:-1]).any(axis=1)
    return np.unique(rows[changes], axis=0).tolist() if changes.any() else []


def _strayed(error: TrackingError, beside: float, upright: float) -> TrackingError:
    """Return a tracking error with metres more to the side, and up and down."""
    return TrackingError(horizontal=error.horizontal + beside, vertical=error.vertical + upright)


def rounded_up(growth: Floats) -> Floats:
    """Return growths, metres, rounded up to `MIN_GROWTH` times powers of two: a world is made for each. 0 stays."""
    power = MIN_GROWTH * 2.0 ** np.ceil(np.log2(np.maximum(growth, MIN_GROWTH) / MIN_GROWTH))
    return np.where(growth > 0, power, 0.0)
