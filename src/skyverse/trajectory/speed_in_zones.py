"""The planners' own proof that a trajectory keeps the speed limits of zones at every instant.

A piece is proven where its speed, which is nowhere above the norms of its Bernstein coefficients, is within the limit,
or where the box around the coefficients of its position is outside the zone. Otherwise it is halved.
"""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.model.trajectory import Trajectory
from skyverse.numerics.bernstein import to_bernstein
from skyverse.numerics.tolerances import LIMIT_EASE
from skyverse.space.speed_zones import SpeedZone

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
