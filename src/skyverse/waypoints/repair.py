"""Missions are mended: places that are not safe are moved least, legs are led over or around, corners are cut less.

The user's orders, their sequence and their speeds stay. A leg that fails is led over what it meets along the shortest
line that keeps above it and below the ceiling, or around it as the planners find, whichever is shorter. What was
changed is judged again, until nothing is wrong or nothing helps.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from skyverse.exports.separation import Apart, fleet_apart, kept_distance
from skyverse.exports.way_home import WayHome, ways_home
from skyverse.maps.assembly.options import BuildOptions
from skyverse.model.flight_settings import FlightSettings
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.waypoints import Order, OrderKind, Waypoints
from skyverse.orders.files import rewritten
from skyverse.waypoints.fleet import CheckedFleet, check_at, site_of
from skyverse.waypoints.mender import Change, Mender, net_changes, renumbered

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
    if settings.return_altitude is not None:  # each mission may come to have another
        missions = [replace(one, return_altitude=settings.return_altitude) for one in missions]
        settings = replace(settings, return_altitude=None)
    built = isinstance(where, BuildOptions)
    made, changes = list(missions), [list[Change]() for _ in missions]
    for _ in range(SITES):  # where waypoints are added, the maps are read a little otherwise
        site, before = site_of(made, where, settings), tuple(made)
        _mended(missions, made, changes, partial(check_at, site=site, settings=settings, lower=built), lift_only)
        # not all can be written; return altitudes stand in files of parameters
        again = [replace(rewritten(one), return_altitude=one.return_altitude) for one in made]
        checked = check_at(again, site_of(again, where, settings), settings, lower=built)
        if checked.is_proven or tuple(made) == before:
            break
    told_of = (tuple(net_changes(*each)) for each in zip(missions, made, changes, strict=True))
    return RepairedFleet(tuple(made), tuple(told_of), checked)


def _mended(
    missions: Sequence[Waypoints],
    made: list[Waypoints],
    changes: list[list[Change]],
    check: Callable[[Sequence[Waypoints]], CheckedFleet],
    lift_only: bool,
) -> None:
    """Mend missions at one site, round by round, and keep what has the fewest faults, the first of it."""
    checked = check(made)
    tries = []
    for _ in range(ROUNDS):
        tries.append((_faults(checked), tuple(made), [list(one) for one in changes]))
        mended = False
        for k, mission in enumerate(checked.missions):
            former = {one.item: one.number for one in missions[k].orders if one.item is not None}
            mender = Mender(mission, former, lift_only=lift_only)
            if mender.run():
                made[k], mended = mender.waypoints, True
                changes[k] += [one for one in mender.told if one.items]
        if not mended:
            mended = _with_better_returns(made, changes, checked)
        if not mended and not lift_only:
            mended = _delayed(made, changes, checked)
        if not mended:
            break
        checked = check(made)
    tries.append((_faults(checked), tuple(made), list(changes)))
    _, made[:], changes[:] = min(tries, key=lambda one: one[0])


def _faults(checked: CheckedFleet) -> int:
    return sum(one.wrong for mission in checked.missions for one in mission.findings)


def _with_better_returns(made: list[Waypoints], changes: list[list[Change]], checked: CheckedFleet) -> bool:
    """Choose return altitudes where those of the autopilots are not proven, and tell whether any was chosen."""
    chosen = False
    for k, mission in enumerate(checked.missions):
        if mission.back is None or mission.back.everywhere:
            continue
        unlimited = derived(mission.scenario, max_height=None)
        (best,) = ways_home(unlimited, [replace(mission.flown.plan, ending=np.zeros((0, 3)))])
        if best is not None and _lost(best) < _lost(mission.back):
            made[k], chosen = replace(made[k], return_altitude=best.altitude), True
            changes[k] = [one for one in changes[k] if not one.said.startswith("returns at")]
            changes[k].append(Change((), f"returns at {best.altitude:g} m above home"))
    return chosen


def _lost(back: WayHome) -> float:
    """Return for how many seconds no return is proven."""
    return sum(gap.end - gap.begin for gap in back.gaps)


def _delayed(made: list[Waypoints], changes: list[list[Change]], checked: CheckedFleet) -> bool:
    """Delay a mission that comes too close to another until it keeps apart, by timing if it can, and tell whether."""
    plans = [one.flown.plan for one in checked.missions]
    for first, late in checked.apart.of(Apart.CLOSE):
        found: dict[Apart, float] = {}
        for seconds in DELAYS.tolist():
            delayed = replace(plans[late], delay=plans[late].delay + seconds)
            apart = fleet_apart(checked.scenario, [*plans[:late], delayed, *plans[late + 1 :]])
            kinds = [kind for pair, kind in apart.pairs.items() if late in pair]
            found.setdefault(max(kinds, key=list(Apart).index), seconds)
            if seconds > LONG_WAIT and min(found, key=list(Apart).index) is not Apart.CLOSE:
                break
        best = min(found, key=list(Apart).index)
        if best is Apart.CLOSE and not any(one.said.startswith("flies") for one in changes[late]):
            keep = kept_distance(checked.scenario, first, late)
            below, above = (plans[k].waypoints[:, 2] for k in (first, late))
            up = keep.above + keep.error_above + 1.0 + float(below.max() - above.min())
            items = tuple(order.number for order in made[late].orders if _higher(order, up) is not order)
            made[late] = replace(made[late], orders=tuple(_higher(order, up) for order in made[late].orders))
            changes[late].append(Change(items, f"flies {up:.3g} m higher, to keep apart"))
            return True
        if best is not Apart.CLOSE:
            wait = Order(0, OrderKind.DELAY, "NAV_DELAY", seconds=found[best])
            waits = replace(made[late], orders=renumbered((wait, *made[late].orders)))
            if len(rewritten(waits).orders) == len(made[late].orders):  # its file cannot tell it
                continue
            made[late] = waits
            changes[late].append(Change((), f"starts {found[best]:g} s later, to keep apart"))
            return True
    return False


def _higher(order: Order, up: float) -> Order:
    """Return an order with its place so many metres higher, unless it is a landing or no place of the flight."""
    if order.place is None or order.kind not in (OrderKind.TAKEOFF, OrderKind.WAYPOINT, OrderKind.LOITER):
        return order
    latitude, longitude, altitude = order.place
    return replace(order, place=(latitude, longitude, type(altitude)(round(altitude.metres + up, 2))))
