"""Tours kept apart: each UAV waits at home and at its targets until those before it have passed."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from skyverse.deconfliction.candidate import PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.find_conflicts import find_conflicts
from skyverse.interrupt import interrupted
from skyverse.mission.tour_flight import TourFlight
from skyverse.model.mission import Mission
from skyverse.model.short_lines import told_seconds
from skyverse.model.verdict import Action, Deconfliction
from skyverse.problem import Airspace
from skyverse.referee import judge_battery

SHORTEST_WAIT = 1.0
"""Seconds that a UAV waits at first; each time that this does not suffice it waits half as long again."""
MOST_TRIES = 150
"""How often a UAV's waits are made longer before it flies as it is."""
LONGEST_WAIT = 1800.0
"""Seconds of a single wait at most."""

Flown = Callable[[Mission, Sequence[TourFlight | None]], Mission]


def with_waits(airspace: Airspace, mission: Mission, flights: Sequence[TourFlight | None], flown: Flown) -> Mission:
    """Return a mission of tours whose UAVs wait for others, those of lower priority and shorter tours for the rest.

    A UAV in conflict departs later on the leg in which it meets another or, where it is in the way of others while it
    stands at a target, on the leg to there. It waits where it stands before that leg; where its battery or a window
    does not allow that, at home before the sortie.

    Parameters
    ----------
    airspace, mission
        The airspace, and the mission without waits.
    flights
        The flight of each UAV, ``None`` for one that stays at its start.
    flown
        Puts flights into a mission.
    """
    scenario = airspace.scenario
    found = find_conflicts(scenario, mission.trajectories)
    pool = CandidatePool(airspace, lambda *_: None)
    pool.end = mission.makespan
    best = list(flights)
    rank = [(one is not None, -own.priority, -_end(one)) for own, one in zip(scenario.uavs, flights, strict=True)]
    order = sorted(range(len(flights)), key=rank.__getitem__)
    placed: list[PlacedFlight] = []
    for uav in order if found or pool.is_dynamic else ():
        flight = flights[uav]
        if flight is None:
            placed.append(pool.parked(uav))
            continue
        waiting = _clear(pool, flight, placed)
        best[uav] = flight if waiting is None else waiting
        placed.append(_placed(pool, best[uav]))
        pool.end = max(pool.end, _end(best[uav]))
    after = flown(mission, best)
    actions = tuple(
        Action(uav, "wait", f"{scenario.uavs[uav].name} waits {told_seconds(_end(now) - _end(then))} on its tour.")
        for uav, (then, now) in enumerate(zip(flights, best, strict=True))
        if now is not then
    )
    record = Deconfliction(
        found=found,
        left=find_conflicts(scenario, after.trajectories),
        actions=actions,
        total_before=mission.total_time,
        total_after=after.total_time,
        makespan_before=mission.makespan,
        makespan_after=after.makespan,
    )
    return replace(after, deconfliction=record, interrupted=interrupted())


def _end(flight: TourFlight | None) -> float:
    return 0.0 if flight is None else flight.sorties[-1].end


def _placed(pool: CandidatePool, flight: TourFlight | None) -> PlacedFlight:
    assert flight is not None
    trajectory = flight.trajectory
    return PlacedFlight(pool.add_planned(flight.uav, flight.ends[0], None, trajectory), trajectory.start)


def _clear(pool: CandidatePool, flight: TourFlight, placed: Sequence[PlacedFlight]) -> TourFlight | None:
    """Return a flight with waits such that it meets none that are placed; ``None`` where none was found."""
    scenario, waits = flight.scenario, np.zeros(len(flight.legs))
    begins = np.flatnonzero([end is None for end in (None, *flight.ends[:-1])])  # of sorties
    tried, grounded = flight, scenario.uavs[flight.uav].fixed_wing is not None
    for _ in range(MOST_TRIES):
        if interrupted():
            return None
        own = _placed(pool, tried).candidate
        met = pool.first_conflict(own, pool.traffic(own, placed))
        if met is None:
            return tried
        leg = int(np.searchsorted(np.array(tried.times)[:, 0], met, side="right")) - 1  # the last that has departed
        if leg < 0:
            return None  # it is met before it departs
        if grounded:
            leg = int(begins[begins <= leg][-1])
        waits[leg] = min(max(SHORTEST_WAIT, 1.5 * waits[leg]), LONGEST_WAIT)
        tried = replace(flight, departures=_later(flight, waits))
        if tried.keeps_windows() and _battery_lasts(tried):
            continue
        if grounded:
            return None
        grounded, waits[:], tried = True, 0.0, flight
    return None


def _later(flight: TourFlight, waits: np.ndarray) -> tuple[float, ...]:
    """Return departures such that a flight waits so many seconds longer before each leg than it must."""
    departures: list[float] = []
    for k in range(len(flight.legs)):
        before = replace(flight, departures=(*departures, *flight.departures[k:]))
        departures.append(before.times[k][0] + float(waits[k]))
    return tuple(departures)


def _battery_lasts(flight: TourFlight) -> bool:
    scenario, whole = flight.scenario, flight.trajectory
    spans = np.array([(one.begin, one.end) for one in flight.sorties])
    return not judge_battery(scenario, flight.uav, whole, spans)
