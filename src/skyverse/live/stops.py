"""The stops of a tour in flight: the targets and stands at home at which a UAV comes to rest, stays, and goes on."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.live.course import part_of, planned_motion
from skyverse.live.guidance import Way, guidance
from skyverse.model.mission import Mission
from skyverse.model.result import Result
from skyverse.model.sortie import Sortie
from skyverse.model.trajectory import Trajectory
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem

AT_PLACE = 1e-6
"""Metres from a stop at which a UAV is there."""


class TourStop(NamedTuple):
    """A place at which a tour is at rest.

    Attributes
    ----------
    target
        Its index, ``None`` at home.
    place
        (3,) metres.
    arrival, departure
        Seconds into the mission, as planned, between which the UAV stands there.
    way, passed
        The way that leads there, and when its points are passed, apart from the first, as planned.
    """

    target: int | None
    place: Floats
    arrival: float
    departure: float
    way: Way
    passed: Floats


def stops_of(airspace: Airspace, mission: Mission, uav: int) -> tuple[TourStop, ...]:
    """Return the stops of a UAV's tour in a mission, in their order; none without a tour."""
    flight, result = mission.trajectories[uav], mission.results[uav]
    if not mission.sorties or flight is None or result is None:
        return ()
    stands = list(_stands(flight, mission.sorties[uav], returns=mission.scenario.uavs[uav].end == "home"))
    stops: list[TourStop] = []
    first, begin = 0, flight.start
    for before, (target, arrival, departure) in pairwise([(None, begin, begin), *stands]):
        problem = Problem(airspace, uav, target, begins=before[0])
        found, first = _leg(problem, result, first)
        way = guidance(problem, found)
        planned = planned_motion(part_of(flight, before[2], arrival), way)
        assert planned is not None
        stops.append(TourStop(target, problem.target_place, arrival, departure, way, planned.passed))
    return tuple(stops)


def _stands(
    flight: Trajectory, sorties: tuple[Sortie, ...], returns: bool
) -> Iterator[tuple[int | None, float, float]]:
    """Yield the target of each stop, ``None`` at home, and when the UAV stands there."""
    for sortie, following in zip(sorties, (*sorties[1:], None), strict=True):
        for visit in sortie.visits:
            yield visit.target, *_stand_around(flight, visit.arrival, visit.departure)
        if returns or following is not None:
            yield None, sortie.end, sortie.end if following is None else following.begin


def _stand_around(flight: Trajectory, begin: float, end: float) -> tuple[float, float]:
    """Return from when until when a flight stands where it is between two instants."""
    moves = np.any(flight.coefficients[:, 1:] != 0.0, axis=(1, 2))
    before, after = flight.knots[1:][moves], flight.knots[:-1][moves]
    arrival = before[before <= begin + AT_PLACE].max(initial=flight.start)
    return float(arrival), float(after[after >= end - AT_PLACE].min(initial=flight.end))


def _leg(problem: Problem, result: Result, first: int) -> tuple[Result, int]:
    """Return the result of a leg, whose path begins at a number of a tour's path, and the number at which it ends.

    Where the tour's path does not lead there, the shortest one does.
    """
    goal = problem.target_place if result.any_angle else problem.places([problem.goal])[0]
    there = np.flatnonzero(np.abs(result.path[first:] - goal).max(axis=1) <= AT_PLACE)
    if not len(there):
        return Taut().plan(problem), first
    last = first + int(there[0])
    return replace(result, path=result.path[first : last + 1]), last


def stands_since(motions: tuple[Trajectory, ...], place: Floats) -> float | None:
    """Return the instant since which a UAV stands at a place (3,), up to the end of its motions; ``None`` if not."""
    since = None
    for motion in reversed(motions):
        for begin, rows in zip(motion.knots[-2::-1], motion.coefficients[::-1], strict=True):
            if rows[1:].any() or np.abs(rows[0] - place).max() > AT_PLACE:
                return since
            since = float(begin)
    return since


def flown_sorties(planned: tuple[Sortie, ...], late: tuple[float, ...], returns: bool) -> tuple[Sortie, ...]:
    """Return the sorties of a tour as far as it was flown, so many seconds late at each stop that it has left."""
    flown: list[Sortie] = []
    ahead, before = iter(late), 0.0
    for number, sortie in enumerate(planned, 1):
        begin, visits, end = sortie.begin + before, [], None
        for visit, before in zip(sortie.visits, ahead, strict=False):
            visits.append(replace(visit, arrival=visit.arrival + before, departure=visit.departure + before))
            end = visits[-1].departure
        if len(visits) == len(sortie.visits):
            before = next(ahead, before) if returns or number < len(planned) else before
            end = sortie.end + before
        if end is None:
            break
        flown.append(Sortie(begin, end, tuple(visits)))
    return tuple(flown)
