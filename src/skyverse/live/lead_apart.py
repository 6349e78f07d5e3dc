"""Leads UAVs apart that keep each other from going on: a mission planned from where they come to rest.

Each UAV in flight chooses for itself. So in a corridor two that meet head-on both wait, and neither ever goes back.
Their flights are then planned together, as those of a mission, whose conflicts are resolved in space and time. UAVs fly
it as they fly any mission: as far as it is proven, among movers and the motions of all others.
"""

from collections.abc import Sequence
from dataclasses import replace

from skyverse.live.multirotor import Multirotor
from skyverse.live.pilot import Pilot
from skyverse.mission.plan_mission import plan_mission
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario, Target
from skyverse.problem import Airspace


def lead_apart(pilots: Sequence[Pilot], scenario: Scenario, now: float, join: float) -> list[Pilot]:
    """Return the pilots; if any is stuck, all multirotors come to rest, and follow a new mission from there on.

    Where no such mission is proven, they go on as before, and the next one is sought when one is stuck again.

    Parameters
    ----------
    pilots
        Of all UAVs.
    scenario
        What is known.
    now, join
        Now, and when another motion can begin.
    """
    led = list(pilots)
    fleet = {k: one for k, one in enumerate(pilots) if isinstance(one, Multirotor)}
    if not any(one.is_stuck(now) for one in fleet.values()):
        return led
    begin = max(join, *(one.motion.end for one in fleet.values()))
    uavs = tuple(derived(scenario.uavs[k], start=tuple(one.state(begin)[0].tolist())) for k, one in fleet.items())
    targets = tuple(Target(position=tuple(one.guidance.points[-1].tolist())) for one in fleet.values())
    zones = tuple(zone for zone in scenario.zones if zone.active is None)  # others have times of the mission flown now
    alone = derived(scenario, uavs=uavs, targets=targets, zones=zones, movers=())
    mission, airspace = plan_mission(alone, assignment="identity"), Airspace(alone)
    for number, (k, one) in enumerate(fleet.items()):
        led[k] = replace(one, since=now) if mission.violations else one.following(airspace, mission, number, begin)
    return led
