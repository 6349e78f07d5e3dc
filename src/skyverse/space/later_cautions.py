"""What comes to UAVs that stay, after their flights have been judged, in words: zones that open, and movers."""

from collections.abc import Iterator, Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.model.caution import Caution
from skyverse.model.mover import Mover
from skyverse.model.mover_motions import CircularMotion, PeriodicMotion, PolynomialMotion, WaypointMotion
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import active_spans
from skyverse.model.short_lines import listed, told_seconds
from skyverse.model.timed_shapes import JUDGED_STAY, TimedShape, is_closed_at_times, is_dynamic, told_zone
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV, TrackingError
from skyverse.space.timed_shapes import first_too_near, moving_shapes
from skyverse.space.world import World

MAX_NAMED = 6
"""UAVs that are named in one sentence; of more it is told how many there are."""


FOLLOWED = 3600.0
"""Seconds after the last arrival for which movers are followed, at most."""
MAX_MOVERS = 6
"""Movers that are told of in a sentence each; of more it is told how many there are."""

Stay = tuple[UAV, str, Floats]
"""A UAV, whether it stays at its ``"start"`` or its ``"target"``, and the place, (3,) metres."""


def later_cautions(scenario: Scenario, trajectories: Sequence[Trajectory | None]) -> list[str]:
    """Return a sentence for each zone and mover that comes to UAVs that stay, later than the referee judges flights.

    Movers are followed for one cycle of their motion, or, where they have none, for `FOLLOWED` seconds.

    Parameters
    ----------
    scenario
        The scenario.
    trajectories
        The flight of each UAV; one without a flight stays at its start.
    """
    if not is_dynamic(scenario):
        return []
    arrival = max((flight.end for flight in trajectories if flight is not None), default=0.0)
    stays = [
        (uav, "start", np.array(uav.start)) if flight is None else (uav, "target", flight.at([flight.end]).position[0])
        for uav, flight in zip(scenario.uavs, trajectories, strict=False)
    ]
    return [*_of_zones(scenario, stays, arrival), *_of_movers(scenario, stays, arrival)]


def _of_zones(scenario: Scenario, stays: Sequence[Stay], arrival: float) -> Iterator[str]:
    """Yield a sentence for each zone that opens around UAVs."""
    for number, zone in enumerate(scenario.zones):
        if not is_closed_at_times(zone):
            continue
        opens = next((begin for begin, _ in active_spans(zone.active) if begin > arrival + JUDGED_STAY), None)
        if opens is None:
            continue
        worlds = {error: _alone(scenario, number, error) for error in {uav.tracking_error for uav in scenario.uavs}}
        met = [(uav.name, end) for uav, end, place in stays if _holds(worlds[uav.tracking_error], place)]
        for who in _who(met):
            yield (
                f"{Caution.WARNING}: {who}, inside {told_zone(scenario, number)} or nearer to it than the clearance; "
                f"it opens at {told_seconds(opens)}, after the last arrival at {told_seconds(arrival)}."
            )


def _of_movers(scenario: Scenario, stays: Sequence[Stay], arrival: float) -> Iterator[str]:
    """Yield a sentence for each mover that may come too near to UAVs, the first to come first."""
    since = arrival + JUDGED_STAY
    found = []
    for mover in scenario.movers:
        until = since + min(_cycle(mover, since), FOLLOWED)
        given = [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance)]
        shapes = {error: moving_shapes(given, error) for error in {uav.tracking_error for uav in scenario.uavs}}
        comes = [first_too_near(shapes[uav.tracking_error], 0, place, since, until) for uav, _, place in stays]
        met = [(uav.name, end) for (uav, end, _), when in zip(stays, comes, strict=True) if when < np.inf]
        found += [(min(comes), who, mover.name) for who in _who(met)]
    found.sort()
    for when, who, name in found[:MAX_MOVERS]:
        yield (
            f"{Caution.WARNING}: {who}, where {name} may come nearer than the clearance; it first may "
            f"at {told_seconds(when)}, after the last arrival at {told_seconds(arrival)}."
        )
    more = len({name for _, _, name in found[MAX_MOVERS:]})
    if more:
        yield f"{Caution.WARNING}: {more} more movers may come too near to UAVs that stay, after the last arrival."


def _cycle(mover: Mover, since: float) -> float:
    """Return for how long a mover must be followed from an instant on until all is known; perhaps for ever."""
    if mover.doubt.grows:
        return np.inf
    match mover.motion:
        case CircularMotion(period=period) | PeriodicMotion(period=period):
            return period
        case WaypointMotion(times=times, then="stays") | PolynomialMotion(knots=times):
            return max(times[-1] - since, 0.0)
        case WaypointMotion(times=times, then=then):
            length = times[-1] - times[0]
            return max(times[0] - since, 0.0) + (length if then == "repeats" else 2.0 * length)


def _who(met: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield who stays where of UAVs' names and ends: ``uav-1 and uav-2 stay at their targets``."""
    for end in ("start", "target"):
        names = [name for name, place_is in met if place_is == end]
        more = len(names) - MAX_NAMED
        who = listed([*names[:MAX_NAMED], *([f"{more} more"] if more > 0 else [])])
        if names:
            yield f"{who} stays at its {end}" if len(names) == 1 else f"{who} stay at their {end}s"


def _alone(scenario: Scenario, number: int, error: TrackingError) -> World:
    """Return a world whose only obstacle is a zone."""
    zone = derived(scenario.zones[number], active=None)
    only = {"obstacles": (zone,), "zones": (), "terrain": None, "max_height": None}
    return World(derived(scenario, **only), error)


def _holds(world: World, place: Floats) -> bool:
    """Tell whether the only obstacle of a world, grown by the clearance, holds a place (3,)."""
    return world.blocker(place) is not None
