"""The orders of a mission followed one by one, jumps and circles unrolled, to the places to which they lead."""

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError
from skyverse.exports.autopilots import End
from skyverse.exports.leg_geometry import ground_under
from skyverse.model.altitude import AboveGround, AboveHome, GlobalPlace
from skyverse.model.geodesy import to_local
from skyverse.model.pad import ground_height
from skyverse.model.scenario import Scenario
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.numerics.tolerances import LEG_ALLOWANCE, SAME_PLACE
from skyverse.waypoints.defaults import MAX_STEPS, MAX_VISITS, USUAL_CIRCLE, Settled

DJI_SAFELY = "safely"
"""How DJI calls a take-off that climbs as high as the first waypoint, and flies there on one level."""
OFF_CIRCLE = 0.02
"""Metres that the polygon which stands for a circle may be off it."""
STOP = 0.001
"""Seconds of a stop whose length no order says."""
MAX_BEND, LEAST_PART = 2.0, 2.0
"""Metres that the ground rises or falls, at most, beside a straight part of a leg that follows it; and its length."""
_MOVES = (OrderKind.TAKEOFF, OrderKind.WAYPOINT, OrderKind.LOITER, OrderKind.RETURN, OrderKind.LAND)


class ReachedWaypoint(NamedTuple):
    """A place to which an order leads.

    Attributes
    ----------
    order
        The order.
    at
        (3,) metres.
    radius, hold
        Metres within which the vehicle may turn to the next, and seconds that it stops; one of them is 0.
    speed
        m/s on the leg to it.
    follows
        Whether that leg follows the ground; then it leads there in straight parts, each of which ends at a visit.
    aside
        Metres that the vehicle may be beside such a part, as it has cut the corner before.
    """

    order: Order
    at: Floats
    radius: float
    hold: float
    speed: float
    follows: bool = False
    aside: float = 0.0


