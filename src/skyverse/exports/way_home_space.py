"""What returning UAVs keep clear of, and whether the lines that they fly are clear and proven."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.exports.leg_space import Place, ProvenSpace, Segments, first_unproven
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import MAVLINK_ROUNDING, MIN_GROWTH

CLEARANCE_SHARE = 0.5
"""The share of the clearance that is kept on the way home: with the rest, parts of a flight may have a length."""
BEYOND_BOUNDS = 1000.0
"""Metres by which bounds are widened: they are compared with boxes about returns, not with lines."""


class Lines(NamedTuple):
    """Straight lines that must be clear, the space in which they are asked, and for which parts of a flight, (n,)."""

    space: ProvenSpace
    segments: Segments
    some: Indices

    def free(self) -> NDArray[np.bool_]:
        """Tell for each line whether it is clear, (n,)."""
        segments = self.segments
        return self.space.world(segments).segments_free(segments.starts, segments.ends, margin=segments.margin)


class ReturnSpace:
    """What returning UAVs keep clear of: obstacles; the ground and the ceiling above it; and the ground below climbs.

    The ground is kept as near as an obstacle below a climb, which begins where the flight itself keeps above it.
    """

    def __init__(self, scenario: Scenario) -> None:
        low, high = scenario.bounds.min, scenario.bounds.max
        wide = Bounds(min=tuple(x - BEYOND_BOUNDS for x in low), max=tuple(x + BEYOND_BOUNDS for x in high))
        kept, terrain = CLEARANCE_SHARE * scenario.clearance, scenario.terrain
        bare = derived(scenario, clearance=kept, terrain=None, max_height=None, bounds=wide)
        self.obstacles = ProvenSpace(bare, scenario.clearance)
        self.ground = self.ground_below_climbs = None
        if terrain is not None:
            near = CLEARANCE_SHARE * min(scenario.clearance, scenario.ground_clearance)
            above, below = (derived(terrain, clearance=least) for least in (scenario.ground_clearance - near, near))
            most = scenario.max_height
            self.ground = ProvenSpace(derived(bare, terrain=above, max_height=most, obstacles=()), kept)
            self.ground_below_climbs = ProvenSpace(derived(bare, terrain=below, obstacles=()), kept)

    def lines(
        self, ends: tuple[Floats, Floats], error: TrackingError, off: tuple[Floats, Floats], *, climb: bool = False
    ) -> Iterator[Lines]:
        """Yield lines between `ends`, (n, 3) metres each, with all that they must be clear of.

        `off`, (n,) metres each, is how far the UAV may be aside of them, and above or below, without straying.
        """
        ground = self.ground_below_climbs if climb else self.ground
        wide, tall = rounded_up(off[0]), off[1]
        for aside, above in np.unique(np.column_stack([wide, tall]), axis=0).tolist():
            some = np.flatnonzero((wide == aside) & (tall == above))
            a, b = ends[0][some], ends[1][some]
            yield Lines(self.obstacles, Segments(a, b, aside, strayed(error, 0.0, above)), some)
            if ground is not None:  # to which what is below is a margin
                beside = TrackingError(horizontal=error.horizontal + aside)
                yield Lines(ground, Segments(a, b, error.vertical + above, beside), some)


def proven(each: Sequence[Lines]) -> bool:
    """Tell whether the referee proves all of some lines."""
    wanted: dict[tuple[int, float, TrackingError, Place | None], list[Lines]] = defaultdict(list)
    for lines in each:
        wanted[id(lines.space), *lines.segments[2:]].append(lines)
    for same in wanted.values():
        # from most parts of a flight the descent is the same line
        once = np.unique(np.concatenate([np.hstack(one.segments[:2]) for one in same]), axis=0)
        if first_unproven(same[0].space.referee(same[0].segments), once[:, :3], once[:, 3:]) is not None:
            return False
    return True


def rounding(count: int) -> tuple[Floats, Floats]:
    """Return how far rounding puts each of some lines off, aside and up or down, metres."""
    off = np.full(count, MAVLINK_ROUNDING)
    return off, off


def strayed(error: TrackingError, aside: float, upright: float) -> TrackingError:
    """Return a tracking error with metres more to the side, and up and down."""
    return TrackingError(horizontal=error.horizontal + aside, vertical=error.vertical + upright)


def rounded_up(growth: Floats, exactly: float = math.inf) -> Floats:
    """Return growths, metres, rounded up to few, since a world is made for each.

    They are `MIN_GROWTH` times powers of two up to one that stays `exactly` as it is, and from there on so much more.
    """

    def power(least: Floats) -> Floats:
        return np.asarray(MIN_GROWTH * 2.0 ** np.ceil(np.log2(np.maximum(least, MIN_GROWTH) / MIN_GROWTH)))

    return np.where(growth > exactly, exactly + power(growth - exactly), np.minimum(power(growth), exactly))
