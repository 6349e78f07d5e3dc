"""Prioritized planning: one UAV after another takes the flight by which it arrives first among those before it."""

import math
from collections.abc import Sequence

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.choose_flight import choose_flight
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.space_time.place_in_time import moved_to_front, place_in_time
from skyverse.deconfliction.space_time.waiting_flights import WaitingFlights
from skyverse.model.uav import UAV

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
        first = _in_turn(pool, flights, planned, order, MOST_FAILED)
        if cost_of(first)[0] > MOST_FAILED and not pool.cancelled:
            first = None  # it was broken off
            best = place_in_time(pool, flights, planned)
            if n > SMALL_FLEET:
                return best
            best = _improved(pool, flights, planned, best)
    for tried in range(len(keys) + max(MIN_NEXT_ORDERS, NEXT_ORDERS_OF_EIGHT * 8 // max(n, 8))):
        if best is not None and (cost_of(best) == at_once or (cost_of(best)[0] == 0 and pool.spent)):
            break
        key = keys[tried] if tried < len(keys) else next_key(planned, order, placed)
        order = priority_order(pool.scenario.uavs, planned, in_conflict, key)
        if tried > 0 or first is None:
            first = _in_turn(pool, flights, planned, order)
        placed, order = _in_best_order(pool, flights, planned, order, first)
        if best is None or cost_of(placed) < cost_of(best):
            best = placed
        if pool.cancelled:
            break
    assert best is not None
    if cost_of(best)[0] > 0 and not pool.cancelled:
        best = min(best, place_in_time(pool, flights, planned), key=cost_of)
    return _improved(pool, flights, planned, best)


def cost_of(placed: Sequence[PlacedFlight]) -> tuple[int, float, float]:
    """Return what is to be small, in this order: how many are in conflict, the makespan, the sum of arrivals."""
    arrivals = [flight.arrival for flight in placed if flight.candidate.target is not None]
    conflicts = sum(flight.in_conflict for flight in placed)
    return conflicts, round(max(arrivals, default=0.0), DECIMALS), round(sum(arrivals), DECIMALS)


def _in_best_order(
    pool: CandidatePool,
    flights: WaitingFlights,
    planned: Sequence[Candidate],
    order: list[int],
    placed: list[PlacedFlight],
) -> tuple[list[PlacedFlight], list[int]]:
    """Return flights placed by an order, or by one in which those left in conflict go first, and the last order."""
    for _ in range(MAX_PROMOTIONS):
        failed = [uav for uav in order if placed[uav].in_conflict]
        if not failed or pool.cancelled:
            break
        order = moved_to_front(order, failed)
        again = _in_turn(pool, flights, planned, order)
        if cost_of(again)[0] >= cost_of(placed)[0]:
            break
        placed = again
    return placed, order


def _in_turn(
    pool: CandidatePool,
    flights: WaitingFlights,
    planned: Sequence[Candidate],
    order: Sequence[int],
    most_failed: float = math.inf,
) -> list[PlacedFlight]:
    """Return the flights that the UAVs choose one after another, until more than so many are left in conflict."""
    placed: dict[int, PlacedFlight] = {}
    for uav in order:
        if sum(flight.in_conflict for flight in placed.values()) > most_failed:
            at_once = [PlacedFlight(own, own.trajectory.start, in_conflict=True) for own in planned]
            return [placed.get(u, at_once[u]) for u in range(len(planned))]
        placed[uav] = choose_flight(pool, flights, planned[uav], list(placed.values()))
    return [placed[uav] for uav in range(len(planned))]


def _improved(
    pool: CandidatePool, flights: WaitingFlights, planned: Sequence[Candidate], placed: list[PlacedFlight]
) -> list[PlacedFlight]:
    """Let each UAV that comes late, the last to arrive first, choose again among all the others.

    Once the effort is spent, only those that are left in conflict do.
    """
    for uav in sorted(range(len(planned)), key=lambda u: -placed[u].arrival):
        flight = placed[uav]
        if pool.cancelled:
            break
        early_enough = pool.spent or flight.arrival <= planned[uav].trajectory.end
        if flight.candidate.target is None or (early_enough and not flight.in_conflict):
            continue
        again = choose_flight(pool, flights, planned[uav], [other for other in placed if other is not flight])
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
