"""One UAV's turn: how it arrives first among the flights that are already placed."""

from collections.abc import Iterator, Sequence

import numpy as np

from skyverse.cost import soft_terms
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.space_time.waiting_flights import WaitingFlights
from skyverse.deconfliction.traffic import Traffic
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import active_spans
from skyverse.model.temporary_zones import temporary_zones

SLOWDOWNS = (1.15, 1.4, 2.0)
"""How many times as long a multirotor may take along its path."""
TOLERATED_DELAY = 0.1
"""The share of its flight time by which a UAV may arrive later before a detour is looked for."""
LONGEST_WAIT = 120.0
"""Seconds that a UAV waits for movers to pass, at most, after all others have arrived."""
LONGEST_CLOSURE = 3600.0
"""Seconds into the mission: no UAV waits for a zone that closes later."""
MAX_HEEDED = 4
"""How often a path is led around more zones, since it met others."""
SEARCHES = 2
"""Searches in space and time in one turn, each for an earlier arrival than the one before; later in a long run one."""
MAX_DETOURS = 6
"""Detours that are planned in one turn, by the best estimates, around one place of conflict."""
MAX_GATES = 2
"""Gates that a detour leads through, one after the other."""


def choose_flight(
    pool: CandidatePool, flights: WaitingFlights, planned: Candidate, placed: Sequence[PlacedFlight]
) -> PlacedFlight:
    """Return how a UAV arrives first without a conflict: by its planned path, later, slower, waiting, or by a detour.

    Where that is not possible, or the search is cancelled, it flies as planned.

    Parameters
    ----------
    pool
        All candidates.
    flights
        Searches in space and time.
    planned
        The UAV's planned path.
    placed
        The flights that it gives way to.
    """
    departure = planned.trajectory.start
    traffic = pool.traffic(planned, placed)
    in_conflict = pool.conflicts(planned, departure, traffic)
    if planned.target is None or not in_conflict.any() or pool.cancelled:
        return PlacedFlight(planned, departure, in_conflict=bool(in_conflict.any()))
    latest = max((flight.arrival for flight in placed), default=0.0) + TICK
    if pool.is_dynamic:
        latest = max(latest, departure + planned.seconds, _last_closing(pool.scenario)) + LONGEST_WAIT
    best = later_or_slower(pool, planned, traffic, latest, None)
    enough = planned.seconds * (1.0 + TOLERATED_DELAY) + departure
    around = planned
    for heeding in _around_zones(pool, planned):
        best = later_or_slower(pool, heeding, traffic, latest, best)
        around = heeding
    if around is not planned:
        in_conflict = pool.conflicts(around, departure, traffic)
    late = best is None or best.arrival > enough
    if late and not soft_terms(pool.scenario):  # it heeds time alone
        until = np.inf if best is None else best.arrival - TICK
        waiting = flights.flight(planned, placed, until, searches=1 if pool.spent else SEARCHES)
        if waiting is not None and waiting.arrival < until:
            best = waiting
        else:
            pool.tries += 1
    for _ in range(MAX_GATES if late else 0):
        if best is not None and pool.spent:
            break
        share = pool.middle_conflict(around, traffic, in_conflict)
        if share is None:
            break
        fewest: tuple[int, Candidate] | None = None
        until = 2.0 * latest + around.seconds if best is None else best.arrival - TICK
        for arrival, gate in pool.ranked_gates(around, share, traffic, until)[:MAX_DETOURS]:
            if best is not None and arrival >= best.arrival:
                break
            detour = pool.detour(around, gate)
            if detour is None:
                continue
            before, best = best, later_or_slower(pool, detour, traffic, latest, best)
            pool.tries += best is before
            if best is None:
                conflicts = int(pool.conflicts(detour, departure, traffic).sum())
                if fewest is None or conflicts < fewest[0]:
                    fewest = conflicts, detour
        if best is not None or fewest is None:
            break
        around = fewest[1]
        in_conflict = pool.conflicts(around, departure, traffic)
    return PlacedFlight(planned, departure, in_conflict=True) if best is None else best


def _last_closing(scenario: Scenario) -> float:
    """Return when the last zone has closed, of those that a UAV would wait for; 0 s where there is none."""
    zones = [scenario.zones[number] for number in temporary_zones(scenario)]
    ends = [end for zone in zones for _, end in active_spans(zone.active)]
    return max((end for end in ends if end <= LONGEST_CLOSURE), default=0.0)


def _around_zones(pool: CandidatePool, planned: Candidate) -> Iterator[Candidate]:
    """Yield candidates that heed zones with active times: those that the flight as planned meets, then more of them.

    Each meets others that the next one heeds too; the last one meets none.
    """
    heeding: Candidate | None = planned
    for _ in range(MAX_HEEDED):
        if heeding is None:
            return
        met = pool.zones_met(heeding)
        if not met:
            return
        heeding = pool.heeding(planned, heeding.heeds | met)
        if heeding is not None:
            yield heeding


def later_or_slower(
    pool: CandidatePool, candidate: Candidate, traffic: Traffic, latest: float, best: PlacedFlight | None
) -> PlacedFlight | None:
    """Return the best flight so far, or one of this candidate, delayed or slowed down or both, that arrives earlier."""
    fixed_wing = pool.scenario.uavs[candidate.uav].fixed_wing is not None
    for time_scale in (1.0,) if fixed_wing else (1.0, *SLOWDOWNS):
        seconds = time_scale * candidate.seconds
        until = latest if best is None else min(latest, best.arrival - TICK - seconds)
        if until < candidate.trajectory.start:
            break
        departure = pool.earliest_departure(candidate, time_scale, traffic, until)
        if departure is not None:
            best = PlacedFlight(candidate, departure, time_scale)
    return best
