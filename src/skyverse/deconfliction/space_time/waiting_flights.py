"""How one UAV flies among placed flights if it may also wait on its way, let others pass and back out."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats
from skyverse.deconfliction.candidate import Candidate, PlacedFlight
from skyverse.deconfliction.candidate_pool import CandidatePool
from skyverse.deconfliction.forbidden_departures import TICK
from skyverse.deconfliction.space_time.itinerary_flight import Nonstop, smoothed, split_at_waits, whole_flight
from skyverse.deconfliction.space_time.leg_profiles import leg_profiles
from skyverse.deconfliction.space_time.roadmap import make_roadmap
from skyverse.deconfliction.space_time.search import ArrivalQuery, Itinerary, RoadmapGraph, earliest_arrival, seconds_to
from skyverse.model.quantities import derived
from skyverse.model.result import Effort
from skyverse.model.uav import UAV, TrackingError
from skyverse.model.verdict import Verdict
from skyverse.numerics.kernel import Stopwatch
from skyverse.numerics.tolerances import LIMIT_MARGIN, MIN_WAIT
from skyverse.planners.base import provenance
from skyverse.planners.results import SearchRecord, any_angle_result
from skyverse.problem import Problem
from skyverse.search.path_shortening.shortcut import drop_collinear
from skyverse.trajectory.heading import with_heading
from skyverse.trajectory.limits import Limits, limits_of
from skyverse.trajectory.proof import prove

WEIGHTS = (10.0, 2.0)
"""How much more the time that is left counts than that which has passed: first few states are expanded, then more."""
MOST_EXPANDED = 6_000
"""States that are expanded in one search at most."""


class WaitingFlights:
    """Searches in space and time for the UAVs of a fleet, on roadmaps that they share; what they find is kept.

    Parameters
    ----------
    pool
        All candidates.
    planned
        Each UAV's planned path.
    """

    def __init__(self, pool: CandidatePool, planned: Sequence[Candidate]) -> None:
        self.pool, self.planned = pool, planned
        self._roadmaps: dict[TrackingError, RoadmapGraph] = {}
        self._profiles: dict[tuple[TrackingError, Limits], Floats] = {}
        self._left: dict[tuple[TrackingError, Limits, int], Floats] = {}
        self._answers: dict[tuple[object, ...], PlacedFlight | None] = {}

    def flight(
        self, planned: Candidate, placed: Sequence[PlacedFlight], latest: float = np.inf, searches: int = 1
    ) -> PlacedFlight | None:
        """Return how a UAV can fly to its target without coming too near to anybody, if that is found.

        Aeroplanes cannot wait, and a path on the lattice must stay there: for both there is none.

        Parameters
        ----------
        planned
            The UAV's planned path.
        placed
            The flights that it gives way to.
        latest
            Seconds: the flight must arrive before.
        searches
            How many searches are made: each seeks an earlier arrival than the one before, and takes longer.
        """
        pool, result = self.pool, planned.result
        uav = pool.scenario.uavs[planned.uav]
        if uav.fixed_wing is not None or planned.target is None or result is None or not result.any_angle:
            return None
        among = frozenset((flight.candidate.curve, flight.departure, flight.time_scale) for flight in placed)
        asked = planned.curve, among, latest, searches
        if asked not in self._answers:
            self._answers[asked] = self._search(planned, placed, latest, searches)
        return self._answers[asked]

    def _search(
        self, planned: Candidate, placed: Sequence[PlacedFlight], latest: float, searches: int
    ) -> PlacedFlight | None:
        """Return what `flight` does, without looking among the answers that are kept."""
        pool = self.pool
        assert planned.target is not None
        clock = Stopwatch()
        problem = Problem(pool.airspace, planned.uav, planned.target)
        found, graph, limited = self._itinerary(problem, planned, placed, latest, searches)
        if len(found.vertices) < 2:
            return None
        points = graph.points[found.vertices]
        up, down = map(len, problem.lifts)
        stops = {k for k, there in ((1, up), (len(points) - 2, down)) if there}
        runs = split_at_waits(points, found.departures, found.arrivals, limited, stops, pool.scenario.winds)
        taking_off, landing = runs[:up], runs[len(runs) - down :]
        traffic, start = pool.traffic(planned, placed), planned.trajectory.start

        def clear(flying: Sequence[Nonstop]) -> bool:
            flown = whole_flight([*taking_off, *flying, *landing])
            return pool.is_clear(planned, flown.retimed(start), runs[0].departure, traffic)

        flying = smoothed(problem.airspace.world, limited, runs[up : len(runs) - down], clear)
        if not (clear(flying) and _proven(problem, limited, flying, [*taking_off, *landing])):
            return None
        runs = [*taking_off, *flying, *landing]
        path = drop_collinear(np.vstack([run.path for run in flying]))
        origin = provenance("SIPP", None, None)
        effort = Effort(generated_paths=1, generated_nodes=found.expanded, evaluations=1)
        record = SearchRecord(origin, effort, clock.seconds)
        flown = with_heading(whole_flight(runs), pool.scenario.uavs[planned.uav]).retimed(start)
        waits = [(run.departure - before.arrival, before.path[-1]) for before, run in pairwise(runs)]
        result = any_angle_result(problem, path, None, record)
        hovers = tuple(wait for wait in waits if wait[0] > MIN_WAIT)
        candidate = pool.add(planned.uav, planned.target, result, flown, hovers=hovers, in_time=True)
        return PlacedFlight(candidate, runs[0].departure)

    def _itinerary(
        self, problem: Problem, planned: Candidate, placed: Sequence[PlacedFlight], latest: float, searches: int
    ) -> tuple[Itinerary, RoadmapGraph, UAV]:
        """Return the itinerary of a UAV, on which roadmap it is, and the UAV as slow as zones make it."""
        pool = self.pool
        uav, world = pool.scenario.uavs[planned.uav], problem.airspace.world
        slowest = min([uav.max_speed, *(zone.max_speed for zone in world.speed_zones)])
        limited = derived(uav, max_speed=slowest, max_airspeed=uav.airspeed)
        graph = self._roadmap(planned.uav)
        limits = limits_of(limited, -LIMIT_MARGIN, pool.scenario.winds)
        source, target = (_vertex(graph, place) for place in (problem.uav_place, problem.target_place))
        key = uav.tracking_error, limits
        if key not in self._profiles:
            self._profiles[key] = leg_profiles(graph.ways, limits)
        profiles = self._profiles[key]
        if (*key, target) not in self._left:
            self._left[*key, target] = seconds_to(graph, profiles, target)
        left = self._left[*key, target]
        others = pool.others(planned, placed)
        query = ArrivalQuery(
            graph, profiles, others, left, source, target, planned.trajectory.start, WEIGHTS[0], MOST_EXPANDED, latest
        )
        best = Itinerary(np.empty(0, np.int64), np.empty(0), np.empty(0), 0)
        expanded = 0
        for weight in WEIGHTS[:searches]:
            found = earliest_arrival(query._replace(weight=weight, latest=latest))
            expanded += found.expanded
            pool.effort += found.expanded * (len(placed) + len(others.movers.kind))
            if len(found.vertices) < 2:
                break
            best, latest = found, float(found.arrivals[-1]) - TICK
        return best._replace(expanded=expanded), graph, limited

    def _roadmap(self, uav: int) -> RoadmapGraph:
        """Return the roadmap for UAVs with the tracking error of one of them."""
        error = self.pool.scenario.uavs[uav].tracking_error
        if error not in self._roadmaps:
            alike = [own for own in self.planned if self.pool.scenario.uavs[own.uav].tracking_error == error]
            problems = [
                (own, Problem(self.pool.airspace, own.uav, own.target)) for own in alike if own.target is not None
            ]
            paths = [problem.without_lifts(own.result.path) for own, problem in problems if own.result is not None]
            columns = [
                np.array([ground, top])
                for _, problem in problems
                for ground, top in ((problem.uav_place, problem.start), (problem.target_place, problem.end))
                if not np.array_equal(ground, top)
            ]
            ellipsoids = np.column_stack([self.pool.semi_axis_xy.max(axis=1), self.pool.semi_axis_z.max(axis=1)])
            flying = ellipsoids[[own.uav for own in alike]]
            world = self.pool.airspace.of(uav).world
            self._roadmaps[error] = make_roadmap(world, paths, columns, flying.min(axis=0))
        return self._roadmaps[error]


def _vertex(graph: RoadmapGraph, place: Floats) -> int:
    """Return the vertex at a place, (3,) metres."""
    return int(np.argmin(np.linalg.norm(graph.points - place, axis=1)))


def _proven(problem: Problem, uav: UAV, flying: Sequence[Nonstop], in_columns: Sequence[Nonstop]) -> bool:
    """Tell whether all parts of a flight are proven free and within the UAV's limits."""
    worlds = [problem.airspace.world] * len(flying) + [problem.airspace.nominal.world] * len(in_columns)
    return all(
        prove(world, uav, run.flown).verdict is Verdict.PROVEN
        for world, run in zip(worlds, [*flying, *in_columns], strict=True)
    )
