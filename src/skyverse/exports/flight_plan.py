"""What a file tells one autopilot: when to take off, how fast to fly each leg, how to end; and the flight that follows.

The flight is kinematic: a vertical take-off at the autopilot's climb rate, some time after the command for it, legs at
the commanded speed or as fast as it climbs and descends, corners cut within the acceptance radius, and a constant
acceleration wherever it starts or stops.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.autopilots import Autopilot, AutopilotRates, End, rates_of, takeoff_cut
from skyverse.exports.leg_geometry import towards
from skyverse.exports.route import Route
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.tolerances import MIN_LEG_DURATION, SAME_PLACE

MIN_SPEED = 0.2
"""m/s: no slower speed is commanded. Copter ignores a command to fly slower."""
SPEED_TOLERANCE = 0.1
"""The share by which an autopilot's speed may be off the commanded one."""
SPEED_CHANGE = 1.01
"""A new speed is commanded where it differs from the last by more than this factor."""


@dataclass(frozen=True, eq=False)
class FlightPlan:
    """One UAV's mission, as a file tells it to an autopilot.

    Attributes
    ----------
    route
        The waypoints.
    autopilot, rates
        The autopilot that the file is for, and how fast it climbs, descends, starts and stops.
    home
        (3,) metres: where the UAV stands before it takes off.
    delay
        Seconds that it waits there for the command to take off.
    hover
        Seconds that it waits at the first waypoint: instead, where a file cannot tell its autopilot to wait below, and
        for a target there.
    speeds
        (m,) m/s: the commanded speed of each of the m legs after the take-off.
    top_speed
        m/s: the speed at which it returns, and the highest that may be commanded but for speed limits of zones.
    takeoff_cut
        Metres below its first waypoint at which the UAV may turn to the next: PX4 ends a take-off that early.
    ending
        (k, 3) metres: where it flies after the last waypoint, to land there or at home; empty where it stays.
    begin
        When the mission is to be started, seconds after all UAVs start together: later than 0 for later sorties.
    end
        What it does at its last waypoint.
    """

    route: Route
    autopilot: Autopilot
    rates: AutopilotRates
    home: Floats
    delay: float
    hover: float
    speeds: Floats
    top_speed: float
    takeoff_cut: float
    ending: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    begin: float = 0.0
    end: End = "loiter"

    @property
    def waypoints(self) -> Floats:
        """(m + 1, 3) metres: the end of the take-off, and the waypoints after it."""
        return self.route.waypoints

    @property
    def parts(self) -> list[range]:
        """The waypoints of each file: all in one, or as many as one takes, each beginning where the last one ended."""
        count, most = len(self.waypoints), self.autopilot.max_waypoints
        found, start = list[range](), 0
        while start < max(count - 1, 1):
            end = min(start + most, count)
            cut = [k for k in range(end, start + 1, -1) if not any(run.on < k - 1 < run.off for run in self.route.runs)]
            end = end if end == count else (cut or [end])[0]  # photos of one run stay in one file
            found.append(range(start, end))
            start = max(end - 1, start + 1)
        return found

    @property
    def breaks(self) -> set[int]:
        """The waypoints at which a file ends that is not the last: the UAV waits there for the start of the next."""
        return {part[-1] for part in self.parts[:-1]}

    @property
    def full_stops(self) -> Floats:
        """(m + 1,) 1 where the UAV is at rest at a waypoint, else 0."""
        stops = np.array(self.route.waypoint_holds > 0, dtype=np.float64)
        if self.autopilot.stops:
            stops[self.route.waypoint_radii <= 0] = 1.0
            stops[[*self.breaks]] = 1.0
        stops[[0, -1]] = 1.0
        return stops

    @property
    def corners_proven(self) -> bool:
        """Whether its corners are proven: not those at which an aeroplane's autopilot turns at its own distance."""
        known = bool(np.isfinite(self.rates.climb)) or self.autopilot.plane_radius <= self.route.radius
        return known or len(self.waypoints) <= 2

    @property
    def takeoff_seconds(self) -> float:
        """How long the take-off takes, from the command for it to the end of the climb."""
        return self._takeoff().knots[-1] - self.delay - self.begin

    def predicted(self) -> Trajectory:
        """Return the flight from when it rises to the end of the mission."""
        return self._motion().trajectory()

    @property
    def arrivals(self) -> Floats:
        """(m + 1,) seconds: when the UAV arrives at its waypoints, or turns beside them."""
        return np.array(self._motion().arrivals)

    def _takeoff(self) -> "_Motion":
        rates, top = self.rates, self.waypoints[0]
        made = _Motion(self.home, self.begin + self.delay + rates.startup)
        rise = top - self.home
        height = math.hypot(*rise)
        low = min(rates.takeoff_height / height, 1.0) if height else 1.0
        stop = 0.0 if self.takeoff_cut else 1.0  # an autopilot that turns earlier has hardly braked by then
        made.fly(self.home + low * rise, rates.takeoff, rates.takeoff_acceleration, 1.0, stop if low == 1.0 else 0.0)
        made.fly(top, rates.climb, rates.vertical_acceleration, 0.0, stop)
        made.arrivals.append(made.knots[-1])
        return made

    def _motion(self) -> "_Motion":
        made = self._takeoff()
        stops, holds = self.full_stops, self.route.waypoint_holds
        made.wait(self.hover)
        for k, (to, speed) in enumerate(zip(turning_points(self.route, stops), self.speeds, strict=True), 1):
            pace = attainable_speed(made.at, to, float(speed), self.rates)
            made.fly(to, pace, self.rates.acceleration, stops[k - 1], stops[k])
            made.arrivals.append(made.knots[-1])
            made.wait(float(holds[k]))
        for to in self.ending:
            made.fly(to, attainable_speed(made.at, to, self.top_speed, self.rates), np.inf, 0.0)
        return made


