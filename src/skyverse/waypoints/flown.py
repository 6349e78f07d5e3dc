"""A mission as its autopilot flies it in a scenario: places in local metres, and each leg at its speed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.autopilots import End, rates_of
from skyverse.exports.flight_plan import MIN_SPEED, FlightPlan
from skyverse.exports.landing import landing_places
from skyverse.exports.leg_geometry import ground_under, leg_deviation
from skyverse.exports.route import Route
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.scenario import Scenario
from skyverse.model.waypoints import Waypoints
from skyverse.numerics.tolerances import MAVLINK_ROUNDING
from skyverse.space.pads import lifted
from skyverse.space.world import World
from skyverse.waypoints.defaults import settled
from skyverse.waypoints.unrolled import ReachedWaypoint, Unrolled, base_over


@dataclass(frozen=True, eq=False)
class FlownMission:
    """A mission as it is flown.

    Attributes
    ----------
    waypoints
        What the autopilot is told.
    visits
        The places that it flies to, in order; the first is the end of the take-off.
    plan
        The flight, whose waypoints these are.
    end
        What the vehicle does at the last of them.
    return_altitude
        Metres above home at which it returns, where it does not retrace its mission.
    retraces
        Whether it does.
    lifts
        (base, top) of the axes over places where it takes off and lands, (3,) metres each; see `LegChecker`.
    assumed
        What was taken from defaults, since the file does not say it, in words.
    """

    waypoints: Waypoints
    visits: tuple[ReachedWaypoint, ...]
    plan: FlightPlan
    end: End
    return_altitude: float
    retraces: bool
    lifts: tuple[tuple[Floats, Floats], ...]
    assumed: tuple[str, ...]

    def numbers(self, k: int) -> tuple[int, ...]:
        """Return the numbers of the orders between which leg k leads, as ground stations show them."""
        pair = [self.visits[j].order.number for j in self.ends(k) if 0 <= j < len(self.visits)]
        return tuple(dict.fromkeys(pair))

    def ends(self, k: int) -> tuple[int, int]:
        """Return the visits between which the leg leads of which the one to visit k is a part, or which it is."""
        before, after = k - 1, k
        while self.is_part(before):
            before -= 1
        while self.is_part(after):
            after += 1
        return before, after

    @property
    def legs(self) -> int:
        """How many legs its orders ask for after the take-off."""
        return sum(not self.is_part(k) for k in range(1, len(self.visits)))

    @property
    def returns_along(self) -> bool:
        """Whether an order to return leads along the mission, too; ArduPilot's leads straight home."""
        return self.retraces and self.plan.autopilot.name == "px4"

    def is_part(self, k: int) -> bool:
        """Tell whether visit k is one on the way of its order over the ground."""
        if not 0 <= k < len(self.visits) - 1:
            return False
        one, after = self.visits[k : k + 2]
        return after.follows and one.order is after.order and not one.order.turns


def flown(waypoints: Waypoints, scenario: Scenario, uav: int, home: Floats, settings: FlightSettings) -> FlownMission:
    """Return how a mission is flown by a UAV of a scenario that stands at its `home`, (3,) metres."""
    vehicle = scenario.uavs[uav]
    told = settled(waypoints, settings, vehicle.max_speed)
    unrolled = Unrolled(waypoints, scenario, home, told)
    unrolled.run()
    visits, autopilot = unrolled.visits, told.autopilot
    if len(visits) < 2:
        raise InputError(f"{waypoints.name}: expected a place to fly to after the take-off, found none")
    lifts = tuple(lifts_over(scenario, uav, [base_over(scenario, place) for place in (home, *unrolled.landings)]))
    base, places = lifts[0][0], np.array([visit.at for visit in visits])
    rises = vehicle.fixed_wing is None  # straight up, which no aeroplane does
    takeoff = max(float(places[0, 2] - base[2]), 0.0) if rises else 0.0
    points = np.array([base, *places]) if takeoff else places
    more = len(points) - len(places)
    radii, holds = (np.r_[np.zeros(more), [getattr(one, name) for one in visits]] for name in ("radius", "hold"))
    off = _deviations(scenario, visits)
    over = np.array([visit.aside if visit.follows else np.nan for visit in visits[1:]])
    times, nowhere = np.zeros(len(points)), np.full(len(points), -1)
    route = Route(uav, points, times, radii, takeoff, points[:more], 0.0, holds, off, lifts, over, nowhere)
    speeds = np.array([one.speed for one in visits[1:]])
    rates = rates_of(vehicle, autopilot)
    begin, first = home if rises else places[0], max(told.speed, MIN_SPEED)
    cut = visits[0].radius if rises and autopilot.name == "px4" else 0.0
    plan = FlightPlan(route, autopilot, rates, begin, unrolled.delay, 0.0, speeds, first, cut)
    if unrolled.end == "land":
        plan = replace(plan, ending=np.array(landing_places(scenario, [plan])))
    assumed = tuple(dict.fromkeys((*told.assumed, *unrolled.assumed)))
    up, retraces = told.return_altitude, settings.retraces or waypoints.retraces
    made = FlownMission(waypoints, tuple(visits), plan, unrolled.end, up, retraces, lifts, assumed)
    return replace(made, plan=replace(plan, ending=_return(made))) if made.end == "rtl" else made


def _return(flown: FlownMission) -> Floats:
    """Return where a return leads after the last waypoint: up, over home and down, or back along the mission."""
    points, home = flown.plan.waypoints, flown.plan.home
    if flown.returns_along:
        return np.stack([*points[-2::-1], home])
    level = max(float(home[2]) + flown.return_altitude, float(points[-1, 2]))
    return np.array([[*points[-1, :2], level], [*home[:2], level], home])


def _deviations(scenario: Scenario, visits: Sequence[ReachedWaypoint]) -> Floats:
    """Return how far each leg between visits may be off the straight line, metres."""
    places = np.array([visit.at for visit in visits])
    off = MAVLINK_ROUNDING + leg_deviation(scenario, np.linalg.norm(np.diff(places, axis=0)[:, :2], axis=1))
    for k, visit in enumerate(visits[1:]):
        if visit.follows and scenario.terrain is not None:
            off[k] += visit.aside + ground_under(scenario.terrain, places[k : k + 2], 0.0).bend
    return off


def lifts_over(scenario: Scenario, uav: int, bases: Sequence[Floats]) -> Iterator[tuple[Floats, Floats]]:
    """Yield from where to where over each base the error of a UAV counts for what is beside it alone."""
    nominal, strayed = World(scenario), World(scenario, scenario.uavs[uav].tracking_error)
    for base in bases:
        x, y, z = base.tolist()
        yield base, lifted(nominal, strayed, uav, (x, y, z))
