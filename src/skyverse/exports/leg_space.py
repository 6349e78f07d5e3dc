"""Segments asked of one space: what the planners' arrays find clear, which is fast, is proven by the referee."""

from enum import Enum
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.leg_geometry import (
    ground_allowance,
    growth_of,
    steepest,
)
from skyverse.model.geodesy import told_on_globe, told_place
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, SURFACE_DEPTH
from skyverse.referee.clearance import judge_segments
from skyverse.referee.pads import without_support
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.tracking_error import named
from skyverse.referee.world import RefereeWorld, referee_world
from skyverse.space.tracking_error import NO_ERROR
from skyverse.space.world import BESIDE, World

SEGMENTS_AT_ONCE = 20_000
"""Segments that the referee judges together, which bounds the memory."""
Place = tuple[float, float, float]


class Segments(NamedTuple):
    """Straight segments that keep clear of all obstacles by the clearance.

    Attributes
    ----------
    starts, ends
        (n, 3) metres.
    margin
        Metres beyond the clearance less `LEG_ALLOWANCE`.
    error
        How far the UAV may be off them otherwise.
    pad
        The place of a pad on whose axis they are, (3,) metres: what the UAV stands on there does not count.
    """

    starts: Floats
    ends: Floats
    margin: float
    error: TrackingError = NO_ERROR
    pad: Place | None = None

    def only(self, k: int) -> "Segments":
        """Return one of them."""
        return self._replace(starts=self.starts[k : k + 1], ends=self.ends[k : k + 1])


class LegRule(Enum):
    """What the height or the place of a leg breaks by itself, whatever stands around it."""

    BOUNDS = "may be {off:.3g} m out of bounds"
    GROUND = "may be {height:.4g} m above ground, and {allowed:.4g} m are required"
    CEILING = "may be {height:.5g} m above ground, above the ceiling of {allowed:.5g} m"


class Breach(NamedTuple):
    """A place of a leg or corner at which it breaks a rule.

    Attributes
    ----------
    rule
        Which.
    place
        (3,) metres.
    off
        Metres by which it does.
    allowed
        The least or the greatest height above ground, metres.
    lower
        Metres by which the ground may be lower for the autopilot than it is.
    """

    rule: LegRule
    place: Floats
    off: float
    allowed: float = 0.0
    lower: float = 0.0

    def sentence(self, scenario: Scenario) -> str:
        """Return it in words that follow "it"."""
        height = self.allowed + (self.off if self.rule is LegRule.CEILING else -self.off)
        why = f", as the ground that its autopilot knows may be {self.lower:.3g} m lower (not with amsl)"
        said = self.rule.value.format(off=self.off, height=height, allowed=self.allowed)
        return f"{said}{why if self.lower else ''}, at {told_place(scenario.frame.origin, self.place)}"


class Checked(NamedTuple):
    """What the search found of a leg or of a corner.

    Attributes
    ----------
    fault
        What is wrong: a rule that it breaks, or segments that meet something; ``None`` if nothing is.
    clear
        The segments that make it clear, which the referee has yet to prove.
    """

    fault: Breach | Segments | None
    clear: tuple[Segments, ...] = ()


class ProvenSpace:
    """What segments are asked in: the planners' space, which answers fast, and the referee's, which proves.

    Parameters
    ----------
    scenario
        What is compiled, once for each error, and for the referee once for each margin, too.
    clearance
        Metres by which the place of a pad is above what the UAV may stand on there.
    """

    def __init__(self, scenario: Scenario, clearance: float) -> None:
        self.scenario, self.clearance = scenario, clearance
        self._worlds: dict[TrackingError, World] = {}
        self._on_pads: dict[tuple[float, TrackingError, Place], World] = {}
        self._referees: dict[tuple[float, TrackingError], RefereeWorld] = {}

    def world(self, asked: Segments) -> World:
        """Return the planners' world of segments, without their margin."""
        _, _, margin, error, pad = asked
        if error not in self._worlds:
            self._worlds[error] = World(self.scenario, error)
        if pad is None:
            return self._worlds[error]
        if (margin, error, pad) not in self._on_pads:
            highest = pad[2] - self.clearance + SURFACE_DEPTH
            self._on_pads[margin, error, pad] = self._worlds[error].without_support(pad, highest, margin + BESIDE)
        return self._on_pads[margin, error, pad]

    def referee(self, asked: Segments) -> RefereeWorld:
        """Return the referee's world of segments, with their margin."""
        _, _, margin, error, pad = asked
        if (margin, error) not in self._referees:
            like = max(self._referees.values(), key=lambda one: one.error == error, default=None)
            self._referees[margin, error] = referee_world(grown(self.scenario, margin), error, like=like)
        world = self._referees[margin, error]
        return world if pad is None else without_support(world, np.array(pad), pad[2] - self.clearance + LET_PASS)


