"""Zones that are active only at times: each is a mover that stands, and is there for a while.

Which of a scenario's zones are such, the scenario as if they always were active, and what is proven of its flights.
"""

import math
from collections.abc import Collection
from typing import NamedTuple

from skyverse.model.mover import Doubt
from skyverse.model.mover_motions import MoverMotion, WaypointMotion
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape, active_spans, told_spans
from skyverse.model.short_lines import told_seconds


class TimedShape(NamedTuple):
    """A shape that moves, or is there for a while.

    Attributes
    ----------
    shape
        About the moving point.
    motion
        Of that point.
    doubt
        How far it may be from there.
    keep
        Metres that UAVs must keep from it.
    active
        Seconds from which and until which it is there.
    zone
        The number of the zone that it is, or is a part of; -1 for a mover.
    """

    shape: Shape
    motion: MoverMotion
    doubt: Doubt
    keep: float
    active: tuple[float, float] = (-math.inf, math.inf)
    zone: int = -1


STANDING = WaypointMotion(points=((0.0, 0.0, 0.0),), times=(0.0,))
"""The motion of zones: none, about the zero of the frame."""


def timed_shapes(scenario: Scenario, kept: Collection[int] = ()) -> list[TimedShape]:
    """Return a scenario's movers, and its zones with active times, each as if it could not be entered while active.

    A zone is one shape for each of its active times. The clearance is kept from zones that are closed, and nothing
    from those with a speed limit. Zones whose numbers are in `kept`, which are known to be kept at all times, are left
    out.
    """
    found = [TimedShape(mover.shape, mover.motion, mover.doubt, scenario.clearance) for mover in scenario.movers]
    for number in temporary_zones(scenario):
        zone = scenario.zones[number]
        keep = scenario.clearance if is_closed_at_times(zone) else 0.0
        spans = () if number in kept else active_spans(zone.active)
        found += [TimedShape(zone, STANDING, Doubt(), keep, span, number) for span in spans]
    return found


def is_closed_at_times(zone: Shape) -> bool:
    """Tell whether a zone must not be entered while it is active: one with active times and without a speed limit."""
    return zone.active is not None and zone.max_speed is None


def temporary_zones(scenario: Scenario) -> tuple[int, ...]:
    """Return the numbers of a scenario's zones that have active times."""
    return tuple(number for number, zone in enumerate(scenario.zones) if zone.active is not None)


def is_dynamic(scenario: Scenario) -> bool:
    """Tell whether a scenario changes with time: whether it has movers, or zones with active times."""
    return bool(scenario.movers) or bool(temporary_zones(scenario))


def with_zones_active(scenario: Scenario, numbers: Collection[int]) -> Scenario:
    """Return a scenario in which zones with active times, those numbered, are active at all times.

    Those that must then never be entered are obstacles. All of its other zones with active times are left out.
    """
    lasting = [
        (number, zone if zone.active is None else derived(zone, active=None))
        for number, zone in enumerate(scenario.zones)
        if zone.active is None or number in numbers
    ]
    closed = tuple(zone for number, zone in lasting if is_closed_at_times(scenario.zones[number]))
    zones = tuple(zone for number, zone in lasting if not is_closed_at_times(scenario.zones[number]))
    return derived(scenario, obstacles=(*scenario.obstacles, *closed), zones=zones)


def told_zone(scenario: Scenario, number: int) -> str:
    """Return how sentences call a zone, and when it is active: ``zone 2 ('airshow', active from 60 s to 120 s)``."""
    zone = scenario.zones[number]
    more = [repr(zone.name)] if zone.name else []
    more += [] if zone.active is None else [f"active {told_spans(zone.active)}"]
    return f"zone {number}" + (f" ({', '.join(more)})" if more else "")


JUDGED_STAY = 1.0
"""Seconds after the last arrival until which UAVs are judged among movers and zones with active times."""


def what_is_proven(scenario: Scenario, arrival: float) -> str:
    """Return what is proven of the flights of a scenario's UAVs, as in ``clear of obstacles, in bounds and apart``.

    Where the scenario changes with time, it says until when that holds: `arrival` is the last arrival, seconds.
    """
    kept = ["clear of obstacles"] if scenario.obstacles else []
    kept += ["clear of movers"] if scenario.movers else []
    kept += ["clear of zones while they are active"] if any(map(is_closed_at_times, scenario.zones)) else []
    kept += ["clear of the ground"] if scenario.terrain is not None else []
    kept += ["below the ceiling above ground"] if scenario.max_height is not None else []
    kept += ["in bounds", "within limits"]
    kept += ["apart"] if len(scenario.uavs) > 1 else []
    without = "" if scenario.obstacles else "; the scenario has no obstacles"
    until = f", until {told_seconds(arrival + JUDGED_STAY)}" if is_dynamic(scenario) else ""
    return f"{', '.join(kept[:-1])} and {kept[-1]}{until}{without}"


def not_judged_as_flown(scenario: Scenario) -> str:
    """Return a sentence, after a space, on what simulated flights are not judged by; empty where they are by all."""
    limited = any(zone.max_speed is not None for zone in scenario.zones)
    return " Whether the speed limits of zones were kept is not judged." if limited else ""
