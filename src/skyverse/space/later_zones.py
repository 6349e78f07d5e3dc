"""Zones that open after a mission's flights have been judged, where UAVs stay then, in words."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.model.active_times import active_spans
from skyverse.model.caution import Caution
from skyverse.model.scenario import Scenario
from skyverse.model.seconds import told_seconds
from skyverse.model.short_lines import listed
from skyverse.model.temporary_zones import is_closed_at_times, told_zone
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.model.what_is_proven import JUDGED_STAY
from skyverse.space.world import World

MAX_NAMED = 6
"""UAVs that are named in one sentence; of more it is told how many there are."""


def later_zone_cautions(scenario: Scenario, trajectories: Sequence[Trajectory | None]) -> list[str]:
    """Return a sentence for each zone that opens around UAVs that stay, later than the referee judges their flights.

    Parameters
    ----------
    scenario
        The scenario.
    trajectories
        The flight of each UAV; one without a flight stays at its start.
    """
    arrival = max((flight.end for flight in trajectories if flight is not None), default=0.0)
    opening = {
        number: next((begin for begin, _ in active_spans(zone.active) if begin > arrival + JUDGED_STAY), None)
        for number, zone in enumerate(scenario.zones)
        if is_closed_at_times(zone)
    }
    later = [(number, begin) for number, begin in opening.items() if begin is not None]
    if not later:
        return []
    stays = [
        (uav, "start", np.array(uav.start)) if flight is None else (uav, "target", flight.at([flight.end]).position[0])
        for uav, flight in zip(scenario.uavs, trajectories, strict=False)
    ]
    said = []
    for number, opens in later:
        worlds = {error: _alone(scenario, number, error) for error in {uav.tracking_error for uav in scenario.uavs}}
        for end in ("start", "target"):
            names = [
                uav.name
                for uav, place_is, place in stays
                if place_is == end and _holds(worlds[uav.tracking_error], place)
            ]
            if names:
                said.append(_sentence(scenario, number, names, end, opens, arrival))
    return said


def _alone(scenario: Scenario, number: int, error: TrackingError) -> World:
    """Return a world whose only obstacle is a zone."""
    zone = scenario.zones[number].model_copy(update={"active": None})
    only = {"obstacles": (zone,), "zones": (), "terrain": None, "max_height": None}
    return World(scenario.model_copy(update=only), error)


def _holds(world: World, place: Floats) -> bool:
    """Tell whether the only obstacle of a world, grown by the clearance, holds a place (3,)."""
    return world.blocker(place) is not None


def _sentence(scenario: Scenario, number: int, names: Sequence[str], end: str, opens: float, arrival: float) -> str:
    """Return the caution on UAVs that stay at their starts, or at their targets, around which a zone opens."""
    more = len(names) - MAX_NAMED
    who = listed([*names[:MAX_NAMED], *([f"{more} more"] if more > 0 else [])])
    where = f"stays at its {end}" if len(names) == 1 else f"stay at their {end}s"
    return (
        f"{Caution.WARNING}: {who} {where}, inside {told_zone(scenario, number)} or nearer to it than the clearance; "
        f"it opens at {told_seconds(opens)}, after the last arrival at {told_seconds(arrival)}."
    )
