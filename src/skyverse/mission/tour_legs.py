"""The legs of tours, between starts and targets: priced roughly first, and exactly where they decide."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.cost import terms_of_path
from skyverse.mission.assignment import lattice_prices, straight_line
from skyverse.mission.leg_planning import Ends, Leg, LegPlanner, LegPlanning
from skyverse.mission.routing import Tour, TourVehicle
from skyverse.mission.tour_flight import half_turn_seconds, swap_seconds, turning_seconds
from skyverse.model.result import Effort, Result, Status, no_history
from skyverse.model.scenario import Scenario
from skyverse.model.take_off import landing, take_off
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.wind import WindBall, good_speed
from skyverse.numerics.side_by_side import side_by_side
from skyverse.numerics.tolerances import LENGTH_ROUNDING, MIN_SEGMENT
from skyverse.planners.base import DirectPlanner, Planner
from skyverse.problem import Airspace
from skyverse.referee import energy_bounds
from skyverse.survey.lines import PhotoLine
from skyverse.trajectory import least_ways

SPEED_SHARES = (0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0)
"""Shares of the speed that a UAV makes good, of which that is taken which needs the least energy."""
Key = tuple[int, tuple[float, float, float] | None, Ends]
"""Of a leg: the number of the UAV's kind, the UAV's start where that is an end of the leg, and its ends."""


@dataclass(eq=False)
class TourLegs:
    """The legs between all places of a scenario, for each of its UAVs.

    Prices are lower bounds until a leg is planned: on the lattice they are exact from the start, else those of straight
    lines. A tour that is best by lower bounds, and all of whose legs are planned, is best.

    Attributes
    ----------
    airspace, how
        What is flown in, and how legs are planned.
    timed
        Whether the seconds of legs are their prices, since wind, batteries or windows make them what counts.
    lines
        Of surveys: what is flown between two targets that are the ends of a photo line, in the direction of the leg.
    """

    airspace: Airspace
    how: LegPlanning
    timed: bool
    lines: Mapping[Ends, PhotoLine] = field(default_factory=dict)
    _planned: dict[Key, Leg] = field(default_factory=dict)
    _rough: dict[Key, tuple[Floats, Floats, Floats]] = field(default_factory=dict)
    _lattice: dict[Key, Floats] = field(default_factory=dict)
    _hover: dict[tuple[int, tuple[float, float, float]], float] = field(default_factory=dict)

    @cached_property
    def _planner(self) -> LegPlanner:
        return LegPlanner(self.airspace, self.how, self.lines)

    def vehicles(self, stay: Floats, only: tuple[int | None, ...] | None) -> list[TourVehicle]:
        """Return the numbers of all UAVs among the targets, at which they stay so many seconds, (n,), for routing.

        Where there is `only` one target that each UAV may visit, all others are closed to it.
        """
        count = len(self.airspace.scenario.uavs)
        return [self._vehicle(uav, stay, None if only is None else only[uav], only is None) for uav in range(count)]

    def _vehicle(self, uav: int, stay: Floats, only: int | None, any_target: bool) -> TourVehicle:
        scenario = self.airspace.scenario
        own, targets = scenario.uavs[uav], scenario.targets
        price, seconds, joules = (matrix.copy() for matrix in self._rough_numbers(uav))
        for (kind, start, ends), leg in self._planned.items():
            if self._key(uav, ends) == (kind, start, ends):
                cell = self._cell(ends)
                price[cell] = leg.result.cost if leg.trajectory is not None else math.inf
                seconds[cell], joules[cell] = leg.seconds, leg.joules
        hover = np.array([self._standing(uav, target.position) for target in targets])
        if own.fixed_wing is None:  # what the nose has not turned on the way to a line is waited for where that begins
            at = self._ends_of_lines
            held = np.maximum(half_turn_seconds(own) - seconds, 0.0) * ~self._along_lines
            seconds[:, at] += held[:, at]
            joules[:, at] += held[:, at] * hover[at]
        turns = np.array([turning_seconds(own, target) for target in targets])  # before each stay, and after it
        seconds += np.r_[turns, 0.0, 0.0] + np.r_[turns, 0.0, 0.0][:, None]
        np.fill_diagonal(price, 0.0)
        allowed = [not target.uavs or own.name in target.uavs for target in targets]
        return TourVehicle(
            price=seconds if self.timed else price,
            seconds=np.where(np.isfinite(price), seconds, math.inf),
            joules=joules,
            visit_joules=hover * (stay + 2.0 * turns),
            usable=self._usable(uav),
            most_sorties=1 if own.fixed_wing else len(targets) + 1 if own.batteries is None else own.batteries,
            swap=swap_seconds(scenario, uav),
            capacity=math.inf if own.capacity is None else own.capacity * (1.0 + LENGTH_ROUNDING),
            allowed=np.array(allowed, dtype=np.bool_) & (any_target | (np.arange(len(targets)) == only)),
            returns=own.end == "home",
            waiting=float(hover.max(initial=0.0)),
        )

    def price(self, wanted: Iterable[tuple[int, Ends]]) -> bool:
        """Price legs of UAVs that are not priced yet, and tell whether there was any."""
        keys = {self._key(uav, ends): (uav, ends) for uav, ends in wanted}
        new = {key: one for key, one in keys.items() if key not in self._planned}
        self._plan(new, self.how.pricer, self.how.workers)
        return bool(new)

    def finish(self, wanted: Iterable[tuple[int, Ends]]) -> None:
        """Plan legs that were priced by another planner."""
        if self.how.pricer != self.how.planner:
            keys = {self._key(uav, ends): (uav, ends) for uav, ends in wanted}
            self._plan(keys, self.how.planner, self.how.workers if isinstance(self.how.planner, DirectPlanner) else 1)

    def _plan(self, wanted: dict[Key, tuple[int, Ends]], planner: Planner, workers: int) -> None:
        legs = [*wanted.values()]

        def planned(k: int) -> Leg:
            return self._planner.leg(*legs[k], planner)

        self._planned.update(zip(wanted, side_by_side(planned, len(legs), workers), strict=False))

    def leg(self, uav: int, ends: Ends) -> Leg | None:
        """Return a leg that was planned, ``None`` if an interruption came before its turn."""
        return self._planned.get(self._key(uav, ends))

    @cached_property
    def _ends_of_lines(self) -> Ints:
        return np.unique(np.array([place for ends in self.lines for place in ends], dtype=np.int64))

    @cached_property
    def _along_lines(self) -> Bools:
        """Which legs, (n + 2, n + 2), are lines."""
        along = np.zeros((len(self.airspace.scenario.targets) + 2,) * 2, dtype=np.bool_)
        for ends in self.lines:
            along[self._cell(ends)] = True
        return along

    def _usable(self, uav: int) -> float:
        """Return what one battery gives for a sortie, J, without its take-off and the dearest landing."""
        scenario, own = self.airspace.scenario, self.airspace.scenario.uavs[uav]
        if own.usable_energy is None:
            return math.inf
        may = [one.position for one in scenario.targets if own.end != "home" and own.name in (one.uavs or (own.name,))]
        ends = [own.start, *may]
        dearest = max(landing(scenario, uav, place).joules for place in ends)
        return max(own.usable_energy - take_off(scenario, uav, own.start).joules - dearest, 0.0)

    def _standing(self, uav: int, place: tuple[float, float, float]) -> float:
        """Return the most that a UAV takes while it stands in the air, W; 0 without a battery."""
        if self.airspace.scenario.uavs[uav].usable_energy is None:
            return 0.0
        key = self._planner.kinds[uav], place
        if key not in self._hover:
            stands = Trajectory(np.array([0.0, 1.0]), np.array([[place]]))
            self._hover[key] = float(energy_bounds(self.airspace.scenario, uav, stands, 0.0, 1.0)[1][-1])
        return self._hover[key]

    def _rough_numbers(self, uav: int) -> tuple[Floats, Floats, Floats]:
        """Return lower bounds of prices, seconds and joules, (n + 2, n + 2) each, as `TourVehicle` has them."""
        key = self._key(uav, (None, None))
        if key in self._rough:
            return self._rough[key]
        scenario = self.airspace.scenario
        own, vehicle = self.airspace.of(uav), scenario.uavs[uav]
        places = np.array([target.position for target in scenario.targets]).reshape(-1, 3)
        home = np.array([vehicle.start])
        everywhere = np.vstack([places, home, home])
        price = own.rates.metre * straight_line(everywhere, everywhere)
        if not self.how.pricer.leaves_lattice(scenario):
            among = self._key(uav, (0, 0))  # the same for all UAVs of a kind, wherever they start
            if among not in self._lattice:
                self._lattice[among] = lattice_prices(own, uav, places, places, self.how.workers)
            price = _bordered(self._lattice[among], lattice_prices(own, uav, home, places)[0])
        seconds = least_times(vehicle, scenario.winds, everywhere)
        if vehicle.fixed_wing is not None:
            out, into = (
                np.column_stack([everywhere[:, :2], [known.get(k, math.nan) for k in range(len(everywhere))]])
                for known in self._planner.headings
            )
            seconds = least_ways(out, into, vehicle) / vehicle.fixed_wing.speed
        self._rough[key] = price, seconds, least_joules(scenario, uav, everywhere)
        return self._rough[key]

    def _key(self, uav: int, ends: Ends) -> Key:
        """Return what UAVs have in common that fly a leg alike: their kind, and their start where it matters."""
        start = self.airspace.scenario.uavs[uav].start if None in ends else None
        return self._planner.kinds[uav], start, ends

    def _cell(self, ends: Ends) -> tuple[Ints, Ints] | tuple[slice | int, slice | int]:
        """Return where a leg stands in matrices whose last two rows and columns are those of the UAV's start."""
        n = len(self.airspace.scenario.targets)
        a, b = (slice(n, n + 2) if end is None else end for end in ends)
        return a, b


