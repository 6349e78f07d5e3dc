"""All candidates of a fleet that have come up so far, and what is asked of them: delays, conflicts, detours."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skyverse._typing import Bools, Floats, Ints
from skyverse.deconfliction.among_movers import clear_departure, meets_movers
from skyverse.deconfliction.candidate import Candidate, Gate, PlacedFlight
from skyverse.deconfliction.curve_store import CurveStore
from skyverse.deconfliction.curves import Schedule, TimedCurve, stay_at_start
from skyverse.deconfliction.detours import MakeTrajectory, gates_beside, plan_among, plan_detour
from skyverse.deconfliction.find_conflicts import conflict_spans, ellipsoid_holds, semi_axes
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.deconfliction.space_time.others import Others, make_others
from skyverse.deconfliction.traffic import Traffic, conflicting_flights, earliest_departure, estimate_detours
from skyverse.model.result import Result
from skyverse.model.timed_shapes import is_dynamic, with_zones_active
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.problem import Airspace, Problem
from skyverse.space.timed_shapes import MovingShapes, mover_gaps, moving_shapes, timed_parts

CLOSE_ENDS = 1.05
"""Starts, or targets, are close where their distance is below so many separations."""
LOOK_AHEAD = 30.0
"""Seconds after the last arrival so far until which a search in space and time looks at movers."""
GATE_PARTS = 8
"""Equal parts of a flight's time; gates are set up where one part ends and the next begins."""


