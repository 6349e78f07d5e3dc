"""Tours as people read them: tables of sorties and of visits, and what is told of each."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from skyverse.model.flight_table import NO_VALUE, Column, told_left
from skyverse.model.geodesy import to_wgs84
from skyverse.model.mission import Mission, planned_flights
from skyverse.model.photos import photos_of
from skyverse.model.scenario import Target
from skyverse.model.short_lines import told_seconds
from skyverse.model.sortie import Sortie, Visit
from skyverse.model.uav import UAV
from skyverse.summary import BatteryCourse, battery_course

AT_ONCE = 0.005
"""Seconds of a stay from which it is told; less would be told as none."""


@dataclass(frozen=True)
class NumberedVisit:
    """A visit of a tour.

    Attributes
    ----------
    uav, name
        The index of the UAV, and its name.
    sortie, number
        Both counted from 1, the visits through all sorties of the UAV.
    visit, target
        When it is, and what is visited.
    """

    uav: int
    name: str
    sortie: int
    number: int
    visit: Visit
    target: Target

    @property
    def sentence(self) -> str:
        """When the UAV is there, how long it stays, and the window that it keeps."""
        stay = self.visit.departure - self.visit.arrival
        stays = f", stays {told_seconds(stay)}" if stay > AT_ONCE else ""
        window = "" if self.target.window is None else f", window {_window(self.target)}"
        return f"{self.number}: {self.target.name}, at t = {told_seconds(self.visit.arrival)}{stays}{window}"


def numbered_visits(mission: Mission) -> Iterator[NumberedVisit]:
    """Yield the visits of all tours, by UAV and in their order; none of a mission without tours."""
    for uav, own in enumerate(mission.scenario.uavs if mission.sorties else ()):
        flown = [(k, visit) for k, one in enumerate(mission.sorties_of(uav), 1) for visit in one.visits]
        for number, (sortie, visit) in enumerate(flown, 1):
            yield NumberedVisit(uav, own.name, sortie, number, visit, mission.scenario.targets[visit.target])


@dataclass(frozen=True, eq=False)
class NumberedSortie:
    """A sortie, and how its battery empties.

    Attributes
    ----------
    uav, vehicle
        The index of the UAV, and the UAV.
    number
        Counted from 1.
    sortie
        When it is.
    battery
        ``None`` without a battery.
    """

    uav: int
    vehicle: UAV
    number: int
    sortie: Sortie
    battery: BatteryCourse | None

    @property
    def spare(self) -> float | None:
        """How much more than the reserve is left at landing, Wh, negative where it is less; ``None`` if not known."""
        if self.battery is None or self.vehicle.battery is None:
            return None
        return float(self.battery.left[-1] - self.vehicle.reserve) * self.vehicle.battery


def numbered_sorties(mission: Mission) -> Iterator[NumberedSortie]:
    """Yield the sorties of all UAVs, by UAV and in their order."""
    for uav, flight in enumerate(planned_flights(mission)):
        for number, one in enumerate(flight.sorties if flight.trajectory is not None else (), 1):
            course = (
                None if flight.trajectory is None else battery_course(mission.scenario, uav, flight.trajectory, one)
            )
            yield NumberedSortie(uav, flight.uav, number, one, course)


def visit_columns(mission: Mission) -> list[Column]:
    """Return the table of visits."""
    visits = list(numbered_visits(mission))
    columns = [
        Column("UAV", "", tuple(one.name for one in visits)),
        Column("visit", "In the order of its tour.", tuple(str(one.number) for one in visits)),
        Column("target", "", tuple(one.target.name for one in visits)),
        Column("sortie", "Each on one battery.", tuple(str(one.sortie) for one in visits)),
        Column("at", "When its stay begins.", tuple(told_seconds(one.visit.arrival) for one in visits)),
        Column("stays", "", tuple(told_seconds(one.visit.departure - one.visit.arrival) for one in visits)),
        Column("leaves", "When its stay ends.", tuple(told_seconds(one.visit.departure) for one in visits)),
    ]
    windows = tuple(NO_VALUE if one.target.window is None else _window(one.target) for one in visits)
    return [*columns, *([Column("window", "In which the stay may begin.", windows)] if {*windows} - {NO_VALUE} else [])]


def sortie_columns(mission: Mission) -> list[Column]:
    """Return the table of sorties: when they are, what is left of batteries, and until when turning back fits."""
    sorties = list(numbered_sorties(mission))

    def told(cell: Callable[[NumberedSortie], str]) -> tuple[str, ...]:
        return tuple(map(cell, sorties))

    columns = [
        Column("UAV", "", told(lambda one: one.vehicle.name)),
        Column("sortie", "Each on one battery.", told(lambda one: str(one.number))),
        Column("takes off", "", told(lambda one: told_seconds(one.sortie.begin))),
        Column("lands", "", told(lambda one: told_seconds(one.sortie.end))),
        *_what_is_done(mission, sorties),
        Column("battery left", "At landing, in gusts at their worst, and how near to the reserve.", told(_left)),
        Column("margin", "By how much the battery gives more than that, or less.", told(told_spare)),
        Column(
            "can turn back until",
            "The point of no return: until then the battery suffices for flying home the way that the UAV came; after "
            "that, for going on along the plan.",
            told(told_return),
        ),
    ]
    return columns if any(one.battery for one in sorties) else columns[:-3]


def planned_sheet(mission: Mission) -> tuple[tuple[str, ...], ...]:
    """Return the head and the rows of a table for whoever prepares the flights: homes, when, and batteries."""
    origin, rows = mission.scenario.frame.origin, []
    for one in numbered_sorties(mission):
        x, y, z = one.vehicle.start
        home = f"x {x:.1f}, y {y:.1f}, z {z:.1f} m" if origin is None else told_home(*to_wgs84(origin, [(x, y, z)])[0])
        battery = NO_VALUE if one.battery is None else f"battery {one.number}: {_left(one)} at landing"
        times = f"t = {told_seconds(one.sortie.begin)} to {told_seconds(one.sortie.end)}"
        rows.append((f"{one.vehicle.name}, sortie {one.number}", home, times, battery))
    return (("flight", "start", "flies", "battery left"), *rows) if rows else ()


def told_home(latitude: float, longitude: float, altitude: float) -> str:
    """Return a place on the globe as a ground station takes it, with its metres above mean sea level."""
    return f"{latitude:.6f}, {longitude:.6f}, {altitude:z.1f} m above mean sea level"


def _what_is_done(mission: Mission, sorties: list[NumberedSortie]) -> Iterator[Column]:
    """Yield the columns of how many visits are made, strips flown and photos taken."""
    if mission.scenario.targets or not mission.scenario.surveys:
        yield Column("visits", "", tuple(str(len(one.sortie.visits)) for one in sorties))
    if mission.scenario.surveys:
        photos = photos_of(mission)
        within = ((photos.uav == one.uav) & (photos.time <= one.sortie.end) for one in sorties)
        taken = [int((own & (photos.time >= one.sortie.begin)).sum()) for own, one in zip(within, sorties, strict=True)]
        yield Column(
            "strips", "Ways along which photos are taken.", tuple(str(len(one.sortie.strips)) for one in sorties)
        )
        yield Column("photos", "", tuple(f"{count:,}" for count in taken))


def _left(one: NumberedSortie) -> str:
    return NO_VALUE if one.battery is None else told_left(float(one.battery.left[-1]), one.vehicle.reserve)


def told_spare(one: NumberedSortie) -> str:
    """Return by how much a sortie fits into its battery, rounded to the safe side: ``fits by 1.2 Wh``."""
    if one.spare is None:
        return NO_VALUE
    if one.spare < 0:
        return f"lacks {math.ceil(-100 * one.spare) / 100:.2f} Wh"
    digits = 2 if one.spare < 10 else 1
    return f"fits by {math.floor(one.spare * 10**digits) / 10**digits:.{digits}f} Wh"


def told_return(one: NumberedSortie) -> str:
    """Return until when turning back is possible in a sortie."""
    if one.battery is None:
        return NO_VALUE
    if one.battery.no_return is None:
        return "never"
    always = one.battery.no_return >= one.battery.instants[-1]
    return "landing" if always else f"t = {told_seconds(math.floor(one.battery.no_return))}"


def _window(target: Target) -> str:
    begin, end = target.window or (0.0, math.inf)
    return f"{told_seconds(begin)} to {told_seconds(end)}"
