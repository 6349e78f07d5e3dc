"""How near a mission's flights pass what stands still, at places along them, for people; no proof rests on it."""

import math

from skyverse.model.flight_table import places_along
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.space.world import World


def nearest_obstacle(mission: Mission) -> float | None:
    """Return metres to the nearest obstacle, rounded down to centimetres, negative inside; ``None`` without any."""
    flown = [one for one in mission.trajectories if one is not None]
    if not flown or not mission.scenario.obstacles:
        return None
    world = World(derived(mission.scenario, terrain=None, max_height=None))
    return math.floor(100 * min(float(world.distance(places_along(one)).min()) for one in flown)) / 100
