"""The best that a flight could have been: lower bounds of its length and its time that hold whatever moves.

A path is no shorter among movers than among what stands still, so that `Taut`'s proven bound of its length holds. A UAV
begins and ends at rest, without acceleration. So t seconds after the beginning, and as long before the end, its
acceleration is at most min(a, j t), where a and j are its largest acceleration and jerk, and its speed at most

    V(t) = j t^2 / 2                for t <= a / j,
    V(t) = a t - a^2 / (2 j)        after that,

and never above its largest speed v. The least time T for a length L is the one for which the integral of
min(v, V(t), V(T - t)) over 0 to T is L. On curved paths, too, no flight is faster.
"""

import math

from skyverse.model.scenario import Scenario
from skyverse.model.uav import UAV
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem


def least_lengths(scenario: Scenario, assignment: tuple[int | None, ...]) -> list[float]:
    """Return a lower bound of the length that each UAV must fly to its target, metres; 0 without a target."""
    airspace = Airspace(scenario)
    found = []
    for uav, target in enumerate(assignment):
        if target is None:
            found.append(0.0)
            continue
        problem = Problem(airspace, uav, target)
        bound = Taut().plan(problem).bound  # a price, of metres that cost `fuel` each
        apart = math.dist(problem.uav_place, problem.target_place)
        found.append(max((bound or 0.0) / scenario.objective.fuel, apart) if scenario.objective.fuel > 0 else apart)
    return found


def least_seconds(length: float, uav: UAV) -> float:
    """Return the least time in which a UAV can fly so many metres from rest to rest."""
    if length <= 0.0:
        return 0.0
    low, high = 0.0, 1.0
    while _reach(high, uav) < length:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _reach(middle, uav) < length else (low, middle)
    return low


def _reach(seconds: float, uav: UAV) -> float:
    """Return how far at most a UAV gets from rest to rest in so many seconds, metres."""
    top, a, jerk = uav.max_speed, uav.max_acceleration, uav.max_jerk
    ramp = a / jerk
    fastest = math.sqrt(2.0 * top / jerk)  # the instant at which V(t) = v
    if fastest > ramp:
        fastest = top / a + 0.5 * ramp
    rising = min(0.5 * seconds, fastest)
    if rising <= ramp:
        covered = jerk * rising**3 / 6.0
    else:
        covered = jerk * ramp**3 / 6.0 + 0.5 * a * (rising**2 - ramp**2) - 0.5 * a * ramp * (rising - ramp)
    return 2.0 * covered + top * max(seconds - 2.0 * fastest, 0.0)
