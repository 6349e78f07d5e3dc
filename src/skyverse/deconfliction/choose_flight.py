"""One UAV's turn: how it arrives first among the flights that are already placed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyverse.cost import soft_terms
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.space_time.waiting_flights import WaitingFlights
from skyverse.deconfliction.traffic import Traffic
from skyverse.interrupt import interrupted
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import active_spans
from skyverse.model.timed_shapes import temporary_zones

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


@dataclass
class _Turn:
    """One UAV's turn among the flights that it gives way to, the latest arrival that counts, and what it has so far.

    `around` is the last candidate that heeds zones with active times, at first the planned one.
    """

    pool: CandidatePool
    planned: Candidate
    traffic: Traffic
    latest: float
    around: Candidate
    best: PlacedFlight | None = None

    def try_out(self, candidate: Candidate) -> None:
        """Keep the flight of a candidate if it arrives earlier than the best so far."""
        self.best = later_or_slower(self.pool, candidate, self.traffic, self.latest, self.best)

    @property
    def late(self) -> bool:
        """Whether more is worth trying to arrive earlier."""
        enough = self.planned.seconds * (1.0 + TOLERATED_DELAY) + self.planned.trajectory.start
        return self.best is None or self.best.arrival > enough


def choose_flight(flights: WaitingFlights, planned: Candidate, placed: Sequence[PlacedFlight]) -> PlacedFlight:
    """Return how a UAV arrives first without a conflict: by its planned path, later, slower, waiting, or by a detour.

    Where that is not possible, or the search is cancelled, it flies as planned.

    Parameters
    ----------
    flights
        All candidates, and searches in space and time.
    planned
        The UAV's planned path.
    placed
        The flights that it gives way to.
    """
    pool, departure = flights.pool, planned.trajectory.start
    traffic = pool.traffic(planned, placed)
    in_conflict = bool(pool.conflicts(planned, departure, traffic).any())
    if planned.target is None or not in_conflict or interrupted():
        return PlacedFlight(planned, departure, in_conflict=in_conflict)
    latest = max((flight.arrival for flight in placed), default=0.0) + TICK
    if pool.is_dynamic:
        latest = max(latest, departure + planned.seconds, _last_closing(pool.scenario)) + LONGEST_WAIT
    turn = _Turn(pool, planned, traffic, latest, around=planned)
    turn.try_out(planned)
    _around_zones(turn)
    if turn.late:
        _in_space_and_time(turn, flights, placed)
        _through_gates(turn)
    return PlacedFlight(planned, departure, in_conflict=True) if turn.best is None else turn.best


def _in_space_and_time(turn: _Turn, flights: WaitingFlights, placed: Sequence[PlacedFlight]) -> None:
    """Try to wait on the way, to let others pass, and to back out."""
    pool, best = turn.pool, turn.best
    if soft_terms(pool.scenario):  # the search heeds time alone
        return
    until = np.inf if best is None else best.arrival - TICK
    waiting = flights.flight(turn.planned, placed, until, searches=1 if pool.spent else SEARCHES)
    if waiting is not None and waiting.arrival < until:
        turn.best = waiting
    else:
        pool.tries += 1


def _through_gates(turn: _Turn) -> None:
    """Try detours through gates beside the place of a conflict; where all are in conflict, around one more place."""
    pool, traffic, around = turn.pool, turn.traffic, turn.around
    for _ in range(MAX_GATES):
        share = None if turn.best is not None and pool.spent else pool.middle_conflict(around, traffic)
        if share is None:
            return
        tried = []
        until = 2.0 * turn.latest + around.seconds if turn.best is None else turn.best.arrival - TICK
        for arrival, gate in pool.ranked_gates(around, share, traffic, until)[:MAX_DETOURS]:
            before = turn.best
            if before is not None and arrival >= before.arrival:
                break
            detour = pool.detour(around, gate)
            if detour is not None:
                tried.append(detour)
                turn.try_out(detour)
                pool.tries += turn.best is before
        if turn.best is not None or not tried:
            return
        around = min(tried, key=lambda own: pool.conflicts(own, own.trajectory.start, traffic).sum())


def _last_closing(scenario: Scenario) -> float:
    """Return when the last zone has closed, of those that a UAV would wait for; 0 s where there is none."""
    zones = [scenario.zones[number] for number in temporary_zones(scenario)]
    ends = [end for zone in zones for _, end in active_spans(zone.active)]
    return max((end for end in ends if end <= LONGEST_CLOSURE), default=0.0)


def _around_zones(turn: _Turn) -> None:
    """Try to heed the zones with active times that the flight as planned meets, then those that it meets instead."""
    for _ in range(MAX_HEEDED):
        met = turn.pool.zones_met(turn.around)
        heeding = turn.pool.heeding(turn.planned, turn.around.heeds | met) if met else None
        if heeding is None:
            return
        turn.try_out(heeding)
        turn.around = heeding


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