def least_times(uav: UAV, winds: WindBall, places: Floats) -> Floats:
    """Return seconds (n, n) that no flight between places (n, 3), metres, at rest at both, goes below."""
    ways = places - places[:, None]
    apart = np.linalg.norm(ways, axis=2)
    unit = ways / np.maximum(apart, MIN_SEGMENT)[..., None]
    most = good_speed(uav, winds, unit.reshape(-1, 3)).reshape(apart.shape)
    fast = apart * uav.max_acceleration >= most**2
    gathering = 2.0 * np.sqrt(apart / uav.max_acceleration)
    upright = np.maximum(ways[..., 2] / (uav.max_climb or np.inf), -ways[..., 2] / (uav.max_descent or np.inf))
    flat = np.where(fast, apart / np.maximum(most, MIN_SEGMENT) + most / uav.max_acceleration, gathering)
    return np.maximum(flat, upright)


def least_joules(scenario: Scenario, uav: int, places: Floats) -> Floats:
    """Return about the least joules (n, n) of a UAV between places (n, 3), metres; none without a battery.

    They are those of a straight flight at the best of some speeds over ground, in the gusts of the scenario, and of
    gathering that speed and losing it at the least power of them all.
    """
    own, winds, count = scenario.uavs[uav], scenario.winds, len(places)
    power = own.power_model
    if power is None or own.usable_energy is None:
        return np.zeros((count, count))
    gust = 0.0 if scenario.wind is None else scenario.wind.gust
    ways = (places - places[:, None]).reshape(-1, 3)
    apart = np.linalg.norm(ways, axis=1)
    unit = ways / np.maximum(apart, MIN_SEGMENT)[:, None]
    speeds = np.array(SPEED_SHARES)[:, None] * np.maximum(good_speed(own, winds, unit), MIN_SEGMENT)
    through = speeds[..., None] * unit - np.array(winds.velocity)
    level = np.maximum(np.linalg.norm(through[..., :2], axis=2) - (winds.radius - gust), 0.0)
    watts = np.stack(
        [
            power.most(flat, flat, rise - (winds.radius - gust), np.ones(1), gust)
            for flat, rise in zip(level, through[..., 2], strict=True)
        ]
    )
    speeds = np.minimum(speeds, np.sqrt(apart * own.max_acceleration))  # no more is gathered on the way
    ramps = watts.min(axis=0) * speeds / own.max_acceleration
    least = (watts * apart / np.maximum(speeds, MIN_SEGMENT) + ramps).min(axis=0)
    return np.asarray(least.reshape(count, count))


