"""The way home: whether a UAV that returns by itself, at any instant of its flight, meets anything on its way.

An autopilot that returns climbs to its return altitude, unless it is higher already, flies straight to its destination
and descends there. The flight is cut into parts. For the middle of each part the climb, the straight line and the
descent are checked, with a clearance that grows by half the part's size, so that they hold for all instants of the
part; parts that fail are halved.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.flown_legs import Parts, Spread, flown_legs, joined_parts
from skyverse.exports.global_positions import home
from skyverse.exports.leg_deviation import leg_deviation
from skyverse.exports.level_roofs import SurfacesNear
from skyverse.exports.part_lines import Deviation, PartLines
from skyverse.exports.return_destinations import ACCEPTANCE, Destination, may_be_taken, return_levels
from skyverse.exports.return_lines import Ground, ReturnLines, ReturnSpace, joined, single
from skyverse.model.scenario import Scenario
from skyverse.numerics.tolerances import LEG_ALLOWANCE, MAVLINK_ROUNDING, SAME_PLACE

LARGEST_PART = 16.0
"""Metres: half the length of the longest part of a flight that is checked at once."""
SMALLEST_PART = 0.05
"""Metres: half the length of the shortest part; what then fails has no way home."""
SMALLEST_OF_MANY, MANY_PARTS = 0.2, 6000
"""Metres: the same where more parts than so many fail at once."""
CUT_SHARE = 2.5
"""A part is halved across the cut of a corner only above so many times the smallest size: few corners are cut.

