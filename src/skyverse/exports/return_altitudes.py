"""The altitudes at which UAVs return: of many, the first at which the way home is proven at every instant."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skyverse.exports.autopilots import RETURN_ALTITUDES
from skyverse.exports.flight_parts import Parts
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.way_home import UNPROVEN, WAYS, Gap, Returns, WayHome, layer
from skyverse.exports.way_home_space import ReturnSpace, proven
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import LEG_ALLOWANCE

USUAL_ALTITUDE = 30.0
"""Metres above home: a lower return altitude is taken only where none from here on is as good."""
MIN_RETURN_ALTITUDE = 5.0
"""Metres above home: no lower return altitude is chosen where there is room for it."""
ABOVE_FLIGHT = 0.2
"""Metres above the whole flight, its error included, of an altitude that is tried: altitudes are rounded to 0.1 m."""
ALTITUDES, LOW_ALTITUDES = 24, 4
"""How many return altitudes are tried, from the lowest to the upper bound; and how many lower ones."""
SEARCHED = 3
"""How many altitudes are searched at most where none is clear from all samples of the flight."""
SAMPLES = 64
"""Places of a flight from which an altitude is tried before it is searched."""


def ways_home(scenario: Scenario, plans: Sequence[FlightPlan], altitude: float | None = None) -> list[WayHome | None]:
    """Return how each UAV comes home, ``None`` for aeroplanes, whose circles are not judged.

    Return altitudes are the one that is asked for, metres above home, or else apart from one another by the separations
    of UAVs, where there is room. What the referee does not prove is not proven.
    """
    space, found = ReturnSpace(scenario), list[WayHome | None]()
    for plan in plans:
        if scenario.uavs[plan.route.uav].fixed_wing is not None:
            found.append(None)
            continue
        returns = Returns(scenario, space, plan)
        others = [one for one in found if one is not None and one.plan.route.uav != plan.route.uav]
        taken = [(one.level, layer(scenario, one.plan, plan)) for one in others]
        found.append(_best(returns, taken) if altitude is None else returns.at(altitude))
    if proven([line for one in found if one is not None for line in one.lines]):
        return found
    return [one if one is None or proven(one.lines) else replace(one, gaps=_all_of(one.plan)) for one in found]


def _best(returns: Returns, taken: Sequence[tuple[float, float]]) -> WayHome:
    """Return the way home at the first altitude at which it is proven at every instant, or else the best.

    Altitudes are preferred that are as far from those that are `taken`, z and how far to keep from it, metres.
    """
    samples, home = returns.legs.samples(SAMPLES), float(returns.home[2])
    altitudes = _altitudes(returns, [z + side * keep for z, keep in taken for side in (-1.0, 1.0)])
    blocked = {one: _blocked(returns, samples, one) for one in altitudes}
    close = {one for one in altitudes if any(abs(home + one - z) < keep for z, keep in taken)}
    tried = list[WayHome]()
    for one in sorted(altitudes, key=lambda one: (blocked[one], one in close)):
        if blocked[one] and len(tried) >= SEARCHED:
            break
        tried.append(returns.at(one))
        if not blocked[one] and all(gap.why == WAYS[-1] for gap in tried[-1].gaps):
            return tried[-1]

    def worse(way: WayHome) -> tuple[bool, int, bool]:
        lost = sum(gap.end - gap.begin for gap in way.gaps)
        return not way.ends_safely, int(lost), way.altitude in close  # a part of a second is no reason

    return min(tried, key=worse)


def _blocked(returns: Returns, samples: Parts, altitude: float) -> float:
    """Return from how many samples of the flight an altitude leads into something; its end counts as all others."""
    clear = returns.clear(samples, float(returns.home[2]) + altitude)[:, :-1]
    free = np.logical_and.reduce(clear, axis=1)
    return float((~free[:-1]).sum() + (len(free) - 1) * (not free[-1]))


def _altitudes(returns: Returns, more: Sequence[float]) -> list[float]:
    """Return the return altitudes to try, metres above home, and those of some heights z: the usual ones first.

    Then come those that are no lower than the flight itself, and at last lower ones, the highest of them first.
    """
    scenario, plan, home, stray = returns.scenario, returns.plan, float(returns.home[2]), returns.error.vertical
    waypoints = plan.waypoints
    top = scenario.bounds.max[2] - stray
    low = min(max(float(waypoints[0][2]), home + MIN_RETURN_ALTITUDE), top)
    flown = float(waypoints[:, 2].max())
    above = flown + stray + max(plan.route.deviations, default=0.0) + ABOVE_FLIGHT
    levels = [*np.linspace(low, top, ALTITUDES), home + USUAL_ALTITUDE, flown, above, *more]
    if scenario.terrain is not None and scenario.max_height is not None:
        lowest = float(scenario.terrain.lowest_ground.height(waypoints[:, :2]).min())
        most = lowest + scenario.max_height - stray - LEG_ALLOWANCE
        levels += np.linspace(low, most, ALTITUDES).tolist()
    least, most = RETURN_ALTITUDES[plan.autopilot.name]
    lower = np.linspace(least, low - home, LOW_ALTITUDES, endpoint=False)
    tenths = np.unique(np.round(10 * np.r_[np.clip(levels, low, top) - home, lower] - 0.499)) / 10
    able = [one for one in tenths.tolist() if least <= one <= most] or [least]

    def preference(altitude: float) -> tuple[int, float]:
        if altitude >= USUAL_ALTITUDE:
            return 0, altitude
        return (1, altitude) if home + altitude >= flown else (2, -altitude)

    return sorted(able, key=preference)


def _all_of(plan: FlightPlan) -> tuple[Gap]:
    """Return the whole flight as a gap."""
    return (Gap(plan.begin, float(plan.arrivals[-1]), UNPROVEN, plan.waypoints[0]),)
