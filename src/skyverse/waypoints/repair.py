"""Missions are mended: places that are not safe are moved least, legs are led over or around, corners are cut less.

The user's orders, their sequence and their speeds stay. A leg that fails is led over what it meets along the shortest
line that keeps above it and below the ceiling, or around it as the planners find, whichever is shorter. What was
changed is judged again, until nothing is wrong or nothing helps.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from skyverse.exports.return_altitudes import ways_home
from skyverse.exports.separation import Apart, fleet_apart, kept_distance
from skyverse.exports.way_home import WayHome
from skyverse.maps.assembly.options import BuildOptions
from skyverse.model.altitude import AboveHome
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.geodesy import to_local, to_wgs84
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.orders.files import rewritten
from skyverse.waypoints.changes import Change, changes
from skyverse.waypoints.check import CheckedMission
from skyverse.waypoints.findings import Subject
from skyverse.waypoints.fleet import CheckedFleet, check_at, site_of
from skyverse.waypoints.mender import Mender, renumbered
from skyverse.waypoints.site import same_site
from skyverse.waypoints.way_back import why_not_back

SITES = 3
"""How often missions are mended, each time at the site that they have then."""
ROUNDS = 8
"""How often missions are mended and judged again."""
DELAYS = np.r_[5:60:5, 60:600:15, 600:3601:60].astype(np.float64)
"""Seconds by which the start of a vehicle is delayed, until it keeps apart from another."""
LONG_WAIT = 300.0
"""Seconds of a delay from which any that keeps vehicles apart is taken."""


@dataclass(frozen=True, eq=False)
class RepairedFleet:
    """Missions that were mended.

    Attributes
    ----------
    missions
        As `write_waypoints` writes them.
    changes
        What was changed of each.
    checked
        What is found of them now; what could not be mended is among it.
    """

    missions: tuple[Waypoints, ...]
    changes: tuple[tuple[Change, ...], ...]
    checked: CheckedFleet


def repair_waypoints(
    missions: Sequence[Waypoints],
    where: Scenario | BuildOptions,
    settings: FlightSettings | None = None,
    *,
    lift_only: bool = False,
) -> RepairedFleet:
    """Mend missions so that they are proven as their autopilots fly them.

    Parameters
    ----------
    missions, where, settings
        As for `check_waypoints`.
    lift_only
        Whether nothing but the heights of places may change.

    Raises
    ------
    InputError
        As of `check_waypoints`.
    """
    settings = settings or FlightSettings()
    # each mission may come to have others
    up, retraces = settings.return_altitude, settings.retraces
    missions = [
        replace(one, return_altitude=one.return_altitude if up is None else up, retraces=one.retraces or retraces)
        for one in missions
    ]
    settings = replace(settings, return_altitude=None, retraces=False)
    built = isinstance(where, BuildOptions)
    made, met = tuple(missions), tuple(dict[int, str]() for _ in missions)
    for _ in range(SITES):  # where waypoints are added, the maps are read a little otherwise
        site, before = site_of(made, where, settings), made
        check = partial(check_at, settings=settings, lower=built)
        checked, made = _mended(made, met, partial(check, site=site), lift_only)
        # not all can be written; how it returns stands in files of parameters
        again = [replace(rewritten(one), return_altitude=one.return_altitude, retraces=one.retraces) for one in made]
        if again != list(before):
            checked = check(again, site if same_site(again, before, settings) else site_of(again, where, settings))
        if checked.is_proven or made == before:
            break
    told_of = (tuple(changes(*each)) for each in zip(missions, made, met, strict=True))
    return RepairedFleet(made, tuple(told_of), checked)


def _mended(
    made: tuple[Waypoints, ...],
    met: Sequence[dict[int, str]],
    check: Callable[[Sequence[Waypoints]], CheckedFleet],
    lift_only: bool,
) -> tuple[CheckedFleet, tuple[Waypoints, ...]]:
    """Mend missions at one site, round by round, and return what has the fewest faults, the shortest of it."""
    tries: list[tuple[int, float, CheckedFleet, tuple[Waypoints, ...]]] = []

    def legs(mission: CheckedMission) -> Waypoints:
        return Mender(mission, lift_only=lift_only).mended()

    def climbs(mission: CheckedMission) -> Waypoints:
        return Mender(mission, lift_only=lift_only).with_room_for_climbs()

    ways = [legs, _returning_higher, climbs, *([] if lift_only else [_retracing])]
    while True:
        checked = check(made)
        wrong = [[one for one in mission.findings if one.wrong] for mission in checked.missions]
        length = sum(mission.summary.length for mission in checked.missions)
        tries.append((sum(map(len, wrong)), length, checked, made))
        if checked.is_proven or len(tries) > ROUNDS:
            break
        for mission, known in zip(checked.missions, met, strict=True):
            known.update(_met_nearest(mission) | known)
        if len(tries) > ROUNDS // 2 and climbs in ways:  # which leaves rounds for another way home
            ways.remove(climbs)
        after = (tuple(map(way, checked.missions)) for way in ways)
        before, made = made, next((one for one in after if one != made), made)
        if made == before:
            made = _kept_apart(made, checked, [] if lift_only else DELAYS.tolist())
        if made == before:
            break
    return min(tries, key=lambda one: one[:2])[2:]


def _met_nearest(mission: CheckedMission) -> dict[int, str]:
    """Return what is met nearest to the place of each item, of all that its legs and corners meet."""
    origin, near = mission.scenario.frame.origin, defaultdict[int, list[tuple[float, str]]](list)
    assert origin is not None
    at = {visit.order.number: visit for visit in mission.flown.visits}
    for one in mission.findings:
        if one.deep is None or one.place is None:
            continue
        place = to_local(origin, [one.place])[0]
        # the way on from a corner may be too low up to the next place
        items = one.items if not one.corner or one.part is None else (*one.items, *mission.flown.numbers(one.part + 1))
        for visit in (at[number] for number in items if number in at):
            if visit.order.item is not None:
                near[visit.order.item].append((math.dist(place, visit.at), one.what))
    return {item: min(each)[1] for item, each in near.items()}


def _returning_higher(mission: CheckedMission) -> Waypoints:
    """Return a mission with the return altitude from which the fewest instants are without a way home."""
    told, back = mission.flown.waypoints, mission.back
    if back is None or back.everywhere or mission.flown.retraces:
        return told
    unlimited = derived(mission.scenario, max_height=None)
    (best,) = ways_home(unlimited, [replace(mission.flown.plan, ending=np.zeros((0, 3)))])
    return replace(told, return_altitude=best.altitude) if best is not None and _lost(best) < _lost(back) else told


def _retracing(mission: CheckedMission) -> Waypoints:
    """Return a mission that returns along itself, if all that is wrong with it is the straight way home."""
    wrong = {one.subject for one in mission.findings if one.wrong}
    if mission.flown.retraces or not wrong <= {Subject.WAY_HOME, Subject.END} or why_not_back(mission.flown):
        return mission.flown.waypoints
    return replace(_landing_at_home(mission), retraces=True)


def _landing_at_home(mission: CheckedMission) -> Waypoints:
    """Return a mission that lands at home, below the end of its take-off, in place of a return."""
    flown, told, origin = mission.flown, mission.flown.waypoints, mission.scenario.frame.origin
    assert origin is not None
    home = tuple(to_wgs84(origin, flown.plan.home[None])[0, :2].round(7).tolist())
    top = AboveHome(round(float(flown.visits[0].at[2] - flown.plan.home[2]), 2))
    orders = list[Order]()
    for order in told.orders:
        if order.kind is OrderKind.RETURN:
            orders.append(Order(0, OrderKind.WAYPOINT, "NAV_WAYPOINT", place=(*home, top)))
            order = replace(order, kind=OrderKind.LAND, name="NAV_LAND", place=(*home, AboveHome(0.0)))
        orders.append(order)
    return replace(told, orders=renumbered(orders))


def _lost(back: WayHome) -> float:
    """Return for how many seconds no return is proven."""
    return sum(gap.end - gap.begin for gap in back.gaps)


def _kept_apart(made: tuple[Waypoints, ...], checked: CheckedFleet, delays: Sequence[float]) -> tuple[Waypoints, ...]:
    """Delay a mission that comes too close to another until it keeps apart, by timing if it can, or fly it higher."""
    plans = [one.flown.plan for one in checked.missions]
    for first, late in checked.apart.of(Apart.CLOSE):
        found: dict[Apart, float] = {}
        for seconds in delays:
            delayed = replace(plans[late], delay=plans[late].delay + seconds)
            apart = fleet_apart(checked.scenario, [*plans[:late], delayed, *plans[late + 1 :]])
            kinds = [kind for pair, kind in apart.pairs.items() if late in pair]
            found.setdefault(max(kinds, key=list(Apart).index), seconds)
            if seconds > LONG_WAIT and min(found, key=list(Apart).index) is not Apart.CLOSE:
                break
        best = min(found, key=list(Apart).index, default=Apart.CLOSE)
        if best is Apart.CLOSE:
            keep = kept_distance(checked.scenario, first, late)
            below, above = (plans[k].waypoints[:, 2] for k in (first, late))
            up = keep.above + keep.error_above + 1.0 + float(below.max() - above.min())
            other = replace(made[late], orders=tuple(_higher(order, up) for order in made[late].orders))
        else:
            wait = Order(0, OrderKind.DELAY, "NAV_DELAY", seconds=found[best])
            other = replace(made[late], orders=renumbered((wait, *made[late].orders)))
            if len(rewritten(other).orders) == len(made[late].orders):  # its file cannot tell it
                continue
        return (*made[:late], other, *made[late + 1 :])
    return made


def _higher(order: Order, up: float) -> Order:
    """Return an order with its place so many metres higher, unless it is a landing or no place of the flight."""
    if order.place is None or order.kind not in (OrderKind.TAKEOFF, OrderKind.WAYPOINT, OrderKind.LOITER):
        return order
    latitude, longitude, altitude = order.place
    return replace(order, place=(latitude, longitude, type(altitude)(round(altitude.metres + up, 2))))