class CandidatePool:
    """All candidates of a fleet that have come up so far, and the flights that can be made of them.

    Parameters
    ----------
    airspace
        The airspace of the scenario.
    make_trajectory
        Turns a path into a trajectory.

    Attributes
    ----------
    semi_axis_xy, semi_axis_z
        (n, n) the ellipsoid's semi-axes that count between each two of the n UAVs, metres.
    is_dynamic
        Whether there are movers, or zones with active times, which count as movers that stand still for a while.
    end
        Seconds into the mission until which UAVs must be clear of movers where they have arrived.
    tries, most_tries
        Detours, and searches in space and time, that brought no earlier arrival so far; and after how many of them
        little more is tried only to arrive earlier.
    effort, most_effort
        States that were expanded in space and time so far, each counted as often as there were flights and movers to
        stay clear of; and after how many little more is tried only to arrive earlier.
    """

    def __init__(self, airspace: Airspace, make_trajectory: MakeTrajectory) -> None:
        self.airspace, self.scenario = airspace, airspace.scenario
        self.make_trajectory = make_trajectory
        self._store = CurveStore()
        self.semi_axis_xy, self.semi_axis_z = semi_axes(self.scenario)
        self._gates: dict[tuple[int, int], tuple[list[Gate], Floats, Floats]] = {}
        self._detours: dict[tuple[int, Gate], Candidate | None] = {}
        self._problems: dict[tuple[int, int], Problem] = {}
        self._shapes: dict[tuple[TrackingError, frozenset[int]], MovingShapes] = {}
        self._heeding: dict[tuple[int, int, frozenset[int]], Candidate | None] = {}
        self.is_dynamic = is_dynamic(self.scenario)
        self._parked: dict[int, Candidate] = {}
        self.end = 0.0
        self.tries, self.most_tries = 0, 0
        self.effort, self.most_effort = 0, 0

    @property
    def spent(self) -> bool:
        """Whether little more is to be tried only to arrive earlier."""
        return self.tries >= self.most_tries or self.effort >= self.most_effort

    def add_planned(
        self, uav: int, target: int | None, result: Result | None, trajectory: Trajectory | None
    ) -> Candidate:
        """Return the candidate of a UAV's planned path; without a trajectory the UAV stays at its start."""
        if trajectory is None:
            return self.add(uav, None, result, stay_at_start(self.scenario.uavs[uav]))
        return self.add(uav, target, result, trajectory)

    def add(self, uav: int, target: int | None, result: Result | None, trajectory: Trajectory, **how: Any) -> Candidate:
        """Return a new candidate; `how` are further attributes of it."""
        curve = self._store.add(trajectory)
        return Candidate(uav, target, curve, self._store.seconds[curve], result, trajectory, **how)

    def traffic(self, candidate: Candidate, placed: Sequence[PlacedFlight]) -> Traffic:
        """Return the flights that are already placed, as a candidate's UAV sees them."""
        uavs = np.array([flight.candidate.uav for flight in placed], dtype=np.int64)
        curve = np.array([flight.candidate.curve for flight in placed], dtype=np.int64)
        departure, time_scale = np.array([p.departure for p in placed]), np.array([p.time_scale for p in placed])
        xy, z = self.semi_axis_xy[candidate.uav, uavs], self.semi_axis_z[candidate.uav, uavs]
        close_ends = np.zeros(len(placed), np.bool_)
        for theirs, own in (
            ([p.candidate.start for p in placed], candidate.start),
            ([p.candidate.end for p in placed], candidate.end),
        ):
            close_ends |= ellipsoid_holds(np.array(theirs).reshape(-1, 3) - own, xy, z, CLOSE_ENDS)
        return Traffic(Schedule(curve, departure, time_scale), xy, z, close_ends)

    def parked(self, uav: int) -> PlacedFlight:
        """Return the flight of a UAV that is still at its start."""
        if uav not in self._parked:
            self._parked[uav] = self.add_planned(uav, None, None, None)
        return PlacedFlight(self._parked[uav], 0.0)

    def too_near(self, uav: int, place: Floats, other: Floats) -> bool:
        """Tell whether two places, (3,) metres, are nearer to each other than a UAV and any other may be."""
        return bool(ellipsoid_holds(place - other, self.semi_axis_xy[uav].max(), self.semi_axis_z[uav].max()))

    def others(self, candidate: Candidate, placed: Sequence[PlacedFlight]) -> Others:
        """Return the flights that a candidate's UAV must stay clear of, for a search in space and time."""
        flights = self.traffic(candidate, placed)
        kept = flights.semi_axis_xy > 0.0
        curve, departure, time_scale = flights.schedule
        schedule = Schedule(curve[kept], departure[kept], time_scale[kept])
        semi_axes = np.column_stack(flights[1:3])[kept]
        return make_others(self._store.arrays, schedule, semi_axes, self._movers(candidate), self.end + LOOK_AHEAD)

    def is_clear(self, candidate: Candidate, flown: Trajectory, departure: float, traffic: Traffic) -> bool:
        """Tell whether a candidate's UAV could fly along a trajectory from an instant on without a conflict."""
        tried = self.add(candidate.uav, candidate.target, None, flown)
        in_conflict = self.conflicts(tried, departure, traffic)
        self._store.drop_last()
        return not in_conflict.any()

    def conflicts(self, candidate: Candidate, departure: float, traffic: Traffic) -> Bools:
        """Tell with whom a candidate is in conflict if it departs at an instant.

        Returns
        -------
        (n + m,)
            Of the n flights of the traffic, and then of the m movers that matter to the candidate.
        """
        swept = self._store.arrays
        own = TimedCurve(candidate.curve, departure, 1.0)
        flights = conflicting_flights(swept, traffic, own)
        if not self.is_dynamic:
            return flights
        return np.concatenate([flights, meets_movers(self._movers(candidate), swept.curves, own, self.end) < np.inf])

    def meets_movers(self, candidate: Candidate) -> bool:
        """Tell whether a candidate that departs at once comes too near to a mover."""
        return self.is_dynamic and bool((self._met(candidate) < np.inf).any())

    def zones_met(self, candidate: Candidate) -> frozenset[int]:
        """Return the numbers of the zones with active times that a candidate meets if it departs at once."""
        if not self.is_dynamic:
            return frozenset()
        shapes = timed_parts(self.scenario, candidate.heeds)
        met = zip(shapes, self._met(candidate).tolist(), strict=True)
        return frozenset(shape.zone for shape, when in met if shape.zone >= 0 and when < np.inf)

    def _met(self, candidate: Candidate) -> Floats:
        """Return when a candidate that departs at once first meets each mover, (m,) seconds, or infinity."""
        own = TimedCurve(candidate.curve, candidate.trajectory.start, 1.0)
        return meets_movers(self._movers(candidate), self._store.arrays.curves, own, self.end)

    def _movers(self, candidate: Candidate) -> MovingShapes:
        """Return the movers that matter to a candidate, for the tracking error of its UAV."""
        key = self.scenario.uavs[candidate.uav].tracking_error, candidate.heeds
        if key not in self._shapes:
            self._shapes[key] = moving_shapes(timed_parts(self.scenario, candidate.heeds), key[0])
        return self._shapes[key]

    def heeding(self, candidate: Candidate, zones: frozenset[int]) -> Candidate | None:
        """Return a candidate that heeds zones with active times at all times, or ``None`` where there is none.

        Its path leads around those that must not be entered, and it keeps the speed limits of the others. Where there
        are none to lead around, its path is that of the given candidate.
        """
        if candidate.target is None or candidate.result is None:
            return None
        key = candidate.uav, candidate.target, zones
        if key not in self._heeding:
            problem = self._problem(candidate.uav, candidate.target)
            within = with_zones_active(self.scenario, zones)
            if len(within.obstacles) == len(self.scenario.obstacles):
                slow = self.make_trajectory(Problem(Airspace(within), *key[:2]), candidate.result)
                found = None if slow is None else (candidate.result, slow)
            else:
                found = plan_among(problem, within, (), self.make_trajectory, any_angle=candidate.result.any_angle)
            self._heeding[key] = None if found is None else self.add(*key[:2], *found, heeds=zones)
        return self._heeding[key]

    def earliest_departure(
        self, candidate: Candidate, time_scale: float, traffic: Traffic, latest: float
    ) -> float | None:
        """Return the earliest instant, up to the latest, at which a candidate can depart without a conflict, if any."""
        free: Ints = free_departures(latest, candidate.trajectory.start)
        swept = self._store.arrays
        while True:
            found = earliest_departure(swept, traffic, candidate.curve, time_scale, free)
            if found < 0.0 or not self.is_dynamic:
                return None if found < 0.0 else found
            number, shapes = round(found / TICK), self._movers(candidate)
            clear = clear_departure(shapes, swept.curves, candidate.curve, time_scale, self.end, number, free)
            if clear == number:
                return found

    def ranked_gates(
        self, candidate: Candidate, share: float, traffic: Traffic, latest: float
    ) -> list[tuple[float, Gate]]:
        """Return the gates that may lead a candidate around the traffic, by estimated arrival.

        Parameters
        ----------
        candidate
            The flight to be led around.
        share
            Of its time, after which it is in conflict.
        traffic
            The others.
        latest
            The latest arrival, seconds.

        Returns
        -------
        list
            Pairs of estimated arrival, seconds, and gate.
        """
        part = min(max(round(share * GATE_PARTS), 1), GATE_PARTS - 1)
        key = candidate.curve, part
        if key not in self._gates:
            self._gates[key] = gates_beside(self.airspace, candidate, part / GATE_PARTS)
        gates, offsets, ratios = self._gates[key]
        start, share = candidate.trajectory.start, part / GATE_PARTS
        arrivals = estimate_detours(self._store.arrays, traffic, candidate.curve, offsets, ratios, share, start, latest)
        if self.is_dynamic:
            passed = start + share * candidate.seconds * ratios
            centres = np.array([gate.centre for gate in gates]).reshape(-1, 3)
            gaps = mover_gaps(self._movers(candidate), passed, centres)
            arrivals = np.where((gaps < 0.0).any(axis=0), np.inf, arrivals)  # a mover is there when the UAV comes
        order = [k for k in np.argsort(arrivals, kind="stable").tolist() if arrivals[k] < np.inf]
        return [(float(arrivals[k]), gates[k]) for k in order]

    def detour(self, candidate: Candidate, gate: Gate) -> Candidate | None:
        """Return a candidate that leads through one more gate, or ``None`` where there is no path through it.

        It is on the lattice where the given one is, so that the costs of a fleet stay in one unit.
        """
        key = candidate.curve, gate
        if key not in self._detours:
            assert candidate.target is not None
            assert candidate.result is not None
            gates = (*candidate.gates, gate)
            problem = self._problem(candidate.uav, candidate.target)
            within = with_zones_active(self.scenario, candidate.heeds) if candidate.heeds else self.scenario
            found = plan_detour(problem, within, gates, self.make_trajectory, any_angle=candidate.result.any_angle)
            more: dict[str, Any] = {"gates": gates, "heeds": candidate.heeds}
            self._detours[key] = None if found is None else self.add(candidate.uav, candidate.target, *found, **more)
        return self._detours[key]

    def _problem(self, uav: int, target: int) -> Problem:
        """Return the problem of a UAV and a target, which keeps its exact answer for further detours."""
        if (uav, target) not in self._problems:
            self._problems[uav, target] = Problem(self.airspace, uav, target)
        return self._problems[uav, target]

    def middle_conflict(self, candidate: Candidate, traffic: Traffic) -> float | None:
        """Return when, as a share of its time, a candidate that departs at once is in conflict in flight.

        Of several conflicts the median is returned, and ``None`` if all of them are before or after the flight.
        """
        departure = candidate.trajectory.start
        shares = [(when - departure) / candidate.seconds for when in self._meetings(candidate, traffic)]
        within = sorted(share for share in shares if 0.0 < share < 1.0)
        return within[len(within) // 2] if within else None

    def first_conflict(self, candidate: Candidate, traffic: Traffic) -> float | None:
        """Return when a candidate that departs at once is first in conflict, seconds into the mission, if it ever is.

        That is before its departure where it is in the way of others before, and after its arrival where it is then.
        """
        if not self.conflicts(candidate, candidate.trajectory.start, traffic).any():
            return None
        return min(self._meetings(candidate, traffic), default=candidate.trajectory.start + candidate.seconds)

    def _meetings(self, candidate: Candidate, traffic: Traffic) -> list[float]:
        """Return when a candidate that departs at once is in conflict with each flight and mover until it arrives."""
        curves = self._store.arrays.curves
        schedule, xy, z, _ = traffic
        departure = candidate.trajectory.start
        end = departure + candidate.seconds
        meetings: list[float] = []
        own = TimedCurve(candidate.curve, departure, 1.0)
        in_conflict = self.conflicts(candidate, departure, traffic)
        flights = len(schedule.curve)
        if in_conflict[flights:].any():
            met = meets_movers(self._movers(candidate), curves, own, end)
            meetings += met[met < np.inf].tolist()
        for p in np.flatnonzero(in_conflict[:flights]):
            other = TimedCurve(int(schedule.curve[p]), float(schedule.departure[p]), float(schedule.time_scale[p]))
            spans = conflict_spans(curves, other, own, float(xy[p]), float(z[p]), end, False)
            meetings += spans[:, 2].tolist()
        return meetings
