"""What a proven mission keeps, and what no simulated flight is judged by, in a few words: only what a scenario has."""

from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import told_seconds
from skyverse.model.temporary_zones import is_closed_at_times, is_dynamic

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
