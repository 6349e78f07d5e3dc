"""Prioritized planning: one UAV after another takes the flight by which it arrives first among those before it.

Where delays, slower flights and detours do not suffice, all are placed in space and time: UAVs wait, let others pass
and back out.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.choose_flight import choose_flight, later_or_slower
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.space_time.waiting_flights import WaitingFlights
from skyverse.interrupt import interrupted
from skyverse.model.uav import UAV
from skyverse.numerics.tolerances import MIN_NORM

HEAD_STARTS = (0.0, 1.0, 2.0, 4.0, 8.0)
"""Seconds by which all that are placed depart later where a UAV finds no flight else: they stay clear of each other."""
MAX_RESTARTS = 6
"""How often all UAVs are placed anew, those that found no flight first."""
MAX_PROMOTIONS = 8
"""How often those that are left in conflict are moved to the front of one order."""
SMALL_FLEET = 32
"""UAVs up to which all first orders are tried; of a larger fleet only the first is."""
MIN_NEXT_ORDERS, NEXT_ORDERS_OF_EIGHT = 3, 4
"""Orders that follow from the first ones: at least, and for up to eight UAVs; of more UAVs fewer in proportion."""
MIN_TRIES, TRIES_FOR_EACH = 60, 4
"""Vain detours and searches after which little more is tried to arrive earlier: at least, and for each UAV."""
MOST_EFFORT = 3_000_000
"""States expanded in space and time after which little more is tried to arrive earlier; each counts as often as there
are flights and movers to stay clear of."""
MOST_FAILED = 1
"""UAVs that the first order may leave in conflict; with more, all are placed in space and time at once."""
DECIMALS = 6
"""Of the seconds that are compared, so that rounding decides nothing."""
IN_THE_WAY = 0.5
"""Metres along each axis within which a path counts as passing a start or target; it only decides who goes first."""
PATH_SAMPLES = 100
"""Instants at which a path is sampled for that."""


def place_flights(pool: CandidatePool, planned: Sequence[Candidate], in_conflict: set[int]) -> list[PlacedFlight]:
    """Return a flight for every UAV; one that cannot be kept apart from the others flies as planned, in conflict.

    Several orders of the UAVs are tried. Who came late in one order goes earlier in the next one (squeaky wheel
    optimization: D. Joslin, D. Clements, Journal of Artificial Intelligence Research 10, 1999).

    Parameters
    ----------
    pool
        All candidates.
    planned
        Each UAV's planned path.
    in_conflict
        The UAVs in conflict; the others fly as planned unless one of a higher priority needs their place.
    """
    n, flights = len(planned), WaitingFlights(pool, planned)
    pool.most_tries = pool.tries + max(MIN_TRIES, TRIES_FOR_EACH * n)
    pool.most_effort = pool.effort + MOST_EFFORT
    at_once = cost_of([PlacedFlight(own, own.trajectory.start) for own in planned])
    best: list[PlacedFlight] | None = None
    placed: list[PlacedFlight] = []
    order: list[int] = []
    first: list[PlacedFlight] | None = None
    keys = first_keys(planned)[: None if n <= SMALL_FLEET else 1]
    if in_conflict:
        order = priority_order(pool.scenario.uavs, planned, in_conflict, keys[0])
        first = _in_turn(flights, order, MOST_FAILED)
        if cost_of(first)[0] > MOST_FAILED and not interrupted():
            first = None  # it was broken off
            best = place_in_time(flights)
            if n > SMALL_FLEET:
                return best
            best = _improved(flights, best)
    for tried in range(len(keys) + max(MIN_NEXT_ORDERS, NEXT_ORDERS_OF_EIGHT * 8 // max(n, 8))):
        if best is not None and (cost_of(best) == at_once or (cost_of(best)[0] == 0 and pool.spent)):
            break
        key = keys[tried] if tried < len(keys) else next_key(planned, order, placed)
        order = priority_order(pool.scenario.uavs, planned, in_conflict, key)
        if tried > 0 or first is None:
            first = _in_turn(flights, order)
        placed, order = _in_best_order(flights, order, first)
        if best is None or cost_of(placed) < cost_of(best):
            best = placed
        if interrupted():
            break
    assert best is not None
    if cost_of(best)[0] > 0 and not interrupted():
        best = min(best, place_in_time(flights), key=cost_of)
    return _improved(flights, best)


def cost_of(placed: Sequence[PlacedFlight]) -> tuple[int, float, float]:
    """Return what is to be small, in this order: how many are in conflict, the makespan, the sum of arrivals."""
    arrivals = [flight.arrival for flight in placed if flight.candidate.target is not None]
    conflicts = sum(flight.in_conflict for flight in placed)
    return conflicts, round(max(arrivals, default=0.0), DECIMALS), round(sum(arrivals), DECIMALS)


def _in_best_order(
    flights: WaitingFlights,
    order: list[int],
    placed: list[PlacedFlight],
) -> tuple[list[PlacedFlight], list[int]]:
    """Return flights placed by an order, or by one in which those left in conflict go first, and the last order."""
    for _ in range(MAX_PROMOTIONS):
        failed = [uav for uav in order if placed[uav].in_conflict]
        if not failed or interrupted():
            break
        order = moved_to_front(order, failed)
        again = _in_turn(flights, order)
        if cost_of(again)[0] >= cost_of(placed)[0]:
            break
        placed = again
    return placed, order


def _in_turn(
    flights: WaitingFlights,
    order: Sequence[int],
    most_failed: float = math.inf,
) -> list[PlacedFlight]:
    """Return the flights that the UAVs choose one after another, until more than so many are left in conflict."""
    planned = flights.planned
    placed: dict[int, PlacedFlight] = {}
    for uav in order:
        if sum(flight.in_conflict for flight in placed.values()) > most_failed:
            at_once = [PlacedFlight(own, own.trajectory.start, in_conflict=True) for own in planned]
            return [placed.get(u, at_once[u]) for u in range(len(planned))]
        placed[uav] = choose_flight(flights, planned[uav], list(placed.values()))
    return [placed[uav] for uav in range(len(planned))]


def _improved(flights: WaitingFlights, placed: list[PlacedFlight]) -> list[PlacedFlight]:
    """Let each UAV that comes late, the last to arrive first, choose again among all the others.

    Once the effort is spent, only those that are left in conflict do.
    """
    pool, planned = flights.pool, flights.planned
    for uav in sorted(range(len(planned)), key=lambda u: -placed[u].arrival):
        flight = placed[uav]
        if interrupted():
            break
        early_enough = pool.spent or flight.arrival <= planned[uav].trajectory.end
        if flight.candidate.target is None or (early_enough and not flight.in_conflict):
            continue
        again = choose_flight(flights, planned[uav], [other for other in placed if other is not flight])
        earlier = again.in_conflict == flight.in_conflict and again.arrival < flight.arrival - TICK
        if flight.in_conflict > again.in_conflict or earlier:
            placed[uav] = again
    return placed


def priority_order(uavs: Sequence[UAV], planned: Sequence[Candidate], in_conflict: set[int], key: Floats) -> list[int]:
    """Return the UAVs in the order of their turns.

    Those that stay at their starts come first, then those of higher priority; among equals those in no conflict, and
    then those with the least key, (n,).
    """
    rank = [(planned[u].target is not None, -uavs[u].priority, u in in_conflict, key[u], u) for u in range(len(uavs))]
    return [entry[-1] for entry in sorted(rank)]


def first_keys(planned: Sequence[Candidate]) -> list[Floats]:
    """Return the keys of the first orders: the longest flights first; those in nobody's way; the shortest."""
    seconds = np.array([candidate.seconds for candidate in planned])
    return [-seconds, _paths_crossed(planned), seconds]


