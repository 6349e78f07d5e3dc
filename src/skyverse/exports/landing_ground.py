"""Whether a UAV may stand where it lands.

The ground must not be steep, a roof must be flat and large enough, and nothing may stand beside it.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, Remedy
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.global_positions import origin_of
from skyverse.exports.landing import ground_below, ground_level, solids_over, surfaces_among
from skyverse.model.caution import Caution
from skyverse.model.geodesy import to_wgs84
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.short_lines import counted
from skyverse.numerics.tolerances import LEG_ALLOWANCE
from skyverse.space.tube import steepest_within
from skyverse.space.world import BESIDE, World

STEEPEST = 15.0
"""Degrees: nobody lands on steeper ground. Above it no helicopter does (FM 3-21.38, Pathfinder Operations, 2006)."""
LEAST_REACH = 1.0
"""Metres around the place that are asked at least: a UAV has legs."""
GAP = 0.1
"""Metres between the places of a roof that are asked: narrower gaps are not seen."""
KERB = 0.1
"""Metres: what is no higher than this above where a UAV lands may be beside it."""
MAX_TOLD = 3
"""UAVs that cannot land which one sentence tells; of more it says only how many."""
ASKED_HEIGHTS = 9
"""At how many heights above where a UAV lands it is asked what stands beside."""


def why_not_level(scenario: Scenario, uav: int, place: Floats) -> str | None:
    """Return the end of a sentence on why a UAV should not land at a place (3,) on the ground or a roof, or ``None``.

    As far around as its horizontal tracking error, and at least `LEAST_REACH`, the ground must be no steeper than
    `STEEPEST`. A roof must be there, and no steeper.
    """
    reach = max(scenario.uavs[uav].tracking_error.horizontal, LEAST_REACH)
    terrain, floor = scenario.terrain, ground_level(scenario, uav)
    if place[2] <= ground_below(scenario, place, floor) + LEG_ALLOWANCE:
        slope = 0.0 if terrain is None else math.degrees(math.atan(steepest_within(terrain, place[:2], reach)))
        if slope <= STEEPEST:
            return None
        steep = math.ceil(10 * slope - 0.001) / 10
        return f"the ground within {reach:.3g} m slopes by {steep:g} degrees, more than the {STEEPEST:g} to land on"
    off = _disc(reach)
    away = np.linalg.norm(off, axis=1)
    places = place + off + away[:, None] * [0.0, 0.0, 1.0]
    solids = solids_over(scenario, place[:2] - reach, place[:2] + reach)
    beside = surfaces_among(solids, places, ground_below(scenario, places, floor))
    if (np.abs(beside - place[2]) <= np.maximum(away * math.tan(math.radians(STEEPEST)), LEG_ALLOWANCE)).all():
        return None
    return f"the roof there is not level within {reach:.3g} m, or ends"


def _disc(radius: float) -> Floats:
    """Return places of a disc about the origin, (n, 3) metres: its middle, its rim, and no more than `GAP` between."""
    rings = [np.zeros((1, 3))]
    for away in np.linspace(0.0, radius, math.ceil(radius / GAP) + 1)[1:]:
        angles = np.linspace(0.0, 2 * np.pi, max(math.ceil(2 * np.pi * away / GAP), 8), endpoint=False)
        rings.append(away * np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles]))
    return np.concatenate(rings)


def why_not_clear(scenario: Scenario, uav: int, place: Floats) -> str | None:
    """Return the end of a sentence on why a UAV would land at a place (3,) beside something, or ``None``.

    From there up to the clearance above, whatever is higher than `KERB` must be as far from it as the clearance and its
    tracking error.
    """
    error = scenario.uavs[uav].tracking_error
    obstacles = World(derived(scenario, terrain=None, max_height=None), error)
    world = obstacles.beside(place, float(place[2]) + KERB, BESIDE)
    top = place + np.array([0.0, 0.0, scenario.clearance])
    if world.first_crossing(place[None], top[None]) is None:
        return None
    found = [world.blocker(at) for at in np.linspace(place, top, ASKED_HEIGHTS)]
    what = next((world.named(number) for number in found if number is not None), "something")
    return f"{what} stands within {scenario.clearance + error.horizontal:.3g} m of where it would land"


def require_level_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a UAV that lands below its last waypoint would land on a slope or the edge of a roof."""
    _refuse(scenario, [(plan, why_not_level(scenario, plan.route.uav, plan.ending[-1])) for plan in plans])


def require_clear_landings(scenario: Scenario, plans: Sequence[FlightPlan]) -> None:
    """Raise `InputError` where a UAV that lands below its last waypoint would land beside something."""
    _refuse(scenario, [(plan, why_not_clear(scenario, plan.route.uav, plan.ending[-1])) for plan in plans])


def _refuse(scenario: Scenario, asked: list[tuple[FlightPlan, str | None]]) -> None:
    """Raise `InputError` for those UAVs that should not land, with the places and the reasons."""
    refused = []
    for plan, why in asked:
        if why is not None:
            latitude, longitude, _ = to_wgs84(origin_of(scenario), plan.ending[-1:])[0].tolist()
            name = scenario.uavs[plan.route.uav].name
            refused.append(
                f"{name}: it cannot land below its last waypoint, at {latitude:.5f}, {longitude:.5f}, as {why}"
            )
    if refused:
        more = f"; and {counted(len(refused) - MAX_TOLD, 'more UAV')}" if len(refused) > MAX_TOLD else ""
        stay = Remedy("end", "loiter", "to stay at the target")
        raise InputError(f"{'; '.join(refused[:MAX_TOLD])}{more}. Choose other targets", field="end", give=[stay])


def ground_notes(scenario: Scenario, plans: Sequence[FlightPlan]) -> Iterator[str]:
    """Yield sentences on homes that are not known or not level, and on what is not known where UAVs land."""
    unknown = [scenario.uavs[plan.route.uav] for plan in plans if _starts_in_the_air(scenario, plan.route.uav)]
    if unknown:
        told = ", ".join(f"{vehicle.name} at z = {vehicle.start[2]:.4g} m" for vehicle in unknown)
        yield (
            f"{Caution.WARNING}: homes that are not known, as the scenario has no terrain, and are taken to be the "
            f"starts: {told}. Where a UAV arms lower, it returns as much lower than is proven: state its home."
        )
    steep = []
    for plan in plans:
        vehicle = scenario.uavs[plan.route.uav]
        if vehicle.fixed_wing is not None or (scenario.terrain is None and vehicle.home is None):
            continue  # it takes off elsewhere, or from where the ground is not known
        why = why_not_level(scenario, plan.route.uav, plan.home)
        if why is not None:
            steep.append(f"{vehicle.name}: {why}")
    if steep:
        places = "; ".join(steep)
        yield f"{Caution.WARNING}: homes that are not level: {places}. Choose other starts, or level the places."
    if scenario.terrain is not None and not any(shape.solid for shape in scenario.obstacles):
        yield (
            f"{Caution.WARNING}: the scenario knows the ground and no obstacles: trees, roofs and water are unknown; "
            "look at where UAVs fly low and land."
        )


def _starts_in_the_air(scenario: Scenario, uav: int) -> bool:
    """Tell whether a multirotor's start, above the lower bound, is taken as home for want of a terrain."""
    vehicle = scenario.uavs[uav]
    if vehicle.fixed_wing is not None or vehicle.home is not None or scenario.terrain is not None:
        return False
    start = np.array(vehicle.start)
    return bool(start[2] > ground_below(scenario, start) + LEG_ALLOWANCE)
