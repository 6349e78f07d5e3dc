"""Leads UAVs apart that keep each other from going on: a mission planned from where they come to rest.

Each UAV in flight chooses for itself. So in a corridor two that meet head-on both wait, and neither ever goes back.
Their flights are then planned together, as those of a mission, whose conflicts are resolved in space and time. UAVs fly
it as they fly any mission: as far as it is proven, among movers and the motions of all others.

That takes longer than an answer may. So a thread plans it, beside the answers, while all multirotors wait. It ends with
the program, and what goes wrong in it is told on standard error and keeps UAVs only from being led apart.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from threading import Thread
from typing import NamedTuple

from skyverse.errors import InputError
from skyverse.live.multirotor import Multirotor
from skyverse.live.pilot import Pilot
from skyverse.mission.plan_mission import plan_mission
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario, Target
from skyverse.problem import Airspace

PLANNED_IN = 2.0
"""Seconds after which the mission is flown, so that what is flown does not depend on how soon it is planned."""
SAME_PLACE = 1e-9
"""Metres from the start of its flight at which a UAV still rests there."""


class _Asked(NamedTuple):
    """A mission that is being planned: since when, for what is known, from where, by whom, and what comes of it."""

    since: float
    scenario: Scenario
    starts: dict[int, tuple[float, float, float]]
    thread: Thread
    planned: list[tuple[Airspace, Mission]]


class LeadApart:
    """Leads multirotors apart; it holds the mission that is being planned for them, if any."""

    def __init__(self) -> None:
        self._asked: _Asked | None = None

    def led(self, pilots: Sequence[Pilot], scenario: Scenario, now: float, join: float, may_wait: bool) -> list[Pilot]:
        """Return the pilots; if any is stuck, all multirotors come to rest, and follow a new mission from there on.

        Those that had to leave their places meanwhile go on as before; so do all where no such mission is proven, or
        more is known to stand by then. The next one is sought when one is stuck again.

        Parameters
        ----------
        pilots
            Of all UAVs.
        scenario
            What is known.
        now, join
            Now, and when another motion can begin.
        may_wait
            Whether the answer may wait for a mission that takes longer to plan than `PLANNED_IN`; otherwise UAVs do.
        """
        led, asked = list(pilots), self._asked
        fleet = {k: one for k, one in enumerate(pilots) if isinstance(one, Multirotor)}
        if asked is None:
            if any(one.is_stuck(now) for one in fleet.values()):
                self._asked = _ask(fleet, scenario, now)
                led = [replace(one, waits=True) if isinstance(one, Multirotor) else one for one in pilots]
            return led
        if now < asked.since + PLANNED_IN or not (may_wait or not asked.thread.is_alive()):
            return led
        self._asked = None
        asked.thread.join()
        begin = max(join, *(one.motion.end for one in fleet.values()))
        holds = asked.planned and scenario is asked.scenario
        for number, (k, one) in enumerate(fleet.items()):
            stayed = math.dist(one.state(begin)[0], asked.starts[k]) <= SAME_PLACE
            free = replace(one, waits=False, since=now)
            led[k] = free.following(*asked.planned[0], number, begin) if holds and stayed else free
        return led


def _ask(fleet: Mapping[int, Multirotor], scenario: Scenario, now: float) -> _Asked:
    """Return the mission that a thread begins to plan, from where multirotors come to rest to their targets."""
    starts = {k: tuple(one.state(one.motion.end)[0].tolist()) for k, one in fleet.items()}
    uavs = tuple(derived(scenario.uavs[k], start=start, end="target") for k, start in starts.items())
    targets = tuple(Target(position=tuple(one.guidance.points[-1].tolist())) for one in fleet.values())
    zones = tuple(zone for zone in scenario.zones if zone.active is None)  # others have times of the mission flown now
    alone = derived(scenario, uavs=uavs, targets=targets, zones=zones, movers=())
    planned: list[tuple[Airspace, Mission]] = []

    def plan() -> None:
        with suppress(InputError):
            mission = plan_mission(alone, assignment="identity", workers=1)
            if mission.complete and not mission.violations:
                planned.append((Airspace(alone), mission))

    thread = Thread(target=plan, daemon=True)
    thread.start()
    return _Asked(now, scenario, starts, thread, planned)