def next_key(planned: Sequence[Candidate], order: Sequence[int], placed: Sequence[PlacedFlight]) -> Floats:
    """Return the key of the next order: a UAV's position in the last one, less in proportion to how late it came."""
    late = np.array([flight.arrival - own.trajectory.end for flight, own in zip(placed, planned, strict=True)])
    latest = max(float(late.max()), TICK)
    blame = np.where([flight.in_conflict for flight in placed], 1.0, late / latest)
    position = np.empty(len(order))
    position[list(order)] = np.arange(len(order))
    return position - len(order) * blame


def _paths_crossed(planned: Sequence[Candidate]) -> Floats:
    """Return on how many others' paths each UAV's target lies, less on how many its start lies; (n,)."""
    starts, ends = np.array([own.start for own in planned]), np.array([own.end for own in planned])
    score = np.zeros(len(planned))
    for own in planned:
        instants = np.linspace(own.trajectory.start, own.trajectory.end, PATH_SAMPLES)
        path = own.trajectory.at(instants).position[:, None]
        for points, sign in ((starts, -1.0), (ends, 1.0)):
            near = (np.abs(path - points).max(axis=2) < IN_THE_WAY).any(axis=0)
            near[own.uav] = False
            score += sign * near
    return score


def place_in_time(flights: WaitingFlights) -> list[PlacedFlight]:
    """Return a flight for every UAV; one for which none is found flies as planned, in conflict.

    The UAVs have their turns in the order of their priorities; among equals those that fly in one direction follow each
    other, the shortest flights first. Each keeps out of the way of those that are still at their starts, if it can.
    Those that find no flight go first in the next order.
    """
    pool, planned = flights.pool, flights.planned
    uavs = pool.scenario.uavs
    ahead = _directions(planned)
    order = sorted(
        range(len(planned)),
        key=lambda u: (planned[u].target is not None, -uavs[u].priority, ahead[u], planned[u].seconds, u),
    )
    best: list[PlacedFlight] | None = None
    for _ in range(1 + MAX_RESTARTS):
        placed = _in_turn_in_time(flights, order)
        failed = [uav for uav in order if placed[uav].in_conflict]
        if best is None or len(failed) < sum(flight.in_conflict for flight in best):
            best = placed
        if not failed or interrupted():
            break
        order = moved_to_front(order, failed)
    assert best is not None
    return best