@dataclass
class Unrolled:
    """The orders of a mission, followed one by one."""

    waypoints: Waypoints
    scenario: Scenario
    home: Floats
    told: Settled
    visits: list[ReachedWaypoint] = field(default_factory=list)
    landings: list[Floats] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    delay: float = 0.0
    end: End = "loiter"

    def __post_init__(self) -> None:
        self.autopilot, self.speed = self.told.autopilot, self.told.speed
        self.here, self.flies = self.home.copy(), False
        self.lift = lift_over_ground(self.waypoints, self.scenario, float(self.home[2]))

    def run(self) -> None:
        """Follow all orders, to the first that ends the flight."""
        orders, jumped, at = self.waypoints.orders, Counter[int](), 0
        since: dict[int, int] = {}
        last_of = max((k for k, one in enumerate(orders) if one.kind in _MOVES), default=-1)
        place_of = {order.number: k for k, order in enumerate(orders)}
        steps = 0
        while at < len(orders):
            order = orders[at]
            at, steps = at + 1, steps + 1
            if order.kind is OrderKind.JUMP:
                times = 1 if order.times < 0 else order.times  # a round for ever is proven once
                if order.times < 0:
                    self.assumed.append(f"jump {order.number} never ends: what follows one round of it is judged")
                if order.times < 0 and since.get(order.number) == len(self.visits):
                    raise self._refused(order, "expected a place between a jump for ever and its target, found none")
                since[order.number] = len(self.visits)
                if jumped[order.number] < times:
                    jumped[order.number] += 1
                    at = place_of[order.to]  # type: ignore[index]
            elif self._follow(order, last=at > last_of):
                return
            if len(self.visits) > MAX_VISITS or steps > MAX_STEPS:
                most = f"expected at most {MAX_VISITS:,} places and {MAX_STEPS:,} orders, each round of jumps counted"
                raise self._refused(order, f"{most}, found more")

    def _refused(self, order: Order, said: str, field: str | None = None) -> InputError:
        return InputError(f"{self.waypoints.name}: item {order.number}: {said}", field=field)

    def _follow(self, order: Order, *, last: bool) -> bool:
        """Follow one order, and tell whether it ends the flight."""
        if order.kind is OrderKind.RETURN:
            self.end = "rtl"
            return True
        if order.speed is not None and order.kind is OrderKind.SPEED:
            self.speed = order.speed
        if order.kind is OrderKind.DELAY and not self.visits:
            self.delay += order.seconds
        elif order.kind is OrderKind.DELAY:
            self.visits[-1] = self.visits[-1]._replace(hold=self.visits[-1].hold + order.seconds, radius=0.0)
        if order.kind is OrderKind.TAKEOFF:
            self._take_off(order)
        elif order.kind is OrderKind.LAND:
            self._land(order, last=last)
            return last
        elif order.kind in (OrderKind.WAYPOINT, OrderKind.LOITER) and order.place is not None:
            self._fly_to(order)
            if order.speed is not None:
                self.speed = order.speed
            return math.isinf(order.seconds)
        return False

    def _take_off(self, order: Order) -> None:
        if order.place is None:
            raise self._refused(order, "expected an altitude to take off to")
        top = self._local(order, (math.nan, math.nan, order.place[2]))
        self._visit(order, top, self.told.altitude_radius)
        self.flies = True
        aim = self._local(order, order.place)
        if self.autopilot.name == "px4" and math.dist(aim[:2], top[:2]) > SAME_PLACE:  # it then flies to that place
            self._visit(order, np.array([*aim[:2], top[2]]), self._radius(order))

    def _fly_to(self, order: Order) -> None:
        assert order.place is not None
        to = self._local(order, order.place)
        if not self.flies:
            self.assumed.append("it has no take-off: it is taken to rise above home to the height of its first place")
            self._visit(order, np.array([*self.here[:2], to[2]]))
            self.flies = True
        if len(self.visits) == 1 and self.visits[0].order.name == DJI_SAFELY:
            level = max(float(self.here[2]), float(to[2]))
            self.here = np.array([*self.here[:2], level])
            self.visits[0] = self.visits[0]._replace(at=self.here)
            if level > to[2]:
                self._visit(order, np.array([*to[:2], level]))
        if math.isinf(order.seconds) and len(self.visits) > 1 and math.dist(to, self.here) <= SAME_PLACE:
            self.visits[-1] = self.visits[-1]._replace(radius=0.0)  # where it stays
            return
        follows = isinstance(order.place[2], AboveGround) and self.waypoints.ground_followed
        for place in self._circle(order, to) if order.turns else [to]:
            parts, aside = self._over_ground(order, place, to) if follows else ([place], 0.0)
            for part in parts:
                cut = part is parts[-1] and not (order.seconds or order.turns)
                self._visit(order, part, self._radius(order) if cut else 0.0, follows=follows, aside=aside)
        if math.isfinite(order.seconds):
            self.visits[-1] = self.visits[-1]._replace(hold=min(order.seconds, 1e6))

    def _over_ground(self, order: Order, place: Floats, like: Floats) -> tuple[list[Floats], float]:
        """Return the ends of parts of the way to a place that is as high above ground as `like`, nearly straight each.

        With them comes how far the vehicle may be beside them, as it has cut the corner before, metres.
        """
        terrain, begin, before = self.scenario.terrain, self.here, self.visits[-1]
        assert terrain is not None
        aside = before.aside if before.order is order else 0.0 if before.hold else before.radius
        first, last = (float(one[2]) - float(terrain.height(one[:2])) for one in (begin, like))

        def at(share: float) -> Floats:
            x, y = (begin + share * (place - begin))[:2].tolist()
            return np.array([x, y, float(terrain.height([x, y])) + first + share * (last - first)])

        def parts(low: float, high: float) -> Iterator[Floats]:
            pair = np.stack([at(low), at(high)])
            if math.dist(*pair[:, :2]) <= LEAST_PART or ground_under(terrain, pair, 0.0).bend <= MAX_BEND:
                yield pair[1]
            else:
                yield from parts(low, (low + high) / 2)
                yield from parts((low + high) / 2, high)

        return [*parts(0.0, 1.0)], aside

    def _land(self, order: Order, *, last: bool) -> None:
        over = self._local(order, order.place) if order.place is not None else self.here
        self._visit(order, np.array([*over[:2], self.here[2]]), hold=STOP)
        if last:
            self.end = "land"
            return
        ground = np.array([*over[:2], float(ground_height(self.scenario, over[:2]))])
        self.landings.append(ground)
        self._visit(order, base_over(self.scenario, ground), hold=STOP)
        self.flies = False

    def _visit(self, order: Order, at: Floats, radius: float = 0.0, hold: float = 0.0, **over_ground: Any) -> None:
        if len(self.visits) > 1 and math.dist(at, self.here) <= SAME_PLACE:  # which is no corner
            self.visits[-1] = self.visits[-1]._replace(radius=0.0)
        self.visits.append(ReachedWaypoint(order, at, radius, hold, self.speed, **over_ground))
        self.here = at

    def _radius(self, order: Order) -> float:
        """Return the radius of a waypoint, metres; Copter does not keep that of a waypoint, but has one for all."""
        own = order.radius if order.kind is OrderKind.WAYPOINT and self.autopilot.name != "ardupilot" else None
        return math.hypot(self.told.radius if own is None else own, self.told.altitude_radius)

    def _circle(self, order: Order, middle: Floats) -> Iterator[Floats]:
        """Yield the corners of a polygon that is nowhere far from the circle of a loiter, nor from all its turns."""
        radius = USUAL_CIRCLE if order.radius is None else order.radius
        count = max(math.ceil(math.pi / math.sqrt(2 * OFF_CIRCLE / max(radius, OFF_CIRCLE))), 8)
        begin = math.atan2(*(self.here - middle)[1::-1])
        for angle in begin + np.linspace(0.0, 2 * math.pi, count + 1):
            yield middle + (radius + OFF_CIRCLE / 2) * np.array([math.cos(angle), math.sin(angle), 0.0])
        yield middle

    def _local(self, order: Order, place: GlobalPlace) -> Floats:
        """Return a place in local metres; where its latitude and longitude are left open, it is above here."""
        latitude, longitude, altitude = place
        origin = self.scenario.frame.origin
        assert origin is not None
        stays = math.isnan(latitude) or math.isnan(longitude)
        if latitude == 0 and longitude == 0:
            if self.autopilot.name != "ardupilot" and order.kind is OrderKind.WAYPOINT:
                raise self._refused(order, f"latitude and longitude are 0, where {self.autopilot.title} would fly to")
            stays = True
        x, y = self.here[:2] if stays else to_local(origin, [[latitude, longitude, 0.0]])[0, :2]
        if self.autopilot.name == "ardupilot" and altitude.metres == 0 and self.flies:  # Copter stays as high as it is
            z = float(self.here[2])
        elif isinstance(altitude, AboveHome):
            z = self.home[2] + altitude.metres
        elif isinstance(altitude, AboveGround):
            if self.scenario.terrain is None:
                raise self._refused(order, "a height above ground needs the ground", "terrain")
            z = float(self.scenario.terrain.height([x, y])) + self.lift + altitude.metres
        else:
            z = altitude.metres - origin.altitude
        return np.array([x, y, z])


def lift_over_ground(waypoints: Waypoints, scenario: Scenario, home: float) -> float:
    """Return how much higher all is flown than the heights above ground that a mission has, metres.

    Where they do not follow the ground, the autopilot takes home, `home` metres high, for as high as the ground below
    the first waypoint.
    """
    first = next((one.place for one in waypoints.orders if one.place and one.kind is OrderKind.WAYPOINT), None)
    if waypoints.ground_followed or scenario.terrain is None or scenario.frame.origin is None or first is None:
        return 0.0
    below = to_local(scenario.frame.origin, [[*first[:2], 0.0]])[0, :2]
    return home - float(scenario.terrain.height(below))


def base_over(scenario: Scenario, place: Floats) -> Floats:
    """Return where a UAV is free over a place where it stands, (3,) metres."""
    terrain = scenario.terrain
    ground = float(place[2]) if terrain is None else max(float(ground_height(scenario, place[:2])), float(place[2]))
    kept = max(scenario.clearance, scenario.ground_clearance if terrain is not None else 0.0)
    return np.array([*place[:2], ground + kept + 2 * LEG_ALLOWANCE])
