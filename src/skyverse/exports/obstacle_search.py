"""Searches segments for obstacles with the planners' world, which is fast; the referee proves what is exported."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.ground_under_legs import ground_allowance, steepest
from skyverse.exports.leg_segments import Checked, Foot, Segments, Shortfall
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, MIN_GROWTH, SURFACE_DEPTH
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World

AT_ONCE = 64
"""Segments that are searched for the first that is blocked: what comes after it is searched again."""


@dataclass(frozen=True, eq=False)
class ObstacleSearch:
    """Tells which segments meet obstacles or leave the bounds, in one scenario.

    With altitudes above ground it knows neither the ground nor the ceiling above it: `FollowedLegs` judges these.

    Attributes
    ----------
    scenario, reference, error, worlds
        As those of `LegChecker`.
    """

    scenario: Scenario
    reference: AltitudeReference
    error: TrackingError
    worlds: dict[TrackingError, World]
    _beside: dict[Foot, World] = field(default_factory=dict)

    def world(self, strays: bool, foot: Foot | None = None) -> World:
        """Return the planners' world of `grown`, with the tracking error or without it, perhaps that of a column."""
        error = self.error if strays else NO_ERROR
        if error not in self.worlds:
            self.worlds[error] = World(self.grown(0.0), error)
        if foot is None:
            return self.worlds[error]
        if foot not in self._beside:
            self._beside[foot] = self.worlds[error].beside(foot, self.roof(foot) + SURFACE_DEPTH)
        return self._beside[foot]

    def roof(self, foot: Foot) -> float:
        """Return z of the highest roof that is exempt from the error in a column, metres."""
        return foot[2] - self.scenario.clearance

    def checked(
        self, starts: Floats, ends: Floats, extra: float | Floats, strays: bool = True, foot: Foot | None = None
    ) -> Checked:
        """Return what is found of segments from `starts` to `ends`, (n, 3) each, grown by `extra` metres, (n,) or all.

        They are all grown by the largest, but for the bounds.
        """
        world, growth = self.world(strays, foot), growth_of(float(np.max(extra)))
        room = self._room(world, starts, ends)
        least = int(np.argmin(room - extra))
        beyond = np.broadcast_to(extra, room.shape)[least]
        if room[least] < _least_room(beyond):
            outside = starts[least] if _room_of(world, starts[least]) < _room_of(world, ends[least]) else ends[least]
            return Checked(Shortfall(f"may be {beyond - room[least]:.3g} m out of bounds", outside))
        met = world.first_crossing(starts, ends, growth)
        if met is not None:
            return Checked(Segments(starts[met : met + 1], ends[met : met + 1], growth, strays, foot))
        return Checked(None, (Segments(starts, ends, growth, strays, foot),))

    def blocked(
        self, starts: Floats, ends: Floats, extra: Floats, strays: bool, foot: Foot | None
    ) -> NDArray[np.bool_]:
        """Tell of each segment, grown by `extra`, (n,), whether it meets an obstacle or leaves the bounds, (n,)."""
        world = self.world(strays, foot)
        found = self._room(world, starts, ends) < _least_room(extra)
        growths = growths_of(extra)
        for growth in np.unique(growths):
            every = np.flatnonzero((growths == growth) & ~found)
            for some in np.split(every, range(AT_ONCE, len(every), AT_ONCE)):
                k, a, b = 0, starts[some], ends[some]
                while k < len(some):
                    met = world.first_crossing(a[k:], b[k:], float(growth))
                    if met is None:
                        break
                    found[some[k + met]] = True
                    k += met + 1
        return found

    def _room(self, world: World, starts: Floats, ends: Floats) -> Floats:
        return np.minimum(_room_of(world, starts), _room_of(world, ends))

    def grown(self, extra: float) -> Scenario:
        """Return the scenario with clearances less the allowance plus `extra` metres, and a ceiling as much lower."""
        clearance = max(self.scenario.clearance - LEG_ALLOWANCE, 0.0) + extra
        terrain, most = self.scenario.terrain, self.scenario.max_height
        if self.reference == "agl":
            terrain = most = None
        if terrain is not None:
            steep = extra + MAVLINK_ROUNDING * steepest(terrain)
            above = max(self.scenario.ground_clearance - ground_allowance(self.scenario), 0.0) + steep
            if most is not None:
                most -= extra + MAVLINK_ROUNDING * steepest(terrain.lowest_ground)
            terrain = derived(terrain, clearance=above)
        return derived(self.scenario, clearance=clearance, terrain=terrain, max_height=most)


def growths_of(extra: Floats) -> Floats:
    """Return the least `MIN_GROWTH` times powers of two that are not below `extra`, metres: few worlds are needed."""
    return np.asarray(MIN_GROWTH * 2.0 ** np.maximum(np.ceil(np.log2(extra / MIN_GROWTH)), 0.0))


def growth_of(extra: float) -> float:
    """Return that of one number."""
    return float(growths_of(np.array(extra)))


def _room_of(world: World, points: Floats) -> Floats:
    """Return how many metres points, (..., 3), are within the bounds, (...)."""
    return np.asarray(np.minimum(points - world.space.low, world.space.high - points).min(axis=-1))


def _least_room(extra: float | Floats) -> Floats:
    return np.maximum(np.asarray(extra) - LEG_ALLOWANCE, -SURFACE_DEPTH)
