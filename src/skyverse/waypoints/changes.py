"""What was changed of a mission, told item by item: from what, to what, and why."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skyverse.model.altitude import AboveGround, AboveHome, GlobalPlace
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_local, told_globe
from skyverse.model.short_lines import counted, told_metres
from skyverse.model.waypoints import Order, OrderKind, Waypoints

LEAST_ASIDE = 0.01
"""Metres to the side that are told: less is what files round."""
STRAIGHT = 0.1
"""Metres to the side of a leg within which a way leads over what the leg meets, and not around it."""


@dataclass(frozen=True)
class Change:
    """One thing that was changed: the numbers of the orders as the file had them, and in words from what to what."""

    items: tuple[int, ...]
    said: str


def changes(before: Waypoints, after: Waypoints, met: Mapping[int, str]) -> Iterator[Change]:
    """Yield what was changed of a mission.

    Parameters
    ----------
    before, after
        As it was, and as it is: orders that were added have no item.
    met
        What was met at an order, by its item.
    """
    if before.home is not None and after.home is not None and before.home[2] != after.home[2]:
        yield Change((0,), f"home is at {after.home[2]:.1f} m above the sea in place of {before.home[2]:.1f} m")
    was = {order.item: order for order in before.orders}
    placed: Order | None = None
    added: list[Order] = []
    for order in after.orders:
        if order.item is None:
            added.append(order)
            continue
        old = was[order.item]
        if added:
            yield _of_added(placed and was[placed.item], placed, added, old, order)
            added = []
        yield from _of_order(old, order, met.get(order.item, ""))
        placed = order if order.place is not None else placed
    if after.retraces and not before.retraces:
        yield Change((), "returns along its mission, where no straight way home is clear at any height")
    elif after.return_altitude != before.return_altitude:
        yield Change((), f"returns at {after.return_altitude:g} m above home")


def _of_order(old: Order, new: Order, met: str) -> Iterator[Change]:
    """Yield what was changed of an order."""
    items = (old.number,)
    if new.kind is not old.kind:
        yield Change(items, "lands at home in place of a return")
    elif new.place != old.place and old.place is not None and new.place is not None:
        moved = _moved(old.place, new.place)
        if moved:
            yield Change(items, f"moved {moved}" + (f", off the {met}" if met else ""))
    if new.radius != old.radius:
        instead = "" if old.radius is None else f" in place of {old.radius:.3g} m"
        yield Change(items, f"acceptance radius of {new.radius:g} m{instead}")
    if new.seconds != old.seconds:
        yield Change(items, f"stops for {new.seconds:g} s, so that it cuts no corner")


def _moved(old: GlobalPlace, new: GlobalPlace) -> str:
    """Say how far a place was moved, and from where and which height to which."""
    low, high = old[2], new[2]
    aside, up = 0.0 if math.isnan(old[0]) else math.hypot(*_local([old, new])[1, :2]), high.metres - low.metres
    begin, end = (told_globe(latitude, longitude) for latitude, longitude, _ in (old, new))
    told = [f"{told_metres(aside)} aside from {begin} to {end}"] if aside > LEAST_ASIDE else []
    told += [f"{told_metres(abs(up))} {'up' if up > 0 else 'down'}"] if up else []
    counted_from = {AboveHome: "home", AboveGround: "ground"}.get(type(low), "the sea")
    heights = f", from {low.metres:.1f} to {high.metres:.1f} m above {counted_from}" if up else ""
    return " and ".join(told) + heights


def _of_added(before: Order | None, begin: Order | None, added: Sequence[Order], after: Order, end: Order) -> Change:
    """Return what the orders do that were added between two, which are given as they were and as they are."""
    if added[0].kind is OrderKind.DELAY:
        return Change((), f"starts {added[0].seconds:g} s later, to keep apart")
    places = [one.place for one in (begin, *added, end) if one is not None and one.place is not None]
    count, items = counted(len(added), "more waypoint"), tuple(one.number for one in (before, after) if one is not None)
    if begin is None or end.kind is OrderKind.LAND or len({type(one[2]) for one in places}) > 1:
        return Change(items, f"led by {count}")
    way = _local(places)
    (x, y), more = way[-1, :2], sum(math.dist(*leg) for leg in pairwise(way)) - math.dist(way[0], way[-1])
    off = np.abs(way[:, 0] * y - way[:, 1] * x).max() / max(math.hypot(x, y), 1.0)
    return Change(items, f"led {'over' if off <= STRAIGHT else 'around'} by {count}, {told_metres(more)} longer")


def _local(places: Sequence[GlobalPlace]) -> np.ndarray:
    """Return places in metres from the first, (n, 3), with altitudes as they are counted."""
    latitude, longitude, _ = places[0]
    origin = Origin(latitude=latitude, longitude=longitude, altitude=0.0)
    flat = to_local(origin, [[*one[:2], 0.0] for one in places])[:, :2]
    return np.column_stack([flat, [one[2].metres for one in places]])
