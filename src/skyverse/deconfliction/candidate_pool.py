"""All candidates of a fleet that have come up so far, and what is asked of them: delays, conflicts, detours."""

from collections.abc import Sequence

import numpy as np

from skyverse._typing import Bools, Ints
from skyverse.deconfliction.among_movers import clear_departure, meets_movers
from skyverse.deconfliction.candidate import Candidate, Gate, PlacedFlight
from skyverse.deconfliction.curve_store import CurveStore
from skyverse.deconfliction.curves import Schedule, TimedCurve, stay_at_start
from skyverse.deconfliction.detours import MakeTrajectory, RankedGates, gates_beside, plan_detour
from skyverse.deconfliction.find_conflicts import semi_axes
from skyverse.deconfliction.forbidden_departures import TICK, free_departures
from skyverse.deconfliction.pair_conflicts import conflict_spans
from skyverse.deconfliction.traffic import Traffic, conflicting_flights, earliest_departure, estimate_detours
from skyverse.model.result import Result
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import TrackingError
from skyverse.problem import Airspace, Problem
from skyverse.space.moving_shapes import MovingShapes, mover_gaps, moving_shapes
from skyverse.stop import Stop

CLOSE_ENDS = 1.05
"""Starts, or targets, are close where their distance is below so many separations."""
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
    stop
        A rule that can end the search, if it is `Cancelled`.

    Attributes
    ----------
    semi_axis_xy, semi_axis_z
        (n, n) the ellipsoid's semi-axes that count between each two of the n UAVs, metres.
    end
        Seconds into the mission until which UAVs must be clear of movers where they have arrived.
    """

    def __init__(self, airspace: Airspace, make_trajectory: MakeTrajectory, stop: Stop | None = None) -> None:
        self.airspace, self.scenario = airspace, airspace.scenario
        self.make_trajectory, self._stop = make_trajectory, stop
        self._store = CurveStore()
        self.semi_axis_xy, self.semi_axis_z = semi_axes(self.scenario)
        self._gates: dict[tuple[int, int], RankedGates] = {}
        self._detours: dict[tuple[int, Gate], Candidate | None] = {}
        self._problems: dict[tuple[int, int], Problem] = {}
        self._shapes: dict[TrackingError, MovingShapes] = {}
        self.end = 0.0

    @property
    def cancelled(self) -> bool:
        """Whether the search is to end with what it has."""
        return self._stop is not None and self._stop.cancelled

    def add_planned(
        self, uav: int, target: int | None, result: Result | None, trajectory: Trajectory | None
    ) -> Candidate:
        """Return the candidate of a UAV's planned path; without a trajectory the UAV stays at its start."""
        flown = stay_at_start(self.scenario.uavs[uav]) if trajectory is None else trajectory
        return self._add(uav, None if trajectory is None else target, result, flown)

    def _add(
        self, uav: int, target: int | None, result: Result | None, trajectory: Trajectory, gates: tuple[Gate, ...] = ()
    ) -> Candidate:
        curve = self._store.add(trajectory)
        return Candidate(uav, target, curve, self._store.seconds[curve], result, trajectory, gates)

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
            gap = (np.array(theirs).reshape(-1, 3) - own) ** 2
            close_ends |= (gap[:, 0] + gap[:, 1]) * z**2 + gap[:, 2] * xy**2 < (CLOSE_ENDS * xy * z) ** 2
        return Traffic(Schedule(curve, departure, time_scale), xy, z, close_ends)

    def conflicts(self, candidate: Candidate, departure: float, traffic: Traffic) -> Bools:
        """Tell with whom a candidate is in conflict if it departs at an instant.

        Returns
        -------
        (n + m,)
            Of the n flights of the traffic, and then of the scenario's m movers.
        """
        curves, trees = self._store.arrays
        own = TimedCurve(candidate.curve, departure, 1.0)
        flights = conflicting_flights(curves, trees, traffic, own)
        if not self.scenario.movers:
            return flights
        return np.concatenate([flights, meets_movers(self._movers(candidate.uav), curves, own, self.end) < np.inf])

    def meets_movers(self, candidate: Candidate) -> bool:
        """Tell whether a candidate that departs at once comes too near to a mover."""
        if not self.scenario.movers:
            return False
        own = TimedCurve(candidate.curve, candidate.trajectory.start, 1.0)
        return bool(
            (meets_movers(self._movers(candidate.uav), self._store.arrays.curves, own, self.end) < np.inf).any()
        )

    def _movers(self, uav: int) -> MovingShapes:
        """Return the movers, for the tracking error of a UAV."""
        error = self.scenario.uavs[uav].tracking_error
        if error not in self._shapes:
            self._shapes[error] = moving_shapes(self.scenario.movers, self.scenario.clearance, error)
        return self._shapes[error]

    def earliest_departure(
        self, candidate: Candidate, time_scale: float, traffic: Traffic, latest: float
    ) -> float | None:
        """Return the earliest instant, up to the latest, at which a candidate can depart without a conflict, if any."""
        free: Ints = free_departures(latest, candidate.trajectory.start)
        curves, trees = self._store.arrays
        while True:
            found = earliest_departure(curves, trees, traffic, candidate.curve, time_scale, free)
            if found < 0.0 or not self.scenario.movers:
                return None if found < 0.0 else found
            number, shapes = round(found / TICK), self._movers(candidate.uav)
            clear = clear_departure(shapes, curves, candidate.curve, time_scale, self.end, number, free)
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
        curves, trees = self._store.arrays
        arrivals = estimate_detours(
            curves,
            trees,
            traffic,
            candidate.curve,
            offsets,
            ratios,
            part / GATE_PARTS,
            candidate.trajectory.start,
            latest,
        )
        if self.scenario.movers:
            passed = candidate.trajectory.start + part / GATE_PARTS * candidate.seconds * ratios
            centres = np.array([gate.centre for gate in gates]).reshape(-1, 3)
            gaps = mover_gaps(self._movers(candidate.uav), passed, centres)
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
            found = plan_detour(problem, gates, self.make_trajectory, any_angle=candidate.result.any_angle)
            self._detours[key] = None if found is None else self._add(candidate.uav, candidate.target, *found, gates)
        return self._detours[key]

    def _problem(self, uav: int, target: int) -> Problem:
        """Return the problem of a UAV and a target, which keeps its exact answer for further detours."""
        if (uav, target) not in self._problems:
            self._problems[uav, target] = Problem(self.airspace, uav, target)
        return self._problems[uav, target]

    def middle_conflict(self, candidate: Candidate, traffic: Traffic, in_conflict: Bools) -> float | None:
        """Return when, as a share of its time, a candidate that departs at once is in conflict in flight.

        Of several conflicts the median is returned, and ``None`` if all of them are before or after the flight.

        Parameters
        ----------
        candidate
            The flight.
        traffic
            The others.
        in_conflict
            As from `conflicts`.
        """
        curves = self._store.arrays.curves
        schedule, xy, z, _ = traffic
        shares: list[float] = []
        departure = candidate.trajectory.start
        end = departure + candidate.seconds
        own = TimedCurve(candidate.curve, departure, 1.0)
        flights = len(schedule.curve)
        if in_conflict[flights:].any():
            met = meets_movers(self._movers(candidate.uav), curves, own, end)
            shares += [(when - departure) / candidate.seconds for when in met[met < np.inf].tolist()]
        for p in np.flatnonzero(in_conflict[:flights]):
            other = TimedCurve(int(schedule.curve[p]), float(schedule.departure[p]), float(schedule.time_scale[p]))
            spans = conflict_spans(curves, other, own, float(xy[p]), float(z[p]), end, False)
            shares += [(when - departure) / candidate.seconds for when in spans[:, 2].tolist()]
        within = sorted(share for share in shares if 0.0 < share < 1.0)
        return within[len(within) // 2] if within else None
