"""What returning UAVs keep clear of: a share of the clearance from obstacles and ground, bounds aside.

The planners' world answers which lines are clear, and the referee proves those that are handed out.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
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
from skyverse.space.world import BESIDE, World

CLEARANCE_SHARE = 0.5
"""The share of the clearance that is kept on the way home: with the rest, parts of a flight may have a length."""
SEARCH_MARGIN = 1e-6
"""Metres that lines which are searched keep more than what the referee has yet to prove: more than rounding."""
BEYOND_BOUNDS = 1000.0
"""Metres by which bounds are widened: they are compared with boxes about returns, not with lines."""

Among = Literal["obstacles", "ground", "ground below a climb"]


class Asked(NamedTuple):
    """What must be clear along lines.

    Attributes
    ----------
    among
        What they are asked for: obstacles; the ground and the ceiling above it; or the ground as near as an obstacle,
        for a climb begins where the flight itself keeps above it.
    error
        How far the UAV may be off them.
    growth
        Metres more to all sides, among obstacles.
    pad
        (x, y, z) metres for vertical lines over a place where the UAV starts or lands: roofs up to z, and the ground,
        are exempt from the error there.
    """

    among: Among
    error: TrackingError
    growth: float
    pad: tuple[float, float, float] | None = None


class Lines(NamedTuple):
    """Straight lines between starts and ends, (k, 3) metres, that ask the same, for `some` parts of a flight."""

    asked: Asked
    starts: Floats
    ends: Floats
    some: Indices


class ReturnSpace:
    """What returning UAVs keep clear of; it remembers what it compiles.

    Parameters
    ----------
    scenario
        What is given.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        low, high = scenario.bounds.min, scenario.bounds.max
        wide = Bounds(min=tuple(x - BEYOND_BOUNDS for x in low), max=tuple(x + BEYOND_BOUNDS for x in high))
        kept, terrain = CLEARANCE_SHARE * scenario.clearance, scenario.terrain
        bare = derived(scenario, clearance=kept, terrain=None, max_height=None, bounds=wide)
        self._scenarios: dict[Among, Scenario] = {"obstacles": bare}
        if terrain is not None:
            near = CLEARANCE_SHARE * min(scenario.clearance, scenario.ground_clearance)
            above, below = (derived(terrain, clearance=least) for least in (scenario.ground_clearance - near, near))
            self._scenarios["ground"] = derived(bare, terrain=above, max_height=scenario.max_height, obstacles=())
            self._scenarios["ground below a climb"] = derived(bare, terrain=below, obstacles=())
        self._worlds: dict[tuple[Among, TrackingError], World] = {}
        self._beside: dict[Asked, World] = {}

    def lines(
        self,
        starts: Floats,
        ends: Floats,
        error: TrackingError,
        off: tuple[Floats, Floats],
        *,
        climb: bool = False,
    ) -> Iterator[Lines]:
        """Yield lines, (n, 3) metres each, with all that they must be clear of.

        `off`, (n,) metres each, is how far the UAV may be beside them, and above or below, without straying.
        """
        growth = rounded_up(np.hypot(*off))
        for more in np.unique(growth).tolist():
            some = np.flatnonzero(growth == more)
            yield Lines(Asked("obstacles", error, more), starts[some], ends[some], some)
        if self.scenario.terrain is None:
            return
        wide, tall = (rounded_up(one) for one in off)
        for aside, above in np.unique(np.column_stack([wide, tall]), axis=0).tolist():
            some = np.flatnonzero((wide == aside) & (tall == above))
            asked = Asked("ground below a climb" if climb else "ground", strayed(error, aside, above), 0.0)
            yield Lines(asked, starts[some], ends[some], some)

    def free(self, lines: Lines) -> NDArray[np.bool_]:
        """Tell for each line whether it is clear, (k,)."""
        margin = lines.asked.growth + SEARCH_MARGIN
        return self._world(lines.asked).segments_free(lines.starts, lines.ends, margin=margin)

    def _world(self, asked: Asked) -> World:
        key = asked.among, asked.error
        if key not in self._worlds:
            self._worlds[key] = World(self._scenarios[asked.among], asked.error)
        if asked.pad is None:
            return self._worlds[key]
        if asked not in self._beside:
            x, y, roof = asked.pad
            self._beside[asked] = self._worlds[key].beside((x, y, roof), roof + SURFACE_DEPTH, asked.growth + BESIDE)
        return self._beside[asked]

    def proven(self, each: Sequence[Lines]) -> bool:
        """Tell whether the referee proves all of some lines."""
        wanted: dict[Asked, list[Floats]] = defaultdict(list)
        for lines in each:
            wanted[lines.asked].append(np.hstack([lines.starts, lines.ends]))
        shapes: dict[Among, SolidShapes] = {}
        for (among, error, growth, pad), rows in wanted.items():
            given = self._scenarios[among]
            once = np.unique(np.concatenate(rows), axis=0)  # from most parts of a flight the descent is the same line
            grown = derived(given, clearance=given.clearance + growth)
            world = referee_world(grown, error, shapes=shapes.get(among))
            shapes[among] = world.shapes
            if pad is not None:
                world = without_below(world, np.array(pad), pad[2] + LET_PASS)
            for first in range(0, len(once), SEGMENTS_AT_ONCE):
                some = once[first : first + SEGMENTS_AT_ONCE]
                judged = judge_segments(world, some[:, :3], some[:, 3:])
                if judged.incursion is not None or not judged.peaks.proven[0]:
                    return False
        return True


def strayed(error: TrackingError, beside: float, upright: float) -> TrackingError:
    """Return a tracking error with metres more to the side, and up and down."""
    return TrackingError(horizontal=error.horizontal + beside, vertical=error.vertical + upright)


def rounded_up(growth: Floats) -> Floats:
    """Return growths, metres, rounded up to `MIN_GROWTH` times powers of two, since a world is made for each."""
    return np.asarray(MIN_GROWTH * 2.0 ** np.ceil(np.log2(np.maximum(growth, MIN_GROWTH) / MIN_GROWTH)))
