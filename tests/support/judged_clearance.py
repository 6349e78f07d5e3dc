"""Worlds, curves and segments whose clearance the referee judges."""

import numpy as np

import skyverse as sky
from skyverse.referee.clearance import judge_curve, judge_segments
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.polynomial import bernstein
from skyverse.referee.world import referee_world

LET_PASS = 1e-6
ROUNDING = 1e-9


def world(*obstacles, clearance=0.25, terrain=None, size=10.0, floor=0.0):
    return sky.Scenario(
        name="world",
        bounds=sky.Bounds(min=(0, 0, floor), max=(size, size, floor + size)),
        obstacles=obstacles,
        clearance=clearance,
        lattice=sky.Lattice(step=(size / 10, size / 10, size / 10)),
        terrain=terrain,
    )


def of(knots, rows):
    return PolynomialCurve(np.array(knots, float), np.array(rows, float))


def straight(a, b, seconds=1.0):
    return of([0, seconds], [[a, (np.array(b, float) - a) / seconds]])


def rest_to_rest(a, b):
    a, b = np.array(a, float), np.array(b, float)
    return of([0, 1], [[a, 0 * a, 0 * a, 10 * (b - a), -15 * (b - a), 6 * (b - a)]])


def judged(scenario, curve):
    with np.errstate(all="ignore"):  # as `judge` does
        return judge_curve(referee_world(scenario), curve, bernstein(curve.pieces, curve.durations))


def legs(scenario, *points):
    path = np.array(points, float)
    with np.errstate(all="ignore"):
        return judge_segments(referee_world(scenario), path[:-1], path[1:])


def verdict(met):
    if met.incursion is not None:
        return "refuted"
    return "proven" if met.peaks.proven[0] else "undecided"


def samples(curve, count=4001):
    local = [np.linspace(0, duration, count) for duration in curve.durations]
    return np.concatenate([curve.motions(np.full(count, k), t)[:, 0] for k, t in enumerate(local)])
