"""Parts of a flight: where a UAV may be called back."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats, Indices
from skyverse.exports.flight_plan import FlightPlan
from skyverse.exports.leg_geometry import greatest_on_legs, ground_under, leg_deviation, towards
from skyverse.model.quantities import derived
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Terrain
from skyverse.numerics.tolerances import MAVLINK_ROUNDING, SAME_PLACE

HALVINGS = 40
"""How often a leg's time is halved to find when the flight is at a place of it."""


class Parts(NamedTuple):
    """Parts of a flight: quadrilaterals, since a leg may be begun anywhere between its waypoint and the cut before it.

    Attributes
    ----------
    leg
        (n,) indices of legs.
    shares
        (n, 2) of the leg's length at which a part begins and ends.
    corners
        (n, 2, 2, 3) metres: where it begins and ends, on the leg from the waypoint and on that from the cut's far end.
    """

    leg: Indices
    shares: Floats
    corners: Floats

    def of(self, some: NDArray[np.bool_] | Indices) -> "Parts":
        """Return some of the parts."""
        return Parts._make(column[some] for column in self)

    @property
    def middle(self) -> Floats:
        """(n, 3) metres."""
        return np.asarray(self.corners.mean(axis=(1, 2)))

    @property
    def box(self) -> tuple[Floats, Floats]:
        """The least and the greatest corner, (n, 3) metres each."""
        return self.corners.min(axis=(1, 2)), self.corners.max(axis=(1, 2))

    @property
    def radius(self) -> Floats:
        """(n,) metres from the middle to the farthest place, seen from above."""
        off = (self.corners - self.middle[:, None, None])[..., :2]
        return np.asarray(np.hypot(off[..., 0], off[..., 1]).max(axis=(1, 2)))

    @property
    def sizes(self) -> tuple[Floats, Floats]:
        """(n,) metres: how long and how wide the parts are."""
        along = np.linalg.norm(self.corners[:, 1] - self.corners[:, 0], axis=2).max(axis=1)
        across = np.linalg.norm(self.corners[:, :, 1] - self.corners[:, :, 0], axis=2).max(axis=1)
        return np.asarray(along), np.asarray(across)

    @property
    def points(self) -> "Parts":
        """The middles of the parts, as parts without size."""
        return self._replace(corners=np.broadcast_to(self.middle[:, None, None], self.corners.shape))

    def halved(self) -> "Parts":
        """Return both halves of each part, cut where it is longer."""
        along, across = self.sizes
        wide = (across > along)[:, None, None, None]
        sides = np.where(wide, self.corners.swapaxes(1, 2), self.corners)
        halves = []
        for side in (0, 1):
            half = sides.copy()
            half[:, 1 - side] = sides.mean(axis=1)
            shares = self.shares.copy()
            shares[:, 1 - side] = np.where(across > along, shares[:, 1 - side], shares.mean(axis=1))
            halves.append(Parts(self.leg, shares, np.where(wide, half.swapaxes(1, 2), half)))
        return joined_parts(halves)


def joined_parts(each: list[Parts]) -> Parts:
    """Return all parts of several."""
    return Parts._make(np.concatenate(columns) for columns in zip(*each, strict=True))


