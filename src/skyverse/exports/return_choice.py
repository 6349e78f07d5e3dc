"""Chooses a return altitude together with rally points, where from home alone there is no way home at every instant.

Places below the flight are tried as rally points at every altitude: from samples of the flight to each place the whole
return is checked, so that the best set of places is then a matter of counting. The most promising are searched.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.flown_legs import Parts, joined_parts
from skyverse.exports.landing import ground_level, surface_below
from skyverse.exports.landing_ground import why_not_clear, why_not_level
from skyverse.exports.return_destinations import ACCEPTANCE, Destination, destination, far_enough_from_home
from skyverse.exports.return_lines import ReturnSpace
from skyverse.exports.way_home import Found, WayHome
from skyverse.model.scenario import Scenario

MAX_RALLY_POINTS = {"px4": 5, "ardupilot": 5, "dji": 0}
"""How many rally points are added at most: DJI takes none, and each is a place to keep clear of people."""
USUAL_ALTITUDE = 30.0
"""Metres above home: a lower return altitude is taken only where none from here on is as good."""
RALLY_PLACES = 24
"""How many places below a flight are tried as rally points."""
COUNTED_PLACES = 96
"""Places of a flight from which the return to each of those is tried."""
SEARCHED_CHOICES = 3
"""How many choices of an altitude and rally points are searched."""
NEARBY_PLACES = 5
"""How many places below what is then still without a way home are tried for one more rally point."""


@dataclass(frozen=True, eq=False)
class ReturnChoice:
    """Looks for a return altitude and rally points of one UAV; a DJI aircraft takes no rally points.

    Attributes
    ----------
    scenario, space
        The scenario, and what returning UAVs keep clear of.
    plan
        The flight.
    base, end
        Home, and where the flight ends, as places to land at.
    """

    scenario: Scenario
    space: ReturnSpace
    plan: FlightPlan
    base: Destination
    end: Destination

    @property
    def most(self) -> int:
        """How many rally points there may be."""
        return MAX_RALLY_POINTS[self.plan.autopilot.name]

    def way(self, rally: Iterable[Destination], altitude: float) -> WayHome:
        """Return the way home at an altitude, metres above home, to the nearest of home and rally points."""
        return WayHome(self.scenario, self.space, self.plan, [self.base, *rally], self.end, altitude)

    def best(self, altitudes: Sequence[float], known: tuple[WayHome, Found]) -> tuple[WayHome, Found]:
        """Return the best way home at any of some altitudes, metres above home, or the one that is known already."""
        best = known
        for way in self._promising(altitudes):
            found = way.search()
            if lost_share(way, found) < lost_share(*best):
                best = way, found
            if not len(found.lost.leg):
                return best
        return self._with_more(*best)

    def _promising(self, altitudes: Sequence[float]) -> Iterator[WayHome]:
        """Yield ways home, each at another altitude: first that with the fewest samples without, then rally points."""
        flight = self.way([], altitudes[0]).legs
        rally = self._destinations(flight.middles(flight.samples(RALLY_PLACES))) if self.most else []
        samples = joined_parts([flight.samples(COUNTED_PLACES), flight.last_place()])
        weights = np.r_[np.ones(COUNTED_PLACES), float(COUNTED_PLACES)]  # the end counts most: there a UAV stays
        choices = []
        for altitude in altitudes:
            way = self.way(rally, altitude)
            chosen, cost = _chosen(way, samples, weights, self.most)
            choices.append((cost, len(chosen), preference(self.plan, altitude), altitude, chosen))
        for _, _, _, altitude, chosen in sorted(choices)[:SEARCHED_CHOICES]:
            yield self.way([rally[k - 1] for k in chosen[1:]], altitude)

    def _with_more(self, way: WayHome, found: Found) -> tuple[WayHome, Found]:
        """Return a way home with more rally points, below what is without a way home, as long as they help."""
        while len(found.lost.leg) and len(way.destinations) <= self.most and way.can_climb(found.lost):
            rally = way.destinations[1:]
            ways = [self.way([*rally, place], way.altitude) for place in self._below(way, found.lost)]
            if not ways:
                break
            blocked = [one.blocked(found.lost) + one.blocked() for one in ways]
            better = ways[blocked.index(min(blocked))]
            tried = better.search()
            if not lost_share(better, tried) < lost_share(way, found):
                break
            way, found = better, tried
        return way, found

    def _below(self, way: WayHome, lost: Parts) -> list[Destination]:
        """Return places to land at, spread over some parts of the flight, and below its end."""
        some = np.unique(np.linspace(0, len(lost.leg) - 1, NEARBY_PLACES).round().astype(int))
        return self._destinations(way.legs.middles(lost.of(some)))

    def _destinations(self, above: Floats) -> list[Destination]:
        """Return where a UAV may land below places (n, 3), metres, and below its end.

        It does not land near home, where PX4 ignores rally points, nor where the ground or a roof is not level, nor
        beside something.
        """
        uav, found = self.plan.route.uav, []
        for place in [*above, self.plan.waypoints[-1]]:
            if not far_enough_from_home(self.scenario, self.plan.home, place):
                continue
            surface = surface_below(self.scenario, place, ground_level(self.scenario, uav))
            below = np.array([*place[:2], surface])
            beside = ACCEPTANCE[self.plan.autopilot.name].radius
            if why_not_level(self.scenario, uav, below, beside) or why_not_clear(self.space, uav, below, beside):
                continue
            found.append(destination(self.scenario, self.space, self.plan, below, float(place[2])))
        return found


def preference(plan: FlightPlan, altitude: float) -> tuple[int, float]:
    """Return by what return altitudes, metres above home, are sorted to be tried: first usual ones, the lowest first.

    Then come those that are no lower than the flight itself, and at last lower ones, the highest of them first.
    """
    if altitude >= USUAL_ALTITUDE:
        return 0, altitude
    flown = float((plan.waypoints[:, 2] - plan.home[2]).max())
    return (1, altitude) if altitude >= flown else (2, -altitude)


def lost_share(way: WayHome, found: Found) -> tuple[bool, float]:
    """Return whether there is no way home from the end of the flight, and from how many metres of it there is none.

    The less of both, the better; the end counts first, for there a UAV stays.
    """
    lost = found.lost
    last = (lost.leg == len(way.legs.starts) - 1) & (lost.end >= 1.0)
    return bool(last.any()), way.legs.metres(lost)


def _chosen(way: WayHome, samples: Parts, weights: Floats, most: int) -> tuple[list[int], float]:
    """Return which destinations of a way home make a good set, the first always, and the weight of what they leave out.

    From a sample there is a way home if the UAV gets to all destinations of the set to which it may return; otherwise
    the sample's weight, (n,), counts. At most so many destinations are added, always the one that helps most.
    """
    away, reach = way.away(samples), way.reaches(samples)

    def cost(chosen: list[int]) -> float:
        taken = way.taken(away[:, chosen], np.zeros(len(away)))
        return float(weights[(taken & ~reach[:, chosen]).any(axis=1)].sum())

    chosen = [0]
    least = cost(chosen)
    while least > 0 and len(chosen) <= most:
        costs = [cost([*chosen, k]) for k in range(away.shape[1])]
        if min(costs) >= least:
            break
        least = min(costs)
        chosen.append(costs.index(least))
    return chosen, least
