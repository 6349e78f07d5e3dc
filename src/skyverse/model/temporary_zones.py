"""Zones that are active only at times: which of a scenario's zones are, and the scenario as if they always were."""

from collections.abc import Collection

from skyverse.model.active_times import told_spans
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape


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
