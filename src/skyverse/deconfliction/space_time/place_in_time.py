"""Prioritized planning in space and time: UAVs wait, let others pass and back out where delays do not suffice."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.choose_flight import later_or_slower
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.space_time.waiting_flights import WaitingFlights
from skyverse.numerics.tolerances import MIN_NORM

HEAD_STARTS = (0.0, 1.0, 2.0, 4.0, 8.0)
"""Seconds by which all that are placed depart later where a UAV finds no flight else: they stay clear of each other."""
MAX_RESTARTS = 6
"""How often all UAVs are placed anew, those that found no flight first."""


def place_in_time(pool: CandidatePool, flights: WaitingFlights, planned: Sequence[Candidate]) -> list[PlacedFlight]:
    """Return a flight for every UAV; one for which none is found flies as planned, in conflict.

    The UAVs have their turns in the order of their priorities; among equals those that fly in one direction follow each
    other, the shortest flights first. Each keeps out of the way of those that are still at their starts, if it can.
    Those that find no flight go first in the next order.

    Parameters
    ----------
    pool
        All candidates.
    flights
        Searches in space and time.
    planned
        Each UAV's planned path.
    """
    uavs = pool.scenario.uavs
    ahead = _directions(planned)
    order = sorted(
        range(len(planned)),
        key=lambda u: (planned[u].target is not None, -uavs[u].priority, ahead[u], planned[u].seconds, u),
    )
    best: list[PlacedFlight] | None = None
    for _ in range(1 + MAX_RESTARTS):
        placed = _in_turn(pool, flights, planned, order)
        failed = [uav for uav in order if placed[uav].in_conflict]
        if best is None or len(failed) < sum(flight.in_conflict for flight in best):
            best = placed
        if not failed or pool.cancelled:
            break
        order = moved_to_front(order, failed)
    assert best is not None
    return best


def moved_to_front(order: Sequence[int], first: Sequence[int]) -> list[int]:
    """Return an order of UAVs in which some come `first`; the others follow them in the order that they had."""
    front = set(first)
    return [*first, *(uav for uav in order if uav not in front)]


def _in_turn(
    pool: CandidatePool, flights: WaitingFlights, planned: Sequence[Candidate], order: Sequence[int]
) -> list[PlacedFlight]:
    """Return the flights that the UAVs choose one after another; those that find none are in nobody's way."""
    placed: dict[int, PlacedFlight] = {}
    failed: dict[int, PlacedFlight] = {}
    for turn, uav in enumerate(order):
        own = planned[uav]
        at_start = [pool.parked(other) for other in order[turn + 1 :] if planned[other].target is not None]
        ahead = [waiting for waiting in at_start if not pool.too_near(uav, waiting.candidate.start, own.end)]
        for head_start in HEAD_STARTS:
            delayed = {k: replace(flight, departure=flight.departure + head_start) for k, flight in placed.items()}
            flight = _first_to_arrive(pool, flights, own, [*delayed.values(), *ahead])
            if flight is None and ahead:
                flight = _first_to_arrive(pool, flights, own, list(delayed.values()))
            if flight is not None:
                placed = delayed
                break
            if not placed or pool.cancelled or pool.is_dynamic:
                break
        if flight is None:
            failed[uav] = PlacedFlight(own, own.trajectory.start, in_conflict=True)
        else:
            placed[uav] = flight
    return [(placed if uav in placed else failed)[uav] for uav in range(len(planned))]


def _first_to_arrive(
    pool: CandidatePool, flights: WaitingFlights, own: Candidate, placed: Sequence[PlacedFlight]
) -> PlacedFlight | None:
    """Return the earlier of the planned path, later or more slowly, and of what is found in space and time, if any."""
    traffic = pool.traffic(own, placed)
    departure = own.trajectory.start
    if not pool.conflicts(own, departure, traffic).any():
        return PlacedFlight(own, departure)
    if own.target is None or pool.cancelled:
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