class _Motion:
    """A trajectory that grows leg by leg."""

    def __init__(self, at: Floats, begin: float) -> None:
        self.at, self.knots, self.rows = at, [begin], [np.zeros((0, 3, 3))]
        self.arrivals: list[float] = []

    def wait(self, seconds: float) -> None:
        """Stay for some seconds."""
        if seconds > 0:
            self._add(np.zeros(3), 0.0, 0.0, seconds)

    def fly(self, to: Floats, pace: float, acceleration: float, *stops: float) -> None:
        """Fly straight to a place at a pace, m/s; `stops` tells whether it is at rest at the start and at the end."""
        way = to - self.at
        length = math.hypot(*way)
        if length < SAME_PLACE:
            return
        start, stop = (*stops, 0.0)[:2]
        ends = start + stop
        pace = min(pace, np.sqrt(2 * length * acceleration / ends)) if ends else pace
        ramp = pace / acceleration if ends else 0.0
        ahead = way / length
        if start:
            self._add(ahead, 0.0, acceleration, ramp)
        self._add(ahead, pace, 0.0, (length - ends * pace * ramp / 2) / pace)
        if stop:
            self._add(ahead, pace, -acceleration, ramp)
        self.at = to

    def _add(self, ahead: Floats, pace: float, acceleration: float, seconds: float) -> None:
        if seconds <= MIN_LEG_DURATION:
            return
        self.rows.append(np.array([[self.at, pace * ahead, acceleration / 2 * ahead]]))
        self.knots.append(self.knots[-1] + seconds)
        self.at = self.at + (pace * seconds + acceleration / 2 * seconds**2) * ahead

    def trajectory(self) -> Trajectory:
        """Return what was added."""
        self.wait(1.0 if len(self.knots) == 1 else 0.0)
        return Trajectory(np.array(self.knots), np.concatenate(self.rows))


def flight_plans(
    scenario: Scenario, flown: Sequence[Route], autopilot: Autopilot, homes: Sequence[Floats]
) -> list[FlightPlan]:
    """Return the flight plan of each route, all on one schedule.

    Every UAV is at the end of its take-off when its trajectory begins, all of them later by as much as the longest
    take-off needs; from there its speeds make it arrive at each waypoint when the trajectory does, as far as its limits
    allow. A later sortie is started when it is its turn.

    Parameters
    ----------
    scenario, flown, autopilot
        What was given, the routes, and the autopilot that flies them.
    homes
        Where each of the UAVs stands before it takes off, (3,) metres each.
    """
    blanks = [_at_once(scenario, one, autopilot, home) for one, home in zip(flown, homes, strict=True)]
    begins = [float(one.route.times[0]) - one.takeoff_seconds for one in blanks]
    leasts = [autopilot.least_delay if scenario.uavs[one.uav].fixed_wing is None else 0.0 for one in flown]
    late = max((least - begin for least, begin in zip(leasts, begins, strict=True)), default=0.0)
    made = []
    for blank, begin, least in zip(blanks, begins, leasts, strict=True):
        delay = round(max(max(late, 0.0) + begin, least), 3)
        wing = scenario.uavs[blank.route.uav].fixed_wing
        speeds = _speeds(blank) if wing is None else np.full(len(blank.speeds), wing.speed)
        begin, delay = (round(delay - least, 3), least) if blank.route.sortie > 1 else (0.0, delay)
        below, above = (0.0, delay) if autopilot.waits_above else (delay, 0.0)
        above += float(blank.route.waypoint_holds[0])  # of a target where it starts
        made.append(replace(blank, speeds=speeds, begin=begin, delay=below, hover=above))
    return made


