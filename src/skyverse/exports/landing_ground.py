"""Whether a UAV may stand where it lands: the ground must not be steep, and a roof must be flat and large enough."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.landing import ground_below, ground_level, surface_below
from skyverse.model.airspace_kinds import is_airspace
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.space.tube import steepest_within

STEEPEST = 15.0
"""Degrees: nobody lands on steeper ground. Above it no helicopter does (FM 3-21.38, Pathfinder Operations, 2006)."""
LEAST_REACH = 1.0
"""Metres around the place that are asked at least: a UAV has legs."""
DIRECTIONS = 16
"""In how many directions the edge of a roof is looked for, half-way and as far as the UAV may be off."""


def why_not_level(scenario: Scenario, uav: int, place: Floats) -> str | None:
    """Return the end of a sentence on why a UAV should not land at a place (3,) on the ground or a roof, or ``None``.

    As far around as its horizontal tracking error, and `LEAST_REACH`, the ground must be no steeper than `STEEPEST`. A
    roof must be there, and no steeper.
    """
    reach = max(scenario.uavs[uav].tracking_error.horizontal, LEAST_REACH)
    terrain, floor = scenario.terrain, ground_level(scenario, uav)
    if place[2] <= ground_below(scenario, place, floor) + LEG_ALLOWANCE:
        slope = 0.0 if terrain is None else math.degrees(math.atan(steepest_within(terrain, place[:2], reach)))
        if slope <= STEEPEST:
            return None
        return f"the ground within {reach:.3g} m slopes by {slope:.0f} degrees; at most {STEEPEST:g} are level enough"
    angles = 2 * np.pi / DIRECTIONS * np.arange(DIRECTIONS)
    for away in (reach / 2, reach):
        for x, y in (place[:2] + away * np.column_stack([np.cos(angles), np.sin(angles)])).tolist():
            beside = surface_below(scenario, np.array([x, y, place[2] + away]), floor)
            if abs(beside - place[2]) > away * math.tan(math.radians(STEEPEST)):
                return f"the roof there is not level within {reach:.3g} m, or ends"
    return None


def require_level_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a UAV that lands below its last waypoint would land on a slope or the edge of a roof."""
    every = [(scenario.uavs[plan.route.uav].name, plan) for plan in plans]
    asked = [(name, why_not_level(scenario, plan.route.uav, plan.ending[-1])) for name, plan in every]
    refused = [f"{name}: it cannot land below its last waypoint: {why}" for name, why in asked if why is not None]
    if refused:
        stay = Remedy("end", "loiter", "to stay at the target")
        raise InputError(f"{'. '.join(refused)}. Choose other targets", field="end", give=[stay])


def ground_notes(scenario: Scenario, plans: Sequence[FlightPlan]) -> Iterator[str]:
    """Yield sentences on homes that are not level, and on what is not known where UAVs land."""
    for plan in plans:
        vehicle = scenario.uavs[plan.route.uav]
        if vehicle.fixed_wing is not None or (scenario.terrain is None and vehicle.home is None):
            continue  # it takes off elsewhere, or from where the ground is not known
        why = why_not_level(scenario, plan.route.uav, plan.home)
        if why is not None:
            yield f"{vehicle.name}: its home is not level: {why}. Choose another start, or level the place."
    if scenario.terrain is not None and all(is_airspace(shape.kind) for shape in scenario.obstacles):
        yield (
            "The scenario knows the ground and no obstacles: trees, roofs and water are unknown; look at where UAVs "
            "fly low and land."
        )
