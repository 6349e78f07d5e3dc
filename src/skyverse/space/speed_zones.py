"""Zones with a speed limit, for whoever plans: where a UAV that strays may be inside one, and whether it is too fast.

A trajectory is proven piece by piece: where its speed, which is nowhere above the norms of its Bernstein coefficients,
is within the limit, or where the box around the coefficients of its position is outside the zone. Otherwise it is
halved.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.numerics.bernstein import to_bernstein
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.space import solids
from skyverse.space.solids import Solids, make_solids
from skyverse.space.voxels import parts_of

BISECTIONS = 40
"""Halvings by which the place is found at which a leg enters or leaves a zone."""


class SpeedZone(NamedTuple):
    """A zone in which no UAV may fly faster than its limit.

    Attributes
    ----------
    number
        Its number among the scenario's zones.
    max_speed
        m/s.
    solids
        What it consists of, made higher for the vertical tracking error.
    growth
        Metres by which the horizontal tracking error grows it.
    """

    number: int
    max_speed: float
    solids: Solids
    growth: float

    def holds(self, p: Floats) -> bool:
        """Tell whether a UAV at a nominal position (3,) may be inside."""
        return bool(solids.containing(self.solids, self.growth, p[0], p[1], p[2]) >= 0)

    def reaches(self, low: Floats, high: Floats) -> bool:
        """Tell whether the zone reaches into the box between two corners, (3,) each."""
        return bool(solids.reaching(self.solids, self.growth, low, high) >= 0)

    def crossed(self, a: Floats, b: Floats, margin: float = 0.0) -> bool:
        """Tell whether a segment comes nearer to the zone than `margin` metres, or into it."""
        return bool(solids.crossed(self.solids, self.growth + margin, a, b) >= 0)

    def stretch(self, a: Floats, b: Floats, margin: float) -> tuple[float, float] | None:
        """Return the shares of a segment between which it is inside the zone or within `margin` of it, or ``None``."""
        if not self.crossed(a, b, margin):
            return None
        ends = []
        for begin, end in ((a, b), (b, a)):
            clear, met = 0.0, 1.0
            for _ in range(BISECTIONS):
                middle = 0.5 * (clear + met)
                if self.crossed(begin, begin + middle * (end - begin), margin):
                    met = middle
                else:
                    clear = middle
            ends.append(clear)
        return ends[0], 1.0 - ends[1]


def make_speed_zones(scenario: Scenario, error: TrackingError) -> tuple[SpeedZone, ...]:
    """Return the zones of a scenario that have a speed limit at all times, for UAVs with a tracking error."""
    made = []
    for number, zone in enumerate(scenario.zones):
        if zone.max_speed is not None and zone.active is None:
            parts = make_solids(parts_of(zone), error)[0]
            made.append(SpeedZone(number, zone.max_speed, parts, error.horizontal))
    return tuple(made)


def seconds_lost(zones: Sequence[SpeedZone], speed: float, place: Floats, points: Floats) -> float:
    """Return by about how many seconds zones' limits make a way longer that is otherwise flown at one speed.

    Parameters
    ----------
    zones
        With their limits.
    speed
        M/s, outside of zones.
    place, points
        (3,) and (n, 3) metres: where the way begins, and its points.
    """
    lost = 0.0
    for zone in zones:
        if zone.max_speed >= speed:
            continue
        for a, b in pairwise([place, *points]):
            within = zone.stretch(a, b, 0.0)
            if within is not None:
                inside = (within[1] - within[0]) * math.dist(b, a)
                lost += inside * (1.0 / zone.max_speed - 1.0 / speed)
    return lost


MAX_DEPTH = 40
"""How often a piece is halved at most, each time one of the halves again."""


def first_too_fast(zones: Sequence[SpeedZone], trajectory: Trajectory) -> float | None:
    """Return an instant at which it is not proven that a trajectory keeps zones' speed limits, s, or ``None``."""
    for k, duration in enumerate(np.diff(trajectory.knots)):
        if not zones:
            break
        rows = trajectory.coefficients[k].copy()
        rates = rows[1:] * np.arange(1.0, len(rows))[:, None] if len(rows) > 1 else np.zeros((1, 3))
        place, velocity = to_bernstein(rows, duration), to_bernstein(rates, duration)
        for zone in zones:
            share = _first_share(zone, place, velocity)
            if share is not None:
                return float(trajectory.knots[k] + share * duration)
    return None


def _first_share(zone: SpeedZone, place: Floats, velocity: Floats) -> float | None:
    """Return the share of a piece at which it is not proven to keep a zone's limit, or ``None``."""
    most = zone.max_speed * (1.0 + LIMIT_EASE)
    waiting = [(place, velocity, 0.0, 0)]
    while waiting:
        b, v, begin, depth = waiting.pop()
        if np.linalg.norm(v, axis=1).max() <= most or not zone.reaches(b.min(axis=0), b.max(axis=0)):
            continue
        if depth == MAX_DEPTH or (math.hypot(*v[0]) > most and zone.holds(b[0])):
            return begin
        (b, beyond), (v, later) = _halves(b), _halves(v)
        waiting += [(beyond, later, begin + 0.5 ** (depth + 1), depth + 1), (b, v, begin, depth + 1)]
    return None


def _halves(b: Floats) -> tuple[Floats, Floats]:
    """Return the coefficients of both halves of a piece, (n, 3) each, by de Casteljau's algorithm."""
    left, right = b.copy(), b.copy()
    for k in range(1, len(b)):
        b = (b[1:] + b[:-1]) / 2
        left[k], right[-1 - k] = b[0], b[-1]
    return left, right
