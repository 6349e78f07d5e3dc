"""What readers of missions share: numbers and places from texts, and how places in a file become those of orders."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from skyverse.errors import InputError, parse_number
from skyverse.model.altitude import Altitude, GlobalPlace
from skyverse.model.waypoints import OrderKind, Waypoints


class Given(NamedTuple):
    """What a reader is told where a file does not say it: what altitudes are counted from, and the geoid there."""

    altitude: str | None = None
    geoid: float | None = None


def parse_place(
    row: Sequence[str | float | None], kind: type[Altitude], where: str, metres: float = 1.0
) -> GlobalPlace:
    """Return the place of a latitude, a longitude and an altitude, which is counted in a unit of so many metres."""
    latitude = parse_number(row[0], f"{where}: latitude", -90.0, 90.0)
    longitude = parse_number(row[1], f"{where}: longitude", -180.0, 180.0)
    return latitude, longitude, kind(metres * parse_number(row[2], f"{where}: altitude"))


def written(value: float, digits: int = 10) -> str:
    """Return a number as a text, without an exponent."""
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") if round(value, digits) else "0"


class Step(NamedTuple):
    """One place of a file as it shall be.

    Attributes
    ----------
    source, new
        Which of the file's places it is; or is made like, and is added after, or before it if there is none before.
    place, moved
        Where it shall be, and whether that is elsewhere than its source.
    rise
        Metres by which it is higher than its source.
    stops
        Whether a stop is to be added, as at all that is new: nothing says how wide a turn may be there.
    turns
        Within how many metres it turns, if that is to be changed.
    """

    source: int
    new: bool
    place: GlobalPlace
    moved: bool
    rise: float
    stops: bool
    turns: float | None


def steps(before: Waypoints, after: Waypoints, in_file: Sequence[int]) -> Iterator[Step]:
    """Yield the places of a file as they shall be.

    Parameters
    ----------
    before, after
        What the file holds, and what it shall hold.
    in_file
        The items of the orders of `before` that are places of the file, one after the other.

    Raises
    ------
    InputError
        If an order is gone or elsewhere in the list, if what is no place of the file has moved (but a take-off), or
        if an altitude is counted from something else.
    """
    number = {item: k for k, item in enumerate(in_file)}
    source = -1
    if [order.item for order in after.orders if order.item is not None] != list(range(len(before.orders))):
        raise InputError(f"{after.name}: expected all orders of the file in their order, with others between")
    for order in after.orders:
        if order.item is None and order.place is None:
            continue  # a wait, which no file but those of MAVLink items can tell
        former = before.orders[in_file[max(source, 0)] if order.item is None else order.item]
        if order.item is not None and order.item not in number:
            if order.kind is not OrderKind.TAKEOFF and repr(order.place) != repr(former.place):
                raise InputError(f"{after.name}: order {order.number} ({order.name}) has no place that can be written")
            continue
        source = source if order.item is None else number[order.item]
        if order.place is None or former.place is None or type(order.place[2]) is not type(former.place[2]):
            said = f"expected a place as that of {former.name} {former.number}"
            raise InputError(f"{after.name}: order {order.number}: {said}")
        new, rise = order.item is None, order.place[2].metres - former.place[2].metres
        turns = None if new or order.radius == former.radius else order.radius
        stops = new or order.seconds > former.seconds
        yield Step(max(source, 0), new, order.place, order.place != former.place, rise, stops, turns)