def _bordered(among: Floats, outwards: Floats) -> Floats:
    """Return the numbers between targets, (n, n), with those from and to the start, (n,), as the last two places."""
    numbers = np.pad(among, (0, 2))
    numbers[-2:, :-2] = outwards
    numbers[:-2, -2:] = outwards[:, None]
    return numbers


def legs_of(tour: Tour, returns: bool) -> list[Ends]:
    """Return the legs of a tour, through all of its sorties; every sortie but the last ends at home."""
    legs: list[Ends] = []
    for number, sortie in enumerate(tour, 1):
        places: list[int | None] = [None, *sortie]
        places += [None] if returns or number < len(tour) else []
        legs += pairwise(places)
    return legs


def joined_result(airspace: Airspace, legs: list[Result]) -> Result:
    """Return the results of a tour's legs as one, whose path leads through all of its targets.

    What the legs cost at least says nothing of other orders: a tour of several legs has no bound.
    """
    if len(legs) == 1:
        return legs[0]
    first, last = legs[0], legs[-1]
    path = legs[0].path
    for leg in legs[1:]:
        again = len(leg.path) > 0 and np.array_equal(path[-1], leg.path[0])
        path = np.vstack([path, leg.path[int(again) :]])
    any_angle = any(leg.any_angle for leg in legs)
    terms = terms_of_path(airspace.scenario, airspace.rates, path, last.goal, any_angle=any_angle)
    price = sum(terms.values())
    return Result(
        Status.COMPLETE,
        path,
        price,
        terms,
        None,
        first.start,
        last.goal,
        sum((leg.effort for leg in legs), Effort()),
        sum(leg.seconds for leg in legs),
        no_history(),
        last.stopped_by,
        first.provenance,
        any_angle,
        objective=first.objective,
    )