That of the take-off, on the first leg, is halved down to the smallest size itself.
"""
SMALLEST_LOST = 0.5
"""Metres: the same where the way home is blocked from the middle of the part."""
TRIED_PLACES = 64
"""Places of a flight from which an altitude is tried before it is searched."""
NEAR_HOME = 50.0
"""Metres from home within which a DJI aircraft returns without a climb, as its manual says; both are checked there."""
LANDS_AT_ONCE, SURELY_LANDS = 5.0, 4.5
"""Metres from home within which a DJI aircraft lands where it is, and within which it does so however it reckons."""


class Found(NamedTuple):
    """The parts of a flight without a way home, and the lines that prove the way home of all others."""

    lost: Parts
    lines: ReturnLines


class WayHome:
    """Checks the return of one UAV at one return altitude, to each of some destinations that its autopilot may choose.

    Parameters
    ----------
    scenario, space
        The scenario, and what returning UAVs keep clear of.
    plan
        The flight.
    destinations
        Where it may land, home first.
    end
        Where the flight ends, as a place to land at.
    altitude
        The return altitude, metres above home.
    """

    def __init__(
        self,
        scenario: Scenario,
        space: ReturnSpace,
        plan: FlightPlan,
        destinations: Sequence[Destination],
        end: Destination,
        altitude: float,
    ) -> None:
        self.scenario, self.space, self.plan = scenario, space, plan
        self.destinations, self.end, self.altitude = tuple(destinations), end, altitude
        self.legs = flown_legs(plan, scenario, end.low)
        self.places = np.array([one.place for one in destinations])
        self.levels = return_levels(scenario, plan, self.places, altitude)
        self.column = np.array([one.column for one in destinations])
        self.climb = np.array([one.climb for one in destinations])
        self.below = np.array([(one.column, one.low, one.bottom, one.roof) for one in destinations])
        self.error = scenario.uavs[plan.route.uav].tracking_error

    def at(self, altitude: float) -> "WayHome":
        """Return the way home at another altitude, metres above home."""
        return WayHome(self.scenario, self.space, self.plan, self.destinations, self.end, altitude)

    def search(self, *, to_the_end: bool = True) -> Found:
        """Return the parts of the flight without a way home, and the lines that prove the way home of all others.

        A search that does not go `to_the_end` ends with the first parts without a way home, and has not found all.
        """
        todo = self.legs.whole(2 * LARGEST_PART)
        lost, proof = [todo.of(np.zeros(0, dtype=np.intp))], []
        while len(todo.leg):
            lines, part = self.lines(todo)
            safe = self.space.free(lines, self.error)
            free = np.ones(len(todo.leg), dtype=np.bool_)
            np.logical_and.at(free, part, safe)
            proof.append(lines.of(free[part]))
            hopeless = self._hopeless(lines.of(~safe), part[~safe], len(free))
            smallest = SMALLEST_PART if (~free).sum() <= MANY_PARTS else SMALLEST_OF_MANY
            left, across = self._larger(todo, np.where(hopeless, SMALLEST_LOST, smallest))
            lost.append(todo.of(~free & ~left))
            if not to_the_end and len(lost[-1].leg):
                break
            todo = todo.of(~free & left).halved(across[~free & left])
        return Found(joined_parts(lost), joined(proof))

    def _larger(self, parts: Parts, smallest: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Tell which parts are larger than half sizes (n,), and whether they are to be cut across."""
        along, across = self.legs.halvable(parts)
        across = np.where(across > np.where(parts.leg == 0, 1.0, CUT_SHARE) * smallest, across, 0.0)
        return np.maximum(along, across) > smallest, across > along

    def halved(self, parts: Parts, smallest: float) -> Parts | None:
        """Return the halves of some parts; ``None`` if one is smaller than half a size already, metres."""
        larger, across = self._larger(parts, np.full(len(parts.leg), smallest))
        return parts.halved(across) if larger.all() else None

    def blocked(self, parts: Parts | None = None) -> int:
        """Return from how many parts, or places spread evenly over the flight, the way home meets something."""
        return int(self._blocked(self.legs.samples(TRIED_PLACES) if parts is None else parts).sum())

    def blocked_weight(self) -> int:
        """Return the same of those places, and as many more if the way home from the end of the flight is blocked."""
        blocked = self._blocked(joined_parts([self.legs.samples(TRIED_PLACES), self.legs.last_place()]))
        return int(blocked[:-1].sum() + TRIED_PLACES * blocked[-1])

    def _blocked(self, parts: Parts) -> NDArray[np.bool_]:
        lines, part = self.lines(parts)
        return self._hopeless(lines, part, len(parts.leg))

    def can_climb(self, parts: Parts) -> bool:
        """Tell whether the climb is clear from any of some parts, so that another destination may help there."""
        lines, part = self.lines(parts)
        _, first = np.unique(part, return_index=True)  # a climb stands first
        return bool(self.space.free(lines.of(first), self.error).any())

    def _hopeless(self, lines: ReturnLines, part: NDArray[np.intp], count: int) -> NDArray[np.bool_]:
        """Tell for each of some parts whether its lines meet something even where they stand for themselves only."""
        found = np.zeros(count, dtype=np.bool_)
        found[part[~self.space.free(single(lines), self.error)]] = True
        return found

    def lines(self, parts: Parts) -> tuple[ReturnLines, NDArray[np.intp]]:
        """Return the lines that stand for the returns from parts of the flight, and the part of each line."""
        away, legs = self.away(parts), self.legs
        spread = legs.spread(parts)
        part, goal = np.nonzero(self.taken(away, sum(spread.level) + legs.off[parts.leg]))
        return self._lines(parts, spread, away[part, goal], part, goal, part)

    def taken(self, away: Floats, half: Floats) -> NDArray[np.bool_]:
        """Tell which destinations may be returned to, (n, k), by a UAV `half` (n,) metres off places so far `away`."""
        return may_be_taken(self.scenario, self.plan.autopilot, away, half + self.error.horizontal)

    def away(self, parts: Parts) -> Floats:
        """Return how far the middles of parts are from each destination, seen from above, (n, k) metres."""
        middle = self.legs.middles(parts)
        return np.asarray(np.linalg.norm(middle[:, None, :2] - self.places[None, :, :2], axis=2))

    def reaches(self, parts: Parts) -> NDArray[np.bool_]:
        """Tell whether the return from the middle of each part to each destination, (n, k), meets nothing."""
        count, goals = len(parts.leg), len(self.places)
        part, goal = np.divmod(np.arange(count * goals), goals)
        spread, away = self.legs.spread(parts), self.away(parts).ravel()
        lines, pair = self._lines(parts, spread, away, part, goal, np.arange(len(part)))
        return ~self._hopeless(lines, pair, len(part)).reshape(count, goals)

    def _lines(
        self,
        parts: Parts,
        spread: Spread,
        away: Floats,
        part: NDArray[np.intp],
        goal: NDArray[np.intp],
        named: NDArray[np.intp],
    ) -> tuple[ReturnLines, NDArray[np.intp]]:
        """Return the lines from some parts to destinations `away` metres, and the number by which each is `named`."""
        legs = self.legs
        middle, box = legs.middles(parts), legs.box(parts)
        off, rise = legs.off[parts.leg], legs.rise[parts.leg]
        half, aside, upright = (along + across for along, across in spread)
        half, aside = half + off, aside + off
        at, level = middle[part], self.levels[goal]
        over = self.places[goal].copy()
        more = leg_deviation(self.scenario, away + half[part] + self.error.horizontal)
        beside = MAVLINK_ROUNDING + more
        knows = (box[1][:, 2] + rise)[part] + self.error.vertical <= level  # it climbs to a level that it knows
        rounded = np.full(len(part), MAVLINK_ROUNDING)
        known = Deviation(half[part] + beside, aside[part] + more, rounded, off[part] + more, rounded)
        free = Deviation(*(column[part] + more for column in (half + rise, aside, upright + rise, off, rise)))
        top = np.maximum(at[:, 2], level)
        highest, lowest = (np.maximum(z, level) for z in ((box[1][:, 2] + rise)[part], (box[0][:, 2] - rise)[part]))
        flown = free._replace(above=np.maximum(highest - top, top - lowest))  # it flies home at its level or higher
        across = Deviation(*(np.where(knows, a, b) for a, b in zip(known, flown, strict=True)))
        lines = PartLines(named, box[0][part], box[1][part], self.error)
        column, roof = self._column(at, box[0][part, 2])
        foot, turn = at.copy(), at.copy()
        turn[:, 2] = over[:, 2] = top
        foot[:, 2] = np.clip(column, at[:, 2], top)
        every = np.ones(len(part), dtype=np.bool_)
        climb = across._replace(above=free.above)
        lines.add(foot, turn, climb, every, ground=Ground.NEAR, on_path=True)
        lines.add_in_column(at, foot, climb, foot[:, 2] > at[:, 2], roof, ground=Ground.NONE, on_path=True)
        radius, beneath = ACCEPTANCE[self.plan.autopilot.name]
        climbs = box[0][part, 2] - self.error.vertical < level
        lag = np.where(climbs, beneath / 2, 0.0)  # it goes on below the level, and climbs the rest on its way
        lower = np.column_stack([np.zeros((len(part), 2)), lag])
        lag = lag + np.where(knows, 0.0, self.error.vertical)  # it flies home as high as it is when it is called back
        lines.add(turn - lower, over - lower, across, every, on_path=True, lax=np.column_stack([0 * lag, lag]))
        above = np.maximum(over[:, 2], box[1][part, 2])
        below = self.below[goal].T
        vertical = Deviation(rounded, rounded, rounded, rounded, np.full(len(part), LEG_ALLOWANCE))
        lines.descend(over, above, below, vertical, every, lax=(radius, 0.0))
        if self.plan.autopilot.name == "dji":
            flat = over.copy()
            flat[:, 2] = at[:, 2]
            least = away - half[part] - self.error.horizontal  # it may be nearer to home than it is taken to be
            near = least <= NEAR_HOME
            near &= away + aside[part] + self.error.horizontal > SURELY_LANDS
            lines.add(at, flat, free, near, ground=Ground.NEAR, on_path=True, lax=(0.0, self.error.vertical))
            close = least <= LANDS_AT_ONCE
            around = free.aside + 2 * self.error.horizontal
            there = self.below[goal].T.copy()
            there[0] = self.climb[goal]
            there += self._lower(at, around, close)  # it lands on what is there, not at home
            lines.descend(at, box[1][part, 2], there, free, close, on_path=True)
        return lines.made()

    def _lower(self, places: Floats, aside: Floats, some: NDArray[np.bool_]) -> Floats:
        """Return how much the lowest surface about places (n, 3) is above home, (n,), below 0 if lower; all metres.

        Only `some` of the places are asked, and as far around them as a UAV may be `aside`, (n,), its error included.
        """
        asked = np.unique(np.column_stack([places, aside])[some], axis=0)
        lowest = {tuple(row): self._surfaces.lowest(row[:3], float(row[3])) for row in asked}
        lower = np.zeros(len(places))
        home = float(self.plan.home[2])
        lower[some] = [lowest[tuple(row)] - home for row in np.column_stack([places, aside])[some]]
        return lower

    @cached_property
    def _surfaces(self) -> SurfacesNear:
        """On what it may land at once."""
        floor = float(home(self.scenario, self.plan.route.uav)[2]) if self.scenario.terrain is None else None
        reach = LANDS_AT_ONCE + 3 * LARGEST_PART + 2 * self.error.horizontal
        return SurfacesNear(self.scenario, self.plan.home[:2], reach, floor)

    def _column(self, places: Floats, lowest: Floats) -> tuple[Floats, Floats]:
        """Return z up to which places are in the column over the own start or the flight's end, and its roof.

        `places` (n, 3) stand for parts of the flight that go down to `lowest`, (n,), metres.
        """
        top, roof = np.full((2, len(places)), -np.inf)
        for one in (self.destinations[0], self.end):
            held = (np.abs(places[:, :2] - one.place[:2]).max(axis=1) <= SAME_PLACE) & (one.climb > top)
            top[held] = one.climb
            roof[held] = np.where(lowest >= one.foot - SAME_PLACE, one.foot_roof, one.roof)[held]
        return top, roof
