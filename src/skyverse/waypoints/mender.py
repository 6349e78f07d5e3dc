"""One mission mended once: places moved least, legs led over or around, corners cut less, home's altitude stated."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from typing import Any, TypeVar

import numpy as np

from skyverse._typing import Floats
from skyverse.exports.leg_space import grown
from skyverse.model.altitude import AboveGround, AboveHome, GlobalPlace
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.quantities import derived
from skyverse.model.scenario import Bounds, Lattice, Target
from skyverse.model.short_lines import counted, told_metres
from skyverse.model.uav import TrackingError
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.numerics.tolerances import SAME_PLACE
from skyverse.planners.auto import Auto
from skyverse.problem import Problem
from skyverse.space.world import World
from skyverse.waypoints.check import CheckedMission
from skyverse.waypoints.findings import FindingKind, MissionFinding, Subject
from skyverse.waypoints.taut_line import taut_line, with_fewer_bends
from skyverse.waypoints.unrolled import lift_over_ground

SPARE = 0.1
"""Metres that are kept beyond what is required, as files round."""
SAMPLE = 1.0
"""Metres between the places of a leg at which it is asked how high is safe; more of them on long legs are sparser."""
MAX_SAMPLES = 1500
LONGER = 0.005
"""The share by which a leg may be longer over the ground so that it has fewer bends."""
CUT = 0.15
"""Metres that a bend of some 17 degrees is cut lower for each metre of its radius."""
DIRECTIONS = 72
MOVED = "moved"
FARTHEST = 500.0
"""Metres by which a place is moved to the side at most."""
AROUND = 150.0
"""Metres about a leg in which a way around is sought at least."""
MOST_CUT = 3.0
"""Metres of cut corners that are counted where there shall be room for a return."""
SLACK = 1.0
"""Metres that ways around are sought farther off than they must be, so that they can have fewer bends."""
T = TypeVar("T")


@dataclass(frozen=True)
class Change:
    """One thing that was changed: the numbers of the orders as the file had them, and in words from what to what."""

    items: tuple[int, ...]
    said: str


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

    def __init__(self, mission: CheckedMission, former: Mapping[int, int], *, lift_only: bool) -> None:
        self.mission, self.lift_only = mission, lift_only
        self.scenario = scenario = mission.scenario
        self.flown, self.waypoints = mission.flown, mission.flown.waypoints
        self.error = scenario.uavs[self.flown.plan.route.uav].tracking_error
        self.places = [visit.at.copy() for visit in self.flown.visits]
        self.world = World(grown(scenario, SPARE), self.error)
        # a return can begin where it may stray twice its error, as far from a corner as that is cut
        cut = max((visit.radius for visit in self.flown.visits), default=0.0) + 5 * SPARE
        error = TrackingError(
            horizontal=2 * self.error.horizontal + min(cut, MOST_CUT), vertical=2 * self.error.vertical
        )
        self.wide = World(grown(scenario, SPARE), error)
        self.added: dict[int, list[Floats]] = {}
        self.orders = {id(order): order for order in self.waypoints.orders}
        self.told: list[Change] = []
        self.former = former

    def run(self) -> bool:
        """Change what helps, and tell whether something did; the mission is then `waypoints`."""
        wrong = [one for one in self.mission.findings if one.wrong and one.part is not None]
        legs: dict[tuple[int, int], MissionFinding] = {}
        for one in wrong:
            if one.subject is not Subject.CORNERS and one.part is not None:
                legs.setdefault(self.flown.ends(one.part), one)
        moved = {k for leg in legs for k in leg if k >= 0 and self._move(k, self.world)}
        for leg, found in legs.items():
            if leg[0] >= 0 and not set(leg) & moved:
                self._lead(leg, found)
            elif leg[0] < 0 and not moved:
                self._raise(0)
        for one in wrong:
            if one.subject is Subject.CORNERS and one.part is not None and one.part not in moved:
                if self.lift_only:
                    self._lift(one.part, _too_low(one))
                else:
                    self._cut_less(one.part)
        flies_well = all(one.subject in (Subject.WAY_HOME, Subject.END) for one in self.mission.findings if one.wrong)
        for one in self.mission.findings:
            if one.kind is FindingKind.CLIMB and flies_well:  # a return cannot begin where what is beside is as high
                for k, visit in enumerate(self.flown.visits):
                    if visit.order.number in one.items and not self._move(k, self.wide):
                        self._lift(k, max(self.error.vertical, 1.0))
        self._mend_home()
        if self.told:
            self._rebuild()
        return bool(self.told)

    def _tell(self, said: str, *orders: Order) -> None:
        """Tell of a change by the numbers that orders had in their file; of those that were added nothing is told."""
        items = [self.former[order.item] for order in orders if order.item is not None]
        self.told.append(Change(tuple(dict.fromkeys(items)) if len(items) == len(orders) else (), said))

    def _moves_alone(self, k: int) -> bool:
        """Tell whether a visit is where its order says, and not a part of a climb or circle."""
        order = self.flown.visits[k].order
        apart = [np.abs(self.flown.visits[j].at - self.flown.visits[k].at).max() for j in self._same(k)]
        return order.place is not None and not self.flown.is_part(k) and max(apart) <= SAME_PLACE

    def _same(self, k: int) -> list[int]:
        """Return the visits that the order of one asks for: more than one where jumps lead there again."""
        visits, order = self.flown.visits, self.flown.visits[k].order
        return [j for j, one in enumerate(visits) if one.order is order and not self.flown.is_part(j)]

    def _place(self, k: int, to: Floats) -> None:
        """Put a place of the flight elsewhere, also where it is visited again, and tell it."""
        beside = (one for one in self.mission.findings if one.part in (k, k + 1))
        met = next((one.what for one in beside if one.deep is not None), "")
        self._tell(f"{MOVED}, off the {met}" if met else MOVED, self.flown.visits[k].order)
        for j in self._same(k) if self._moves_alone(k) else [k]:
            self.places[j] = to

    def _move(self, k: int, world: World) -> bool:
        """Move a place that is not safe in a world to the nearest one that is, and tell whether it was."""
        place, order = self.places[k], self.flown.visits[k].order
        if world.free(place)[0] or not (self._moves_alone(k) or order.kind is OrderKind.TAKEOFF):
            return False
        upwards = next((one for one in self._both(self._above, place) if one is not None), None)
        found = [one for one in (upwards, self._below(place)) if one is not None]
        upright = place[2] < self.world.least_height(place) and bool(found)  # what it is over is why it is there
        if not (self.lift_only or upright) and order.kind is not OrderKind.TAKEOFF:
            found += next((some for some in self._both(self._beside, place) if some), [])
        if not found:
            return False
        nearest = min(found, key=lambda one: math.dist(one, place))
        self._place(k, nearest)
        return True

    def _both(self, way: Callable[[World, Any], T], given: Any) -> Iterator[T]:
        """Yield what is found with room for a return, and what is found without."""
        yield way(self.wide, given)
        yield way(self.world, given)

    @staticmethod
    def _above(world: World, place: Floats) -> Floats | None:
        """Return the lowest safe place above one, or ``None``."""
        found = place.copy()
        for _ in range(100):
            above = world.way_out_above(found)
            if above is None:
                return None
            found[2] = max(above, found[2]) + SPARE
            if world.free(found)[0]:
                return found
        return None

    def _below(self, place: Floats) -> Floats | None:
        """Return a safe place not far below one that is too high, or ``None``."""
        low = place.copy()
        low[2] = max(self.world.least_height(place), float(self.world.space.low[2])) + SPARE
        if low[2] >= place[2] or not self.world.free(low)[0]:
            return None
        high = place.copy()
        while high[2] - low[2] > SPARE:
            middle = (low + high) / 2
            low, high = (middle, high) if self.world.free(middle)[0] else (low, middle)
        return low

    @staticmethod
    def _beside(world: World, place: Floats) -> list[Floats]:
        """Return the nearest safe place at the same height, if there is one."""
        angles = np.linspace(0.0, 2 * math.pi, DIRECTIONS, endpoint=False)
        around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(DIRECTIONS)])
        away, before = 0.5, 0.0
        while away <= FARTHEST:
            free = np.flatnonzero(world.free(place + away * around))
            if len(free):
                near, far = before, away
                while far - near > SPARE:
                    middle = (near + far) / 2
                    some = np.flatnonzero(world.free(place + middle * around))
                    near, far, free = (near, middle, some) if len(some) else (middle, far, free)
                return [place + far * around[free[0]]]
            before, away = away, away * 1.3
        return []

    def _raise(self, k: int) -> None:
        """Raise the end of the take-off as far as its climb, and what is around it, ask for."""
        order = self.flown.visits[k].order
        of_climb = (one for one in self.mission.findings if one.part == 0 and one.clear_at is not None)
        found = next(of_climb, None)
        if order.kind is OrderKind.TAKEOFF and found is not None:
            self._place(k, self.places[k] + np.array([0.0, 0.0, (found.deep or 0.0) + SPARE]))

    def _lead(self, leg: tuple[int, int], found: MissionFinding) -> None:
        """Lead a leg over or around what it meets, or lift its ends."""
        a, b = (self.places[k] for k in leg)
        follows, can_add = self.flown.visits[leg[1]].follows, self._can_add(leg)
        if found.kind is FindingKind.CEILING:
            down = np.array([0.0, 0.0, (found.deep or 1.0) + SPARE])
            clear = self.world.segments_free(a - down, b - down)[0]
            if follows or self.lift_only or (clear and all(map(self._moves_alone, leg))):
                for k in leg:
                    if self.places[k][2] >= self.flown.visits[k].at[2]:
                        self._place(k, self.places[k] - down)
                return
        if self.lift_only or (found.kind is FindingKind.GROUND and (follows or not can_add)):
            for k in leg:
                self._lift(k, _too_low(found))
            return
        if not can_add:
            return
        over = None if follows else next((way for way in self._both(self._over, leg) if way is not None), None)
        ways = [way for way in (over, self._around(a, b)) if way is not None]
        if not ways:
            return
        best = min(ways, key=_length)
        if len(best) == 2:
            return
        self.added[leg[1]] = list(best[1:-1])
        (x, y), aside = (b - a)[:2], (best - a)[:, :2]
        kind = "over" if np.abs(aside[:, 0] * y - aside[:, 1] * x).max() <= SAME_PLACE * math.hypot(x, y) else "around"
        count = counted(len(best) - 2, "more waypoint")
        more = max(_length(best) - math.dist(a, b), 0.0)
        self._tell(f"led {kind} by {count}, {told_metres(more)} longer", *(self.flown.visits[k].order for k in leg))

    def _can_add(self, leg: tuple[int, int]) -> bool:
        """Tell whether a waypoint may be added on a leg: one that jumps or circles do not make."""
        before, after = (self.flown.visits[k].order for k in leg)
        orders = self.waypoints.orders
        between = orders[orders.index(before) + 1 : orders.index(after)]
        return (
            before is not after
            and before.number < after.number
            and not any(one.kind is OrderKind.JUMP for one in between)
        )

    def _lift(self, k: int, metres: float) -> None:
        """Raise a place by so many metres that it is too low, unless that was done."""
        if metres > 0 and self.places[k][2] <= self.flown.visits[k].at[2] and self._moves_alone(k):
            self._place(k, self.places[k] + np.array([0.0, 0.0, metres + SPARE]))

    def _over(self, world: World, leg: tuple[int, int]) -> Floats | None:
        """Return the shortest safe way from end to end of a leg, (n, 3) metres, that is straight as seen from above."""
        a, b = (self.places[k] for k in leg)
        length = float(math.dist(a[:2], b[:2]))
        count = min(max(math.ceil(length / SAMPLE), 2), MAX_SAMPLES)
        shares = np.linspace(0.0, 1.0, count + 1)
        places = a + shares[:, None] * (b - a)
        low, high = np.empty(count + 1), np.full(count + 1, float(self.world.space.high[2]))
        for k, place in enumerate(places):
            least = place.copy()
            least[2] = max(world.least_height(place), float(world.space.low[2]))
            above = least if world.free(least)[0] else self._above(world, least)
            if above is None:
                return None
            low[k] = above[2]
        if self.scenario.max_height is not None and self.scenario.terrain is not None:
            ceiling = self.scenario.terrain.lowest_ground.height(places[:, :2]) + self.scenario.max_height
            high = np.minimum(high, ceiling - self.error.vertical - 2 * SPARE)
        radius = min(self.flown.visits[k].radius for k in leg)
        low[1:-1] += SPARE + CUT * radius  # between two places the ground may be higher, and corners are cut
        low[0], low[-1] = min(low[0], a[2]), min(low[-1], b[2])
        high[0], high[-1] = max(high[0], a[2]), max(high[-1], b[2])
        if (low > high).any():
            return None
        along = shares * length
        taut = taut_line(along, low, high, float(a[2]), float(b[2]))
        bends = with_fewer_bends(taut, along, high, LONGER * math.dist(a, b))
        way = np.array([[*(a + s / max(length, 1e-9) * (b - a))[:2], z] for s, z in bends])
        way[0], way[-1] = a, b
        return way

    def _around(self, a: Floats, b: Floats) -> Floats | None:
        """Return the way from a to b, (n, 3) metres, that the planners find, with room for corners to be cut."""
        wide = max(AROUND, math.dist(a, b) / 2)
        low, high = np.minimum(a, b) - wide, np.maximum(a, b) + wide
        bounds = self.scenario.bounds
        low, high = np.maximum(low, bounds.min), np.minimum(high, bounds.max)
        low[2], high[2] = bounds.min[2], bounds.max[2]
        radius = max((visit.radius for visit in self.flown.visits), default=0.0)
        step = float(max((high - low)[:2])) / 60
        vehicle = self.scenario.uavs[self.flown.plan.route.uav]
        rooms = [(self.wide.error, radius), *((self.error, share * radius) for share in (1.0, 0.5, 0.0))]
        for error, room in rooms:
            inside = derived(
                grown(self.scenario, room + 2 * SPARE + SLACK),
                bounds=Bounds(min=tuple(low.tolist()), max=tuple(high.tolist())),
                uavs=(derived(vehicle, start=tuple(a.tolist()), home=None, tracking_error=error),),
                targets=(Target(name="end", position=tuple(b.tolist())),),
                lattice=Lattice(step=(step, step, max(min(step, (high - low)[2] / 4), 1.0))),
            )
            problem = Problem(inside)
            result = Auto().plan(problem)
            if result.status.reached and len(result.path) >= 2:
                way = np.asarray(result.path, dtype=np.float64).copy()
                way[0], way[-1] = a, b
                return _straightened(World(grown(self.scenario, room + 2 * SPARE), error), way)
        return None

    def _cut_less(self, k: int) -> None:
        """Halve the radius of a corner, or stop there where the file cannot name a radius."""
        order = self.flown.visits[k].order
        if order.kind is not OrderKind.WAYPOINT:
            return
        radius = self.flown.visits[k].radius
        if self.flown.plan.autopilot.name != "ardupilot" and radius > 1.0:
            small = max(math.floor(5 * radius) / 10, 0.5)
            self.orders[id(order)] = replace(self.orders[id(order)], radius=small)
            self._tell(f"acceptance radius of {small:g} m in place of {radius:.3g} m", order)
        elif order.seconds == 0:
            self.orders[id(order)] = replace(self.orders[id(order)], seconds=1.0)
            self._tell("stops for 1 s, so that it cuts no corner", order)

    def _mend_home(self) -> None:
        """State the altitude of the ground at home where the file has another."""
        wrong = next((one for one in self.mission.findings if one.subject is Subject.HOME and one.wrong), None)
        home = self.waypoints.home
        if wrong is None or wrong.place is None or home is None or self.lift_only:
            return
        self.waypoints = replace(self.waypoints, home=(*home[:2], round(wrong.place[2], 2)))
        self.told.append(Change((0,), f"home is at {wrong.place[2]:.1f} m above the sea in place of {home[2]:.1f} m"))

    def _rebuild(self) -> None:
        """Make the orders anew from the places."""
        made: list[Order] = []
        changed = {
            id(visit.order): k
            for k, visit in enumerate(self.flown.visits)
            if np.abs(self.places[k] - visit.at).max() > SAME_PLACE
        }
        before = {id(self.flown.visits[leg].order): leg for leg in self.added}
        for order in self.waypoints.orders:
            own = self.orders[id(order)]
            if id(order) in before:
                leg = before[id(order)]
                like = (
                    order
                    if order.place is not None and order.kind is not OrderKind.LAND
                    else self.flown.visits[leg - 1].order
                )
                made += [self._new(place, like, leg) for place in self.added[leg]]
            if id(order) in changed:
                k = changed[id(order)]
                own = replace(own, place=self._globe(self.places[k], order, same=self._same_level(k)))
            made.append(own)
        self.waypoints = replace(self.waypoints, orders=renumbered(made))

    def _same_level(self, k: int) -> bool:
        """Tell whether only the height of a place was changed."""
        return bool(np.abs(self.places[k] - self.flown.visits[k].at)[:2].max() <= SAME_PLACE)

    def _new(self, place: Floats, like: Order, leg: int) -> Order:
        radius = min((self.flown.visits[k].radius for k in (leg - 1, leg) if self.flown.visits[k].radius), default=0.0)
        own = None if self.flown.plan.autopilot.name == "ardupilot" else round(min(radius, 2.0), 2) or None
        return Order(0, OrderKind.WAYPOINT, "NAV_WAYPOINT", place=self._globe(place, like), radius=own)

    def _globe(self, place: Floats, like: Order, *, same: bool = False) -> GlobalPlace:
        """Return a place in degrees, its altitude counted as that of an order, rounded up as files round."""
        assert self.scenario.frame.origin is not None
        assert like.place is not None
        ((latitude, longitude, sea),) = to_wgs84(self.scenario.frame.origin, place[None]).tolist()
        if same:
            latitude, longitude = like.place[:2]
        kind = type(like.place[2])
        if kind is AboveHome:
            metres = float(place[2] - self.flown.plan.home[2])
        elif kind is AboveGround and self.scenario.terrain is not None:
            lift = lift_over_ground(self.waypoints, self.scenario, float(self.flown.plan.home[2]))
            metres = float(place[2] - lift - self.scenario.terrain.height(place[:2]))
        else:
            metres = sea
        return (
            latitude if same else round(latitude, 7),
            longitude if same else round(longitude, 7),
            kind(round(metres + 0.004, 2)),
        )


def _too_low(found: MissionFinding) -> float:
    """Return by how many metres a leg or corner is too low, 0 where it is not."""
    too_high = found.kind in (FindingKind.CEILING, FindingKind.BOUNDS)
    return 0.0 if too_high or found.deep is None else found.deep


def _straightened(world: World, way: Floats) -> Floats:
    """Return a way, (n, 3) metres, with as few of its bends as a greedy search leaves in a world."""
    kept = [0]
    while kept[-1] < len(way) - 1:
        ahead = np.arange(kept[-1] + 1, len(way))
        seen = world.segments_free(np.repeat(way[kept[-1]][None], len(ahead), axis=0), way[ahead])
        kept.append(int(ahead[seen][-1]) if seen.any() else kept[-1] + 1)
    return way[kept]


def _length(way: Floats) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(way))


def net_changes(before: Waypoints, after: Waypoints, changes: Sequence[Change]) -> Iterator[Change]:
    """Yield what was changed in all, each thing once, and of places that were moved from where to where."""
    was, now = ({order.number: order for order in before.orders}, {order.item: order for order in after.orders})
    last = {(change.items, change.said.split()[0]): change for change in changes}
    for (items, _), change in last.items():
        if not change.said.startswith(MOVED):
            yield change
            continue
        old = was[items[0]]
        told = _moved(old, now[old.item])
        if told:
            yield Change(items, told + change.said.removeprefix(MOVED))


def _moved(old: Order, new: Order) -> str:
    """Say how far an order's place was moved, and from which height to which."""
    if old.place is None or new.place is None:
        return ""
    (latitude, longitude, low), (north, east, high) = old.place, new.place
    origin = Origin(latitude=latitude, longitude=longitude, altitude=0.0) if math.isfinite(latitude) else None
    aside = 0.0 if origin is None else math.hypot(*to_local(origin, [[north, east, 0.0]])[0, :2])
    up = high.metres - low.metres
    told = [f"{told_metres(aside)} aside"] if aside > SPARE / 10 else []
    told += [f"{told_metres(abs(up))} {'up' if up > 0 else 'down'}"] if up else []
    counted_from = {AboveHome: "home", AboveGround: "ground"}.get(type(low), "the sea")
    heights = f", from {low.metres:.1f} to {high.metres:.1f} m above {counted_from}" if up else ""
    return f"{MOVED} {' and '.join(told)}{heights}" if told else ""
