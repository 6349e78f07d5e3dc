"""When a flight may depart so that it stays clear of movers, and when one that is timed first meets a mover.

Zones that are closed at times count as movers that stand still, and are there only at these times.

A timed flight is followed in steps in which the distance that is left from a mover cannot be used up, since both have a
top speed. Where it meets a mover, the place of the flight that gets deepest into it is kept: as departures get later,
that place alone rules out many of them at once.
"""

import math

import numpy as np

from skyverse._typing import Floats, Ints
from skyverse.deconfliction.curves import Curves, TimedCurve, curve_duration, evaluate_piece, piece_at
from skyverse.deconfliction.forbidden_departures import TICK, next_free
from skyverse.numerics.kernel import inner, kernel
from skyverse.numerics.tolerances import MOVER_MARGIN
from skyverse.space.timed_shapes import MovingShapes, gap_at

SHORTEST_STEP = 1e-4
"""Seconds by which a timed flight is followed at least."""
STAY = 1.0
"""Seconds for which a UAV must stay clear where it has arrived, at least, as the referee has it."""
DEEPER, DEEPER_STEPS = 0.02, 200
"""Seconds of the steps in which the deepest place in a mover is sought, and how many of them are taken at most."""
MAX_PLACES = 256
"""Places of a flight that are kept; later ones replace the first."""


@inner
def top_speed(curves: Curves, c: int) -> float:
    """Return a speed that curve c nowhere exceeds, m/s, from the differences of its Bernstein coefficients."""
    fastest = 0.0
    degree = curves.rows.shape[1] - 1
    for k in range(curves.first[c], curves.first[c + 1]):
        for i in range(degree):
            square = 0.0
            for axis in range(3):
                square += (curves.rows[k, i + 1, axis] - curves.rows[k, i, axis]) ** 2
            fastest = max(fastest, degree * math.sqrt(square) / curves.duration[k])
    return fastest


@inner
def _place(curves: Curves, c: int, local: float, out: Floats) -> None:
    """Write the position on curve c at a local time; before it begins and after it ends, that of the end."""
    k = piece_at(curves, c, local)
    evaluate_piece(curves.rows[k], min(max((local - curves.begin[k]) / curves.duration[k], 0.0), 1.0), out)


@kernel
def clear_departure(
    shapes: MovingShapes, curves: Curves, c: int, scale: float, end: float, begin: int, free: Ints
) -> int:
    """Return the number of the first free departure from one on with which a flight stays clear of all movers.

    Those before it are forbidden on the way. The last entry of `free` says that there is none left.

    Parameters
    ----------
    shapes
        The movers.
    curves, c, scale
        The flight's curve, and how many times as long it takes.
    end
        Seconds until which the UAV stays where it has arrived, at least.
    begin
        The number of a departure.
    free
        As from `free_departures`; changed in place.
    """
    last = len(free) - 1
    seconds = scale * curve_duration(curves, c)
    movers, places = np.empty(MAX_PLACES, np.int64), np.empty(MAX_PLACES)
    count = 0
    place, moved = np.empty(3), np.empty(3)
    i = next_free(free, begin)
    while i < last:
        departure = i * TICK
        later = 0.0
        for k in range(min(count, MAX_PLACES)):
            flown = places[k]
            _place(curves, c, min(flown, seconds) / scale, place)
            m = movers[k]
            depth = MOVER_MARGIN - gap_at(shapes, m, departure + flown, place, moved)
            if depth > 0.0:
                inside = depth / shapes.rate[m] if shapes.rate[m] > 0.0 else math.inf  # at least, and while it is there
                inside = min(inside, shapes.active[m, 1] - (departure + flown))
                later = max(later, min(max(inside, TICK), (last - i) * TICK))
        if later == 0.0:
            m, met = _first_met_of_all(shapes, curves, TimedCurve(c, departure, scale), end)
            if met == math.inf:
                return i
            if met < departure:  # while it waits for the departure, and for all later ones
                later = (last - i) * TICK
            else:
                movers[count % MAX_PLACES] = m
                places[count % MAX_PLACES] = _deepest(shapes, m, curves, c, scale, departure, met - departure)
                count += 1
                later = TICK
        for k in range(i, min(i + max(int(later / TICK), 1), last)):
            free[k] = max(free[k], k + 1)
        i = next_free(free, i)
    return last


@inner
def _deepest(
    shapes: MovingShapes, m: int, curves: Curves, c: int, scale: float, departure: float, flown: float
) -> float:
    """Return after which time of a flight, from one on, it gets deepest into mover m; seconds."""
    seconds = scale * curve_duration(curves, c)
    place, moved = np.empty(3), np.empty(3)
    least, best = math.inf, flown
    for _ in range(DEEPER_STEPS):
        _place(curves, c, min(flown, seconds) / scale, place)
        gap = gap_at(shapes, m, departure + flown, place, moved)
        if gap >= least:
            break
        least, best = gap, flown
        flown += DEEPER
    return best


@inner
def _first_met_of_all(shapes: MovingShapes, curves: Curves, flight: TimedCurve, until: float) -> tuple[int, float]:
    """Return the mover that a timed flight meets first, and the instant; infinite if it meets none."""
    end = max(until, flight.departure + flight.time_scale * curve_duration(curves, flight.curve) + STAY)
    own = top_speed(curves, flight.curve) / flight.time_scale
    who, first = -1, math.inf
    for m in range(len(shapes.kind)):
        met = first_met(shapes, m, curves, flight, own, min(end, first))
        if met < first:
            who, first = m, met
    return who, first


@inner
def first_met(shapes: MovingShapes, m: int, curves: Curves, flight: TimedCurve, own: float, until: float) -> float:
    """Return the first instant up to `until` at which a timed flight is too near to mover m; infinite if there is none.

    The flight, which is nowhere faster than `own`, m/s, is followed in steps in which the distance that is left cannot
    be used up.
    """
    c, departure, scale = flight.curve, flight.departure, flight.time_scale
    arrival = departure + scale * curve_duration(curves, c)
    rate = shapes.rate[m]
    place, moved = np.empty(3), np.empty(3)
    now, until = max(0.0, shapes.active[m, 0]), min(until, shapes.active[m, 1])
    if now > until:
        return math.inf
    while True:
        _place(curves, c, min(max((now - departure) / scale, 0.0), curve_duration(curves, c)), place)
        gap = gap_at(shapes, m, now, place, moved) - MOVER_MARGIN
        if gap < 0.0:
            return now
        if now >= until:
            return math.inf
        flies = departure <= now < arrival
        speed = rate + own if flies else rate
        step = max(gap / speed, SHORTEST_STEP) if speed > 0.0 else until
        end = arrival if flies else (departure if now < departure else until)  # of what is done now
        now = min(min(now + step, max(end, now + SHORTEST_STEP)), until)


@kernel
def meets_movers(shapes: MovingShapes, curves: Curves, flight: TimedCurve, until: float) -> Floats:
    """Return for each of n movers the first instant at which a timed flight is too near to it, (n,) seconds.

    It is infinite where there is none up to `until`, or until a second after the flight has arrived.
    """
    end = max(until, flight.departure + flight.time_scale * curve_duration(curves, flight.curve) + STAY)
    own = top_speed(curves, flight.curve) / flight.time_scale
    met = np.empty(len(shapes.kind))
    for m in range(len(shapes.kind)):
        met[m] = first_met(shapes, m, curves, flight, own, end)
    return met
