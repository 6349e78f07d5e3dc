"""Judges what a mission says that its UAVs fly: length, time, energy, and how far from the path that was priced."""

import math
from collections.abc import Iterator

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.flight_summary import FlightSummary
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.blocks import blocks
from skyverse.referee.curve import PolynomialCurve
from skyverse.referee.integrals import Enclosure, curve_length, flight_energy
from skyverse.referee.polynomial import bernstein
from skyverse.referee.positions import position_text, position_tuple
from skyverse.referee.segments import share_of
from skyverse.referee.solids import distance_error
from skyverse.referee.subdivision import find_peaks
from skyverse.referee.tolerances import LET_PASS
from skyverse.referee.untrusted import float_array, number

DISTANCES_AT_ONCE = 2**19
"""Distances between coefficients and legs of a path looked at together, which bounds the memory."""


def judge_flight_summary(
    scenario: Scenario, uav: int, claimed: object, path: Floats | None, curve: PolynomialCurve | None
) -> Iterator[Violation]:
    """Yield what is wrong with the summary of UAV number `uav`'s flight; without a summary nothing is judged.

    Parameters
    ----------
    scenario, uav
        What was given, and the UAV.
    claimed
        What the mission says of the flight.
    path
        (n, 3) metres, the path that was priced; ``None`` where there is none to compare with.
    curve
        The flight; ``None`` where the UAV does not fly, or where nobody can tell how.
    """
    vehicle = scenario.uavs[uav]
    if claimed is None:
        return
    if not isinstance(claimed, FlightSummary) or curve is None or path is None:
        message = f"The mission summarises a flight of {vehicle.name}, but there is none along a path."
        yield Violation(Fault.FLIGHT, (uav,), message)
        return
    time, power = float(curve.knots[-1] - curve.knots[0]), vehicle.hover_power
    true = {
        "length": curve_length(curve),
        "time": Enclosure(time, time, time),
        "energy": None if vehicle.fixed_wing is not None or power is None else flight_energy(curve, power),
    }
    for noun, unit in (("length", "m"), ("time", "s"), ("energy", "J")):
        said, is_so = getattr(claimed, noun), true[noun]
        if not (said is None if is_so is None else is_so.agrees(number(said))):
            told = "not known" if is_so is None else f"{is_so.estimate:.9g} {unit}"
            message = f"The mission says that the {noun} of {vehicle.name}'s flight is {said} {unit}, but it is {told}."
            yield Violation(Fault.FLIGHT, (uav,), message)
    yield from _judge_deviation(vehicle.name, uav, number(claimed.deviation), path, curve)


def _judge_deviation(name: str, uav: int, claimed: float, path: Floats, curve: PolynomialCurve) -> Iterator[Violation]:
    """Yield where a curve is farther from a path than claimed, or where that could not be decided.

    The distance from one leg is convex, so that on a part of the curve it is nowhere larger than at the farthest
    coefficient; the leg for which that is least bounds the distance from the path. Distances do not depend on where
    the zero of the frame is: both are moved so that the path begins at zero, and their coordinates, which may be
    millions of metres, add no rounding but that of the move, one of the many that `distance_error` counts.
    """
    if not math.isfinite(claimed) or claimed < 0:
        message = f"The mission says that {name} flies within {claimed} m of its path, which is no distance."
        yield Violation(Fault.FLIGHT, (uav,), message)
        return
    moved, pieces = path - path[0], curve.pieces.copy()
    pieces[:, 0] -= path[0]
    starts, ends = (moved[:-1], moved[1:]) if len(path) > 1 else (moved, moved)
    position = bernstein(pieces, curve.durations)
    b = np.stack([part.b for part in position], axis=2)
    error = np.max([part.error for part in position], axis=0)

    def beyond(part: Floats, _: Indices) -> Floats:
        return _farthest(part, starts, ends) - claimed - LET_PASS

    peaks = find_peaks(b, distance_error(b, error, float(np.abs(moved).max())), beyond)
    if peaks.proven[0]:
        return
    row, share = peaks.place()
    local = share * float(curve.durations[row])
    time, position_then = float(curve.knots[row]) + local, curve.motion(row, local)[0]
    there = f"at t = {time:.6g} s, position {position_text(position_then)}"
    if not peaks.refuted[0]:
        message = f"Whether {name} flies within {claimed:.6g} m of its path could not be decided {there}."
        yield Violation(Fault.UNDECIDED, (uav,), message, time, position_tuple(position_then))
        return
    distance = float(_farthest((position_then - path[0])[None, None], starts, ends)[0])
    message = (
        f"{name} is {distance:.6g} m from the path that was priced {there}; the mission says within {claimed:.6g} m."
    )
    yield Violation(Fault.FLIGHT, (uav,), message, time, position_tuple(position_then))


def _farthest(part: Floats, starts: Floats, ends: Floats) -> Floats:
    """Return upper bounds (n,) on the distances of parts (n, degree + 1, 3) from the legs of a path (m, 3)."""
    count, legs = part.shape[1], len(starts)
    found = np.empty(len(part))
    for some in blocks(len(part), DISTANCES_AT_ONCE, count * legs):
        points = np.concatenate(part[some])
        distances = _distances(points, starts, ends).reshape(len(part[some]), count, legs)
        found[some] = distances.max(axis=1).min(axis=1)
    return found


def _distances(points: Floats, starts: Floats, ends: Floats) -> Floats:
    """Return the distances (n, m) of points (n, 3) from the legs between starts and ends (m, 3), metres."""
    ways = ends - starts
    squares = np.sum(ways**2, axis=1)
    reach = [points[:, None, axis] - starts[:, axis] for axis in range(3)]
    along = np.asarray(sum(reach[axis] * ways[:, axis] for axis in range(3)))
    share = share_of(along, squares)
    return np.sqrt(sum((reach[axis] - share * ways[:, axis]) ** 2 for axis in range(3)))


def priced_path(result: object) -> Floats | None:
    """Return the path (n, 3) of a result, metres, or ``None`` if there is none to compare a flight with."""
    rows = float_array(getattr(result, "path", None))
    if rows is None or rows.ndim != 2 or rows.shape[1:] != (3,) or not len(rows) or not np.isfinite(rows).all():
        return None
    return rows
