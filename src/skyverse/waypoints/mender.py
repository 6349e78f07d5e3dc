"""One mission mended once: places moved least, legs led over or around, corners cut less, home's altitude stated."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.leg_geometry import towards
from skyverse.exports.leg_space import grown
from skyverse.exports.way_home_space import strayed
from skyverse.model.altitude import AboveGround, AboveHome, GlobalPlace
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.space.world import World
from skyverse.waypoints.check import CheckedMission
from skyverse.waypoints.findings import FindingKind, MissionFinding, Subject
from skyverse.waypoints.safe_places import LEAST_SLACK, SPARE, above, below, beside, length_of, way_around, way_over
from skyverse.waypoints.unrolled import lift_over_ground
from skyverse.waypoints.way_back import SMART_ACCURACY

MOST_CUT = 3.0
"""Metres of cut corners that are counted where there shall be room for a return."""
LITTLE = 2.0
"""Metres by which a corner is moved rather than stopped at."""
FOR_RETURNS = 1.02
"""By which factor a way may be longer so that the vehicle can return from all of it."""


def renumbered(orders: Sequence[Order]) -> tuple[Order, ...]:
    """Return orders with the numbers that they have after some were added, and jumps to where they led."""
    first = next((order.number for order in orders if order.item is not None), 1)
    numbers = {order.number: k for k, order in enumerate(orders, first) if order.item is not None}
    if len(numbers) < sum(order.item is not None for order in orders):  # what is done at a waypoint has its number
        counts = accumulate(int(order.kind is OrderKind.WAYPOINT) for order in orders)
        return tuple(replace(order, number=count) for order, count in zip(orders, counts, strict=True))
    return tuple(
        replace(order, number=k, to=order.to if order.to is None else numbers[order.to])
        for k, order in enumerate(orders, first)
    )


class Mender:
    """Mends one mission once, by what was found of it."""

    def __init__(self, mission: CheckedMission, *, lift_only: bool) -> None:
        self.mission, self.lift_only, self.scenario = mission, lift_only, mission.scenario
        self.flown, self.waypoints = mission.flown, mission.flown.waypoints
        self.uav = self.flown.plan.route.uav
        error = self.scenario.uavs[self.uav].tracking_error
        self.places = [visit.at.copy() for visit in self.flown.visits]
        self.radius = max((visit.radius for visit in self.flown.visits), default=0.0)
        # a return can begin where it may stray twice its error, as far from a corner as that is cut
        aside = max(min(self.radius + 5 * SPARE, MOST_CUT), SMART_ACCURACY)
        self.needs_room = self.flown.retraces and self.flown.plan.autopilot.name == "ardupilot"
        upright = SMART_ACCURACY if self.needs_room else 0.0
        wider = strayed(error, error.horizontal + aside, error.vertical + upright)
        self.world, self.wide = (World(grown(self.scenario, SPARE), one) for one in (error, wider))
        # where a place is moved to the side, ways around what is beside it begin
        self.aside = [World(grown(self.scenario, 3 * SPARE + LEAST_SLACK), one) for one in (wider, error)]
        self.added: dict[int, Floats] = {}
        self.orders = {id(order): order for order in self.waypoints.orders}

    def mended(self) -> Waypoints:
        """Return the mission with what helps changed; it is the same where nothing does."""
        legs: dict[tuple[int, int], MissionFinding] = {}
        corners: list[tuple[int, MissionFinding]] = []
        for found in self.mission.findings:
            if not found.wrong or found.part is None:
                continue
            if found.corner:
                corners.append((found.part, found))
            else:
                legs.setdefault(self.flown.ends(found.part), found)
        moved = {k for leg in legs for k in leg if k >= 0 and self._move(k)}
        for leg, found in legs.items():
            if not moved.intersection(leg):
                self._lead(leg, found)
        for k, found in corners:
            if k not in moved:
                self._cut_less(k, found)
        return self._rebuilt()

    def with_room_for_climbs(self) -> Waypoints:
        """Return the mission with places moved where nothing is wrong but that a return cannot begin there.

        What is beside such a place is as high.
        """
        wrong = [one for one in self.mission.findings if one.wrong]
        if all(one.kind is FindingKind.CLIMB for one in wrong):
            at = {number for one in wrong for number in one.items}
            for k in [k for k, visit in enumerate(self.flown.visits) if visit.order.number in at]:
                if not self._move(k, climbs=True):
                    self._rise(k, max(self.world.error.vertical, 1.0))
        return self._rebuilt()

    def _is_movable(self, k: int) -> bool:
        """Tell whether a visit is where its order says, and not a part of a climb or circle."""
        order = self.flown.visits[k].order
        apart = [np.abs(self.flown.visits[j].at - self.flown.visits[k].at).max() for j in self._same(k)]
        alone = order.kind is OrderKind.TAKEOFF or max(apart, default=math.inf) <= SAME_PLACE
        return order.place is not None and alone

    def _same(self, k: int) -> list[int]:
        """Return the visits that the order of one asks for: more than one where jumps lead there again.

        What the vehicle visits on the way there is not asked for: a climb from home, or parts of a leg over the ground.
        """
        visits, order = self.flown.visits, self.flown.visits[k].order
        straight = order.kind in (OrderKind.WAYPOINT, OrderKind.LOITER) and not order.turns
        ends = [not straight or one.order is not after.order for one, after in pairwise(visits)]
        return [j for j, one in enumerate(visits) if one.order is order and (j == len(ends) or ends[j])]

    def _place(self, k: int, to: Floats) -> None:
        """Put a place of the flight elsewhere, also where it is visited again."""
        for j in [k] if self.flown.visits[k].order.kind is OrderKind.TAKEOFF else self._same(k):
            self.places[j] = to

    def _move(self, k: int, *, climbs: bool = False) -> bool:
        """Move a place that is not safe, or not for climbs, to the nearest one that is, and tell whether it was."""
        place, tried = self.places[k], 1 if climbs or self.needs_room else 2
        world = self.wide if tried == 1 else self.world
        if world.free(place)[0] or not self._is_movable(k):
            return False
        upright = [_first(above, [self.wide, self.world][:tried], place), below(world, place)]
        # what it is over is why it is there
        buried = place[2] < world.least_height(place) and any(one is not None for one in upright)
        stays = self.lift_only or buried or self.flown.visits[k].order.kind is OrderKind.TAKEOFF
        found = [*upright, None if stays else _first(beside, self.aside[:tried], place)]
        nearest = min((one for one in found if one is not None), key=lambda one: math.dist(one, place), default=None)
        if nearest is not None:
            self._place(k, nearest)
        return nearest is not None

    def _lead(self, leg: tuple[int, int], found: MissionFinding) -> None:
        """Lead a leg over or around what it meets, or lift or lower its ends."""
        if found.kind is FindingKind.CEILING and leg[0] >= 0 and self._lower(leg, found):
            return
        follows = self.flown.visits[leg[1]].follows
        if self.lift_only or not self._can_add(leg) or (found.kind is FindingKind.GROUND and follows):
            for k in leg:
                self._lift(k, found)
            return
        way = self._way(leg)
        if way is not None:
            self.added[leg[1]] = way[1:-1]

    def _lower(self, leg: tuple[int, int], found: MissionFinding) -> bool:
        """Lower both ends of a leg below the ceiling where that is clear, and tell whether that is all to be done."""
        down = np.array([0.0, 0.0, (found.deep or 1.0) + SPARE])
        a, b = (self.places[k] for k in leg)
        clear = bool(self.world.segments_free(a - down, b - down)[0]) and all(map(self._is_movable, leg))
        if not (clear or self.lift_only or self.flown.visits[leg[1]].follows):
            return False
        for k in leg:
            if self.places[k][2] >= self.flown.visits[k].at[2]:
                self._place(k, self.places[k] - down)
        return True

    def _away(self, k: int, found: MissionFinding) -> float:
        """Return how many metres a place is away from where something was found."""
        assert self.scenario.frame.origin is not None
        assert found.place is not None
        return math.dist(self.places[k], to_local(self.scenario.frame.origin, [found.place])[0])

    def _lift(self, k: int, found: MissionFinding) -> None:
        """Raise a place to where what was found is clear."""
        rise = 0.0 if found.clear_at is None or found.place is None else found.clear_at - found.place[2]
        if rise > 0:
            self._rise(k, rise)

    def _rise(self, k: int, metres: float) -> None:
        """Raise a place, unless it was raised already."""
        if k >= 0 and self._is_movable(k) and self.places[k][2] <= self.flown.visits[k].at[2]:
            self._place(k, self.places[k] + np.array([0.0, 0.0, metres + SPARE]))

    def _can_add(self, leg: tuple[int, int]) -> bool:
        """Tell whether a waypoint may be added on a leg: one that no climb from the ground, jump or circle makes."""
        if leg[0] < 0:
            return False
        before, after = (self.flown.visits[k].order for k in leg)
        orders = self.waypoints.orders
        first, last = orders.index(before), orders.index(after)
        return first < last and not any(one.kind is OrderKind.JUMP for one in orders[first:last])

    def _way(self, leg: tuple[int, int]) -> Floats | None:
        """Return the shortest way along which a leg is led, (n, 3) metres; one hardly longer with room for returns."""
        ends, radius = np.stack([self.places[k] for k in leg]), self._radius(leg[1])
        follows, shortest = self.flown.visits[leg[1]].follows, math.dist(*ends)

        def way(world: World) -> Floats | None:
            over = None if follows else way_over(self.scenario, world, ends, radius)
            if over is not None and safe(over) and length_of(over) <= FOR_RETURNS * shortest:
                return over
            around = way_around(self.scenario, self.uav, world.error, ends, self.radius)
            return min((one for one in (over, around) if one is not None and safe(one)), key=length_of, default=None)

        def safe(way: Floats) -> bool:
            return bool(self.world.segments_free(way[:-1], way[1:]).all())

        wide = way(self.wide)
        if self.needs_room or (wide is not None and length_of(wide) <= FOR_RETURNS * shortest):
            return wide
        narrow = way(self.world)
        if wide is None or (narrow is not None and length_of(wide) > FOR_RETURNS * length_of(narrow)):
            return narrow
        return wide

    def _cut_less(self, k: int, found: MissionFinding) -> None:
        """Raise a corner where little is missing, halve its radius, move it outwards, or stop; a take-off is raised."""
        order, radius, deep = self.flown.visits[k].order, self.flown.visits[k].radius, found.deep or 0.0
        little = 0 < deep <= LITTLE and self._is_movable(k)
        if self.lift_only or (little and (found.kind is FindingKind.GROUND or k == 0)):
            movable = filter(self._is_movable, (k, k + 1))  # the way on from a corner may be too low near its end
            for j in sorted(movable, key=lambda j: self._away(j, found))[:1]:
                self._lift(j, found)
        elif self.flown.plan.autopilot.name != "ardupilot" and radius > 1.0:
            self.orders[id(order)] = replace(order, radius=max(math.floor(5 * radius) / 10, 0.5))
        elif little and self._move_outwards(k, 2 * deep + SPARE):  # the corner that is cut moves about half as far
            pass
        elif order.kind is OrderKind.WAYPOINT and order.seconds == 0:
            self.orders[id(order)] = replace(order, seconds=1.0)

    def _move_outwards(self, k: int, metres: float) -> bool:
        """Move a corner away from where its legs come from and lead to if it is clear then, and tell whether it is."""
        before, at, after = self.places[k - 1 : k + 2]
        outwards = at - (before + after) / 2
        to = at + metres / max(math.hypot(*outwards), SPARE) * outwards
        turns = to + towards(before - to, self.flown.visits[k].radius)
        clear = bool(self.world.segments_free([before, to, turns], [to, after, after]).all())
        if clear:
            self._place(k, to)
        return clear

    def _rebuilt(self) -> Waypoints:
        """Return the mission with its orders at their places now, and home at the ground's altitude."""
        visits, made = self.flown.visits, list[Order]()
        moved = {id(one.order): k for k, one in enumerate(visits) if np.abs(self.places[k] - one.at).max() > SAME_PLACE}
        before = {id(visits[leg].order): leg for leg in self.added}
        for order in self.waypoints.orders:
            own, leg, k = self.orders[id(order)], before.get(id(order)), moved.get(id(order))
            if leg is not None:
                high = order.place is not None and order.kind is not OrderKind.LAND
                like = order if high else visits[leg - 1].order
                made += [self._new(place, like, leg) for place in self.added[leg]]
            if k is not None:
                aside = np.abs(self.places[k] - visits[k].at)[:2].max()
                place = self._globe(self.places[k], order)
                if aside <= SAME_PLACE and order.place is not None:
                    place = (*order.place[:2], place[2])
                own = replace(own, place=place)
            made.append(own)
        home, off = self.waypoints.home, self.mission.of(Subject.HOME)
        if home is not None and off and off[0].place is not None and not self.lift_only:
            home = (*home[:2], round(off[0].place[2], 2))
        return replace(self.waypoints, orders=renumbered(made) if self.added else tuple(made), home=home)

    def _new(self, place: Floats, like: Order, leg: int) -> Order:
        """Return a waypoint that is passed, its altitude counted as that of an order."""
        own = None if self.flown.plan.autopilot.name == "ardupilot" else round(self._radius(leg), 2)
        return Order(0, OrderKind.WAYPOINT, "NAV_WAYPOINT", place=self._globe(place, like), radius=own)

    def _radius(self, leg: int) -> float:
        """Return the radius of waypoints that are added on a leg: that of the narrower of its corners."""
        around = (self.flown.visits[k].radius for k in (leg - 1, leg))
        return min((one for one in around if one), default=FlightSettings.radius)

    def _globe(self, place: Floats, like: Order) -> GlobalPlace:
        """Return a place in degrees, its altitude counted as that of an order, rounded up as files round."""
        assert self.scenario.frame.origin is not None
        assert like.place is not None
        ((latitude, longitude, metres),) = to_wgs84(self.scenario.frame.origin, place[None]).tolist()
        kind = type(like.place[2])
        if kind is AboveHome:
            metres = float(place[2] - self.flown.plan.home[2])
        elif kind is AboveGround and self.scenario.terrain is not None:
            lift = lift_over_ground(self.waypoints, self.scenario, float(self.flown.plan.home[2]))
            metres = float(place[2] - lift - self.scenario.terrain.height(place[:2]))
        return round(latitude, 7), round(longitude, 7), kind(round(metres + 0.004, 2))


def _first(way: Callable[[World, Floats], Floats | None], worlds: Sequence[World], place: Floats) -> Floats | None:
    """Return what is found near a place in the first of some worlds in which anything is."""
    return next((one for one in (way(world, place) for world in worlds) if one is not None), None)
