"""How near a mission's flights pass what stands still, at places along them, for people; no proof rests on it."""

from skyverse.model.flight_measures import places_along
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.space.world import World


def nearest_obstacle(mission: Mission) -> float | None:
    """Return metres to the nearest obstacle, negative inside; ``None`` where none stands or nobody flies."""
    flown = [one for one in mission.trajectories if one is not None]
    if not flown or not mission.scenario.obstacles:
        return None
    world = World(derived(mission.scenario, terrain=None, max_height=None))
    return min(float(world.distance(places_along(one)).min()) for one in flown)