def in_turn(scenario: Scenario, plans: Sequence[FlightPlan]) -> list[FlightPlan]:
    """Return flight plans of which no sortie begins before the one before it has ended and the battery is changed."""
    made, ready = list[FlightPlan](), dict[int, float]()
    for plan in plans:
        uav = plan.route.uav
        made.append(replace(plan, begin=max(plan.begin, round(ready.get(uav, 0.0), 3))))
        ready[uav] = made[-1].predicted().end + scenario.uavs[uav].swap
    return made


def _at_once(scenario: Scenario, route: Route, autopilot: Autopilot, home: Floats) -> FlightPlan:
    """Return the flight plan of a route without a wait, and without the speeds of its legs."""
    vehicle = scenario.uavs[route.uav]
    wing, rates = vehicle.fixed_wing, rates_of(vehicle, autopilot)
    top = max(min(vehicle.max_speed, autopilot.max_speed), MIN_SPEED) if wing is None else wing.speed
    cut = takeoff_cut(autopilot.name, float(route.waypoint_radii[0])) if wing is None else 0.0  # where it is in flight
    return FlightPlan(route, autopilot, rates, home, 0.0, 0.0, np.ones(len(route.waypoints) - 1), top, cut)


def turning_points(route: Route, stops: Floats) -> Floats:
    """Return where an autopilot turns to the next leg, (m, 3) metres, for each waypoint after the take-off."""
    found = [route.waypoints[0]]
    for k, waypoint in enumerate(route.waypoints[1:], 1):
        reach = 0.0 if stops[k] else float(route.waypoint_radii[k])
        found.append(waypoint + towards(found[-1] - waypoint, reach))
    return np.array(found[1:])


def attainable_speed(a: Floats, b: Floats, speed: float, rates: AutopilotRates) -> float:
    """Return the speed along a leg, m/s: what is commanded, or less where that climbs or descends too fast."""
    length, up = math.dist(b, a), float(b[2] - a[2])
    limit = rates.climb if up > 0 else rates.descent
    return min(speed, limit * length / abs(up)) if up else speed


def _speeds(plan: FlightPlan) -> Floats:
    """Return the commanded speeds by which a UAV keeps to the times of its route, as far as it can."""
    route, stops = plan.route, plan.full_stops
    places = np.concatenate([route.waypoints[:1], turning_points(route, stops)])
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1)
    seconds = np.maximum(np.diff(route.waypoint_times) - route.waypoint_holds[:-1], MIN_LEG_DURATION)
    ends = stops[:-1] + stops[1:]
    acceleration = plan.rates.acceleration
    limits, speeds = np.full(len(lengths), plan.top_speed), list[float]()
    for run in route.runs:  # also on the run-in
        limits[max(run.on - 1, 0) : run.off] = np.minimum(limits[max(run.on - 1, 0) : run.off], run.fastest)
    for length, time, stopped, limit in zip(lengths, seconds, ends, limits.tolist(), strict=True):
        wanted = length / time
        if stopped:  # solve time = length / speed + stopped * speed / (2 * acceleration), the slower solution
            least = 2 * stopped * length / acceleration  # the square of the time of one that is only ramps
            wanted = (max(time, np.sqrt(least)) - np.sqrt(max(time**2 - least, 0.0))) * acceleration / stopped
        speed = round(float(np.clip(wanted, MIN_SPEED, max(limit, MIN_SPEED))), 3)
        kept = speeds and speeds[-1] / SPEED_CHANGE <= speed <= speeds[-1] * SPEED_CHANGE and speeds[-1] <= limit
        speeds.append(speeds[-1] if kept else speed)
    for run in route.runs:
        if 0 < run.on < run.off and not stops[run.on - 1 : run.on + 1].any():  # its speed is that of its run-in
            speeds[run.on - 1] = speeds[run.on]
    return np.array(speeds)
