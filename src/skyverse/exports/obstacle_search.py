"""Searches segments for obstacles with the planners' world, which is fast; the referee proves what is exported."""

import math
from dataclasses import dataclass, field

import numpy as np

from skyverse.exports.global_positions import AltitudeReference
from skyverse.exports.ground_under_legs import ground_allowance, steepest
from skyverse.exports.leg_segments import Checked, Foot, Segments, Shortfall
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.uav import TrackingError
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, MIN_GROWTH, SURFACE_DEPTH
from skyverse.space.tube import NO_ERROR
from skyverse.space.world import World


@dataclass(frozen=True, eq=False)
class ObstacleSearch:
    """Tells which segments meet obstacles or leave the bounds, in one scenario.

    With altitudes above ground it knows neither the ground nor the ceiling above it: `LegChecker` judges these.

    Attributes
    ----------
    scenario, reference, error, worlds
        As those of `LegChecker`.
    """

    scenario: Scenario
    reference: AltitudeReference
    error: TrackingError
    worlds: dict[TrackingError, World]
    _beside: dict[tuple[TrackingError, Foot], World] = field(default_factory=dict)

    def stray(self, strays: bool, upright: float) -> TrackingError:
        """Return the tracking error or none, with some metres more up and down."""
        error = self.error if strays else NO_ERROR
        return derived(error, vertical=error.vertical + upright) if upright else error

    def world(self, error: TrackingError, foot: Foot | None = None) -> World:
        """Return the planners' world of `grown` with an error, perhaps that of a column."""
        if error not in self.worlds:
            self.worlds[error] = World(self.grown(0.0), error)
        if foot is None:
            return self.worlds[error]
        if (error, foot) not in self._beside:
            self._beside[error, foot] = self.worlds[error].beside(foot, self.roof(foot) + SURFACE_DEPTH)
        return self._beside[error, foot]

    def roof(self, foot: Foot) -> float:
        """Return z of the highest roof that is exempt from the error in a column, metres."""
        return foot[2] - self.scenario.clearance

    def checked(self, given: Segments) -> Checked:
        """Return what is found of segments; their growth is rounded up, since a world is made for each."""
        starts, ends, extra, strays, foot, upright = given
        given = given._replace(growth=growth_of(extra), upright=growth_of(upright) if upright else 0.0)
        world = self.world(self.stray(strays, given.upright), foot)
        places = np.concatenate([starts, ends])
        room = np.minimum(places - world.space.low, world.space.high - places).min(axis=1)
        least = int(np.argmin(room))
        if room[least] < max(extra - LEG_ALLOWANCE, -SURFACE_DEPTH):
            return Checked(Shortfall(f"may be {extra - room[least]:.3g} m out of bounds", places[least]))
        met = world.first_crossing(starts, ends, given.growth)
        if met is not None:
            return Checked(given._replace(starts=starts[met : met + 1], ends=ends[met : met + 1]))
        return Checked(None, (given,))

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


def growth_of(extra: float) -> float:
    """Return the least `MIN_GROWTH` times a power of two that is not below `extra`, metres: few worlds are needed."""
    return float(MIN_GROWTH * 2.0 ** max(math.ceil(math.log2(extra / MIN_GROWTH)), 0))