def grown(scenario: Scenario, margin: float) -> Scenario:
    """Return a scenario with clearances larger by a margin, metres, and a ceiling as much lower."""
    terrain, most = scenario.terrain, scenario.max_height
    if terrain is not None:
        terrain = derived(terrain, clearance=scenario.ground_clearance + margin)
    most = None if most is None else most - margin
    return derived(scenario, clearance=scenario.clearance + margin, terrain=terrain, max_height=most)


class LegSpace(ProvenSpace):
    """The space of the legs of one scenario, whose clearances are less by what rounding may take.

    With altitudes above ground it knows neither the ground nor the ceiling above it: `LegChecker` judges these.
    """

    def __init__(self, scenario: Scenario, reference: AltitudeReference) -> None:
        terrain, most = scenario.terrain, scenario.max_height
        if reference == "agl":
            terrain = most = None
        if terrain is not None:
            above = max(scenario.ground_clearance - ground_allowance(scenario), 0.0)
            if most is not None:
                most -= MAVLINK_ROUNDING * steepest(terrain.lowest_ground)
            terrain = derived(terrain, clearance=above + MAVLINK_ROUNDING * steepest(terrain))
        kept = max(scenario.clearance - LEG_ALLOWANCE, 0.0)
        super().__init__(derived(scenario, clearance=kept, terrain=terrain, max_height=most), scenario.clearance)
        self.given, self.reference = scenario, reference

    def check(self, given: Segments) -> Checked:
        """Return what is found of segments; their margin is rounded up, since the referee needs a world for each."""
        margin, given = given.margin, given._replace(margin=growth_of(given.margin))
        world, places = self.world(given), np.concatenate([given.starts, given.ends])
        room = np.minimum(places - world.space.low, world.space.high - places).min(axis=1)
        least = int(np.argmin(room))
        if room[least] < max(margin - LEG_ALLOWANCE, -SURFACE_DEPTH):
            return Checked(Breach(LegRule.BOUNDS, places[least], float(margin - room[least])))
        met = world.first_crossing(given.starts, given.ends, given.margin)
        if met is not None:
            return Checked(given.only(met))
        return Checked(None, (given,))

    def sentence(self, fault: Breach | Segments) -> str:
        """Return a fault in words, with the place."""
        if isinstance(fault, Breach):
            return f"it {fault.sentence(self.given)}"
        world, origin = self.referee(fault), self.given.frame.origin
        incursion = judge_segments(world, fault.starts, fault.ends).incursion
        if incursion is None:
            ends = " and ".join(told_place(origin, end) for end in (fault.starts[0], fault.ends[0]))
            return f"whether it keeps the clearance could not be decided between {ends}"
        where = f"at {told_on_globe(origin, incursion.position)}"
        return incursion.sentence(world.scenario, named("it", world.error), where).rstrip(".")


def first_unproven(world: RefereeWorld, starts: Floats, ends: Floats) -> int | None:
    """Return a segment between starts and ends, (n, 3) metres, that the referee does not prove, or ``None``."""
    for first in range(0, len(starts), SEGMENTS_AT_ONCE):
        some = slice(first, first + SEGMENTS_AT_ONCE)
        peaks, incursion = judge_segments(world, starts[some], ends[some])
        if incursion is not None:
            return first + incursion.segment
        if not peaks.proven[0]:
            return first + int(max(peaks.stuck[0], 0))
    return None