def moved_to_front(order: Sequence[int], first: Sequence[int]) -> list[int]:
    """Return an order of UAVs in which some come `first`; the others follow them in the order that they had."""
    front = set(first)
    return [*first, *(uav for uav in order if uav not in front)]


def _in_turn_in_time(flights: WaitingFlights, order: Sequence[int]) -> list[PlacedFlight]:
    """Return the flights that the UAVs choose one after another; those that find none are in nobody's way."""
    pool, planned = flights.pool, flights.planned
    placed: dict[int, PlacedFlight] = {}
    failed: dict[int, PlacedFlight] = {}
    for turn, uav in enumerate(order):
        own = planned[uav]
        at_start = [pool.parked(other) for other in order[turn + 1 :] if planned[other].target is not None]
        ahead = [waiting for waiting in at_start if not pool.too_near(uav, waiting.candidate.start, own.end)]
        for head_start in HEAD_STARTS:
            delayed = {k: replace(flight, departure=flight.departure + head_start) for k, flight in placed.items()}
            flight = _first_to_arrive(flights, own, [*delayed.values(), *ahead])
            if flight is None and ahead:
                flight = _first_to_arrive(flights, own, list(delayed.values()))
            if flight is not None:
                placed = delayed
                break
            if not placed or interrupted() or pool.is_dynamic:
                break
        if flight is None:
            failed[uav] = PlacedFlight(own, own.trajectory.start, in_conflict=True)
        else:
            placed[uav] = flight
    return [(placed if uav in placed else failed)[uav] for uav in range(len(planned))]


def _first_to_arrive(flights: WaitingFlights, own: Candidate, placed: Sequence[PlacedFlight]) -> PlacedFlight | None:
    """Return the earlier of the planned path, later or more slowly, and of what is found in space and time, if any."""
    pool = flights.pool
    traffic = pool.traffic(own, placed)
    departure = own.trajectory.start
    if not pool.conflicts(own, departure, traffic).any():
        return PlacedFlight(own, departure)
    if own.target is None or interrupted():
        return None
    latest = max((flight.arrival for flight in placed), default=0.0) + TICK
    later = later_or_slower(pool, own, traffic, latest, None)
    waiting = flights.flight(own, placed)
    found = [flight for flight in (later, waiting) if flight is not None]
    return min(found, key=lambda flight: flight.arrival, default=None)


def _directions(planned: Sequence[Candidate]) -> Floats:
    """Return 0 for UAVs that fly one way along the line that most of them fly along, and 1 for those that fly back.

    The line is that of the UAV along whose way all together fly farthest.
    """
    ways = np.array([own.end - own.start for own in planned])
    alongs = np.sum(ways[:, None] * ways, axis=2) / np.maximum(np.linalg.norm(ways, axis=1), MIN_NORM)
    along = alongs[:, np.argmax(np.sum(alongs**2, axis=0))]
    return (along * np.sign(along[np.argmax(np.abs(along))]) < 0.0).astype(np.float64)