@dataclass(frozen=True, eq=False)
class FlightLegs:
    """The legs of one UAV's flight from its first waypoint to its end, a landing included.

    A return during the take-off is one from its end: it uses the same lines.

    Attributes
    ----------
    plan
        The flight.
    sides
        (m, 2, 2, 3) metres: the legs as `corners` of `Parts`.
    width
        (m,) metres by which the UAV may be off the line of a cut at the beginning of its leg.
    aside, rise
        (m,) metres by which the UAV may be beside a leg, and above or below it.
    terrain, above
        The ground, and the heights above it, (m, 2) metres, between which legs that follow it lead; NaN for all others.
    """

    plan: FlightPlan
    sides: Floats
    width: Floats
    aside: Floats
    rise: Floats
    terrain: Terrain | None
    above: Floats

    def off(self, parts: Parts) -> Floats:
        """Return how far beside parts the UAV may be without straying, (n,) metres."""
        return self.aside[parts.leg] + self._width(parts)

    def _width(self, parts: Parts) -> Floats:
        return np.asarray((1 - parts.shares[:, 0]) * self.width[parts.leg])

    def heights(self, parts: Parts) -> tuple[Floats, Floats]:
        """Return the least and the greatest z at which the UAV may be on parts without straying, (n,) metres each."""
        (low, high), rise = parts.box, self.rise[parts.leg] + self._width(parts)
        bottom, top = low[:, 2], high[:, 2]
        above = self.above[parts.leg]
        some = np.flatnonzero(np.isfinite(above[:, 0]))
        if self.terrain is not None and len(some):
            lines, first = parts.corners[some, :, 0].copy(), above[some, :1]
            lines[..., 2] = first + parts.shares[some] * (above[some, 1:] - first)
            upside = derived(self.terrain, heights=-self.terrain.heights, lowest=None)
            bottom[some] = -greatest_on_legs(lines * [1.0, 1.0, -1.0], self.terrain.lowest_ground, -np.inf)
            top[some] = greatest_on_legs(lines, upside, -np.inf)
        return bottom - rise, top + rise

    def parts(self, longest: float) -> Parts:
        """Return parts of all legs that are no longer than `longest` metres."""
        lengths = np.linalg.norm(self.sides[:, 1] - self.sides[:, 0], axis=2).max(axis=1)
        counts = np.maximum(np.ceil(lengths / longest).astype(int), 1)
        leg = np.repeat(np.arange(len(counts)), counts)
        begin = np.concatenate([np.arange(count) / count for count in counts])
        shares = np.column_stack([begin, begin + 1 / counts[leg]])
        first, last = self.sides[leg, :1], self.sides[leg, 1:]
        return Parts(leg, shares, first + shares[:, :, None, None] * (last - first))

    def samples(self, count: int) -> Parts:
        """Return at least so many places of the flight as parts without size, the last one its end."""
        lengths = np.linalg.norm(self.sides[:, 1] - self.sides[:, 0], axis=2).max(axis=1)
        spread = self.parts(max(float(lengths.sum()) / count, MAVLINK_ROUNDING))
        last = spread.of(np.array([len(spread.leg) - 1]))
        end = last._replace(shares=np.ones((1, 2)), corners=np.broadcast_to(last.corners[:, 1:, :1], (1, 2, 2, 3)))
        return joined_parts([spread.points, end])

    def seconds(self, parts: Parts) -> Floats:
        """Return between which seconds into the mission parts are flown, (n, 2).

        A part at the end of the take-off counts from its beginning.
        """
        arrivals, flight = self.plan.arrivals, self.plan.predicted()
        last = np.append(arrivals, arrivals[-1])[parts.leg + 1]
        early, late = (np.repeat(times[:, None], 2, axis=1) for times in (arrivals[parts.leg], last))
        start = self.sides[parts.leg, 0, 0][:, None]
        along = self.sides[parts.leg, 1, 0][:, None] - start
        squared = (along**2).sum(axis=2)
        passed = parts.shares * squared - SAME_PLACE * np.sqrt(squared)  # a stop at its beginning belongs to a leg
        for _ in range(HALVINGS):
            middle = (early + late) / 2
            position = flight.at(middle.ravel()).position.reshape(-1, 2, 3)
            before = ((position - start) * along).sum(axis=2) < passed
            early, late = np.where(before, middle, early), np.where(before, late, middle)
        found = np.where(parts.shares < 1.0, late, last[:, None])
        found[(parts.leg == 0) & (parts.shares[:, 0] == 0), 0] = self.plan.begin
        return found


def flown_legs(plan: FlightPlan, scenario: Scenario, low: float) -> FlightLegs:
    """Return the legs of a flight plan; one that ends with a landing goes down to z = `low`, metres."""
    points, terrain, over = plan.waypoints, scenario.terrain, plan.route.over_ground
    cut, width = _cut_corners(plan)
    aside = MAVLINK_ROUNDING + leg_deviation(scenario, np.linalg.norm(np.diff(points, axis=0), axis=1))
    rise, above = plan.route.deviations.copy(), np.full((len(aside), 2), np.nan)
    for k in np.flatnonzero(np.isfinite(over)):
        assert terrain is not None
        ends = points[k : k + 2]
        strays, aside[k] = scenario.uavs[plan.route.uav].tracking_error.horizontal, aside[k] + over[k]
        slope = ground_under(terrain, ends, aside[k] + strays).slope
        # within the radius it is as much higher or lower, and so may the ground be both there and here
        rise[k] = math.hypot(aside[k], 2 * slope * aside[k]) + slope * strays
        above[k], cut[k], width[k] = ends[:, 2] - terrain.height(ends[:, :2]), 0.0, 0.0
    if len(plan.ending) == 1:
        landed = np.array([*plan.ending[0][:2], min(low, points[-1][2])])
        points, cut = np.concatenate([points, landed[None]]), np.concatenate([cut, np.zeros((1, 3))])
        aside, rise = np.r_[aside, MAVLINK_ROUNDING], np.r_[rise, MAVLINK_ROUNDING]
        width, above = np.r_[width, 0.0], np.concatenate([above, np.full((1, 2), np.nan)])
    begins = np.stack([points[:-1], points[:-1] + cut], axis=1)
    sides = np.stack([begins, np.repeat(points[1:, None], 2, axis=1)], axis=1)
    return FlightLegs(plan, sides, width, aside, rise, terrain, above)


def _cut_corners(plan: FlightPlan) -> tuple[Floats, Floats]:
    """Return the vector to the far end of each leg's cut, (m, 3) metres, and how far beside that line it may be, (m,).

    A UAV turns to a leg at its first waypoint, or up to the radius before it, on the leg before or on the way to that
    from where it turned to it: in a triangle of the waypoint and two places p and q before it. To its first leg it may
    turn before the end of the take-off.
    """
    points, stops, radii = plan.waypoints, plan.full_stops, plan.route.waypoint_radii
    cut, width = np.zeros((len(points) - 1, 3)), np.zeros(len(points) - 1)
    below = towards(plan.home - points[0], plan.takeoff_cut)
    cut[:1] = below
    for k in range(1, len(points) - 1):
        if stops[k]:
            continue
        before, at, radius = points[k - 1], points[k], float(radii[k])
        entered = before + below if k == 1 else before
        if k > 1 and not stops[k - 1]:
            entered = before + towards(points[k - 2] - before, float(radii[k - 1]))
        p, q = towards(before - at, radius), towards(entered - at, radius)
        cut[k] = (p + q) / 2
        width[k] = math.dist(p, q) / 2
    return cut, width
