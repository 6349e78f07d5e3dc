"""Tours: several targets for each UAV, in the best order, within what its battery gives, and home again."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from skyverse._typing import Ints
from skyverse.errors import InputError
from skyverse.interrupt import interrupted
from skyverse.mission.assignment import Criterion
from skyverse.mission.exact_routing import MOST_TARGETS
from skyverse.mission.given_order import stretches
from skyverse.mission.leg_planning import Ends, Leg, LegPlanning
from skyverse.mission.route import retold, route, told
from skyverse.mission.routing import Reason, Routes, RouteSearch, Tour, TourVehicle, Work
from skyverse.mission.tour_flight import TourFlight
from skyverse.mission.tour_legs import TourLegs, joined_result, legs_of
from skyverse.mission.tour_waits import with_waits
from skyverse.model.mission import Mission
from skyverse.model.result import Provenance
from skyverse.model.scenario import Scenario
from skyverse.model.sortie import Unvisited
from skyverse.problem import Airspace
from skyverse.survey.lines import PhotoLine

MOST_ROUNDS = 40
"""How often routes are sought anew because legs of the last ones turned out dearer than they seemed."""
CLOSE = 1e-3
"""The share by which routes to many targets may turn out dearer than they seemed, before they are sought thoroughly."""

MOST_DOUBTED = 50
"""Targets that seem to be left over of which it is found out at most whether anybody could go there at all."""

REASONS: dict[Reason, str] = {
    "nobody may": "no UAV may go there",
    "no way": "no UAV has a way there and back",
    "capacity": "its demand is above what any UAV that may go there can carry",
    "window": "no UAV can be there before its window closes",
    "battery": "no battery gives what it takes to go there and back",
    "left over": "no UAV has time, battery or capacity left for it beside the others",
}
"""Why targets are left out."""


@dataclass(frozen=True, kw_only=True)
class TourOptions:
    """How tours are made.

    Attributes
    ----------
    criterion
        What is minimised; see `route`.
    keep_order
        Whether each UAV visits its targets in the order in which the scenario gives them.
    keep_apart
        Whether UAVs wait for others to pass.
    only
        For each UAV the one target that it may visit; ``None`` where all may visit all.
    """

    criterion: Criterion
    keep_order: bool
    keep_apart: bool
    only: tuple[int | None, ...] | None = None


def plan_tours(
    airspace: Airspace,
    how: LegPlanning,
    options: TourOptions,
    origin: Provenance,
    lines: Mapping[Ends, PhotoLine] = MappingProxyType({}),
) -> Mission:
    """Plan a mission of tours: who visits what and in which order, the legs, and waits for others.

    Photo `lines` between two targets are flown from one to the other, whichever way is given.

    Legs are priced by lower bounds until routes want them; those are planned, and the routes sought anew, until no leg
    of theirs is left that was not planned. With up to ten targets they are then the best by the prices of all pairs.
    """
    scenario = airspace.scenario
    _require_no_stops(scenario, lines)
    windy = scenario.wind is not None or any(uav.battery is not None for uav in scenario.uavs)
    timed = windy or bool(lines) or any(target.window is not None for target in scenario.targets)
    legs = TourLegs(airspace, how, timed, lines)
    legs.price([(uav, ends) for uav in range(len(scenario.uavs)) for ends in lines])
    routes = _finished_routes(scenario, legs, options)
    flights = [_flight(scenario, legs, uav, routes) for uav in range(len(scenario.uavs))]
    lost = itertools.chain(
        *(itertools.chain(*tour) for tour, one in zip(routes.tours, flights, strict=True) if not one)
    )
    no_way = "the planner found no way on the tour that leads there"
    unvisited = dict.fromkeys(lost, "the run was interrupted" if interrupted() else no_way)
    unvisited |= {target: REASONS[why] for target, why in routes.unvisited.items()}
    mission = Mission(
        scenario=scenario,
        assignment=(),
        results=tuple(
            None if flight is None else joined_result(airspace, [one.result for one in _legs(legs, uav, _ends(flight))])
            for uav, flight in enumerate(flights)
        ),
        trajectories=(),
        violations=(),
        provenance=origin,
        interrupted=interrupted(),
        unvisited=tuple(Unvisited(*one) for one in sorted(unvisited.items())),
    )
    planned = _flown(mission, flights)
    return with_waits(airspace, planned, flights, _flown) if options.keep_apart and not planned.interrupted else planned


def _require_no_stops(scenario: Scenario, lines: Mapping[Ends, PhotoLine]) -> None:
    """Refuse aeroplanes that are to stop, as at all targets but the ends of lines."""
    passed = {place for ends in lines for place in ends}
    for uav in scenario.uavs:
        for number, target in enumerate(scenario.targets):
            if uav.fixed_wing is not None and number not in passed and uav.name in (target.uavs or uav.name):
                place = "targets, or for single photos of surveys"
                why = f"{uav.name} is an aeroplane, which cannot stop at {place}; multirotors can"
                raise InputError(why, field="assignment")


def _finished_routes(scenario: Scenario, legs: TourLegs, options: TourOptions) -> Routes:
    """Return routes all of whose legs are those of the planner, unless that is interrupted.

    Where its legs break a window or a battery that quickly found ones kept, routes are sought anew.
    """
    work = _work(scenario)
    for _ in range(MOST_ROUNDS):
        routes = _routes(scenario, legs, work, options)
        legs.finish(_wanted(scenario, routes))
        finished = retold(legs.vehicles(work.stay, options.only), work, routes, options.criterion)
        if finished is not None or interrupted():
            break
    return routes if finished is None else replace(finished, unvisited=routes.unvisited)


def _work(scenario: Scenario) -> Work:
    stay = np.array([target.stay for target in scenario.targets], dtype=np.float64)
    windows = [(0.0, math.inf) if target.window is None else target.window for target in scenario.targets]
    return Work(
        stay=stay,
        window=np.array(windows, dtype=np.float64).reshape(-1, 2),
        demand=np.array([target.demand for target in scenario.targets], dtype=np.float64),
    )


def _routes(scenario: Scenario, legs: TourLegs, work: Work, options: TourOptions) -> Routes:
    order = [*range(len(scenario.targets))] if options.keep_order else None
    search = RouteSearch(None, legs.how.seed, order, quick=True)
    best: Routes | None = None
    thorough = len(scenario.targets) <= MOST_TARGETS
    for _ in range(MOST_ROUNDS):
        routes = _routed(legs, work, options, search)
        new = legs.price(_wanted(scenario, routes))
        if best is not None and interrupted():
            break  # not all of these legs may have been planned
        vehicles = legs.vehicles(work.stay, options.only)
        priced = retold(vehicles, work, routes, options.criterion) if new else routes
        if priced is None:
            priced = _recut(scenario, legs, work, routes, options)
        if priced is not None and (best is None or _rank(priced, options) < _rank(best, options)):
            best = priced
        if not new or interrupted():
            break
        if best is not None and len(scenario.targets) > MOST_TARGETS:
            kept = len(best.unvisited) <= len(routes.unvisited)  # else a leg that was wanted has no way
            if thorough and kept:
                break
            thorough = kept and _rank(best, options)[-1] <= _rank(routes, options)[-1] * (1.0 + CLOSE)
            search = search._replace(quick=not thorough, tours=best.tours)
    if best is None:
        best = told(vehicles, work, ((),) * len(scenario.uavs), options.criterion, optimal=False)
    elif not interrupted():
        best = _explained(scenario, legs, work, best, options)
    return replace(best, interrupted=interrupted(), optimal=best.optimal and not interrupted())


def _routed(legs: TourLegs, work: Work, options: TourOptions, search: RouteSearch) -> Routes:
    vehicles = legs.vehicles(work.stay, options.only)
    if not legs.lines:
        return route(vehicles, work, options.criterion, search)
    from skyverse.mission.strip_routing import route_strips

    return route_strips(vehicles, _strips(legs, work), work, options.criterion, search)


def _strips(legs: TourLegs, work: Work) -> Ints:
    """Return the targets at the ends of each line, and twice each other target, (m, 2)."""
    pairs = {(min(ends), max(ends)) for ends in legs.lines if None not in ends}  # type: ignore[type-var]
    alone = set(range(work.targets)).difference(*pairs)
    return np.array(sorted({*pairs, *((place, place) for place in alone)}), dtype=np.intp)


def _explained(scenario: Scenario, legs: TourLegs, work: Work, routes: Routes, options: TourOptions) -> Routes:
    """Return routes that tell why targets are unvisited by what it takes to go there and back, and not by bounds."""
    doubted = [target for target, why in routes.unvisited.items() if why == "left over"][:MOST_DOUBTED]
    uavs = range(len(scenario.uavs))
    legs.price([(uav, ends) for target in doubted for uav in uavs for ends in ((None, target), (target, None))])
    vehicles = legs.vehicles(work.stay, options.only)
    if legs.lines:
        from skyverse.mission.strip_routing import StripNodes

        why = StripNodes.along(_strips(legs, work)).why_unvisited(vehicles, work, routes.tours)
        return replace(routes, unvisited=why)
    for vehicle in vehicles:  # no UAV that goes there and back goes by others
        vehicle.price[doubted, : work.targets] = vehicle.price[: work.targets, doubted] = math.inf
    told = retold(vehicles, work, routes, options.criterion)
    return routes if told is None else replace(routes, unvisited=told.unvisited)


def _recut(scenario: Scenario, legs: TourLegs, work: Work, routes: Routes, options: TourOptions) -> Routes | None:
    """Return routes in the same order in other sorties, without the targets for which nothing is left."""
    for _ in range(MOST_ROUNDS):
        vehicles = legs.vehicles(work.stay, options.only)
        tours = [_cut(legs, work, own, tour) for own, tour in zip(vehicles, routes.tours, strict=True)]
        cut = replace(routes, tours=tuple(tours))
        if not legs.price(_wanted(scenario, cut)) or interrupted():
            return retold(vehicles, work, cut, options.criterion)
    return None


def _cut(legs: TourLegs, work: Work, vehicle: TourVehicle, tour: Tour) -> Tour:
    if not legs.lines:
        return stretches([vehicle], work, list(itertools.chain(*tour)))[0]
    from skyverse.mission.strip_routing import StripNodes

    return StripNodes.along(_strips(legs, work)).cut(vehicle, work, tour)


def _wanted(scenario: Scenario, routes: Routes) -> list[tuple[int, Ends]]:
    """Return the legs of routes, each with its UAV."""
    tours = enumerate(routes.tours)
    return [(uav, ends) for uav, tour in tours for ends in legs_of(tour, scenario.uavs[uav].end == "home")]


def _rank(routes: Routes, options: TourOptions) -> tuple[int, int, float]:
    value = routes.price if options.criterion == "min-sum" else routes.finish
    return len(routes.unvisited), routes.swaps, value


def _flight(scenario: Scenario, legs: TourLegs, uav: int, routes: Routes) -> TourFlight | None:
    """Return the flight of a UAV along its tour; ``None`` without one, or if rounds ended before all legs had one."""
    ends = legs_of(routes.tours[uav], scenario.uavs[uav].end == "home")
    sound = [one.trajectory for one in _legs(legs, uav, ends) if one.trajectory is not None]
    if not ends or len(sound) < len(ends):
        return None
    starts = iter(routes.starts[uav])
    departures = tuple(next(starts) if begin is None else 0.0 for begin, _ in ends)
    lines = tuple(legs.lines.get(one) for one in ends)
    return TourFlight(scenario, uav, tuple(sound), tuple(end for _, end in ends), departures, lines)


def _legs(legs: TourLegs, uav: int, ends: Sequence[Ends]) -> list[Leg]:
    """Return the legs of a UAV that were planned."""
    return [leg for one in ends if (leg := legs.leg(uav, one)) is not None]


def _ends(flight: TourFlight) -> list[Ends]:
    return [*zip((None, *flight.ends), flight.ends, strict=False)]


def _flown(mission: Mission, flights: Sequence[TourFlight | None]) -> Mission:
    """Return a mission with the trajectories and sorties of flights."""
    visited = [[end for end in flight.ends if end is not None] if flight else [] for flight in flights]
    return replace(
        mission,
        assignment=tuple(own[-1] if own else None for own in visited),
        trajectories=tuple(None if flight is None else flight.trajectory for flight in flights),
        sorties=tuple(() if flight is None else flight.sorties for flight in flights),
    )
