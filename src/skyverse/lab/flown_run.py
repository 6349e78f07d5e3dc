"""One flight of a study among movers: planned, flown, judged, and summarised in one row beside its lower bounds."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.code_versions import settings_of, versions
from skyverse.lab.job import Case, Job, KnownBeforehand, OwnReplanner
from skyverse.lab.row import Row
from skyverse.live.closed_loop import fly_closed_loop
from skyverse.live.policies.policy import Policy
from skyverse.live.replan import Replan
from skyverse.live.replanner import Replanner
from skyverse.mission.plan_mission import plan_mission
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Effort, no_history
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV
from skyverse.model.verdict import Fault, Verdict, Violation
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem
from skyverse.referee.mission import judge_fleet
from skyverse.referee.world import RefereeWorlds
from skyverse.space.timed_shapes import mover_gaps, moving_shapes, timed_parts

SAMPLE = 0.01
"""Seconds between the instants at which distances from movers are measured; the verdict is the referee's."""
STAY = 1.0
"""Seconds after the last arrival for which UAVs must keep clear of movers where they are, as the referee asks."""


@dataclass(frozen=True, eq=False)
class _Flown:
    """What was flown: the arrival is ``None`` where not all UAVs arrived."""

    mission: Mission
    trajectories: tuple[Trajectory | None, ...]
    arrival: float | None
    answers: Sequence[Replan]
    milliseconds: Sequence[float]
    effort: Effort


def planned(case: Case) -> Mission:
    """Return the mission of a case as it is planned, without what is met."""
    return plan_mission(case.scenario, assignment=case.assignment, workers=1)


def least_lengths(case: Case, assignment: tuple[int | None, ...]) -> list[float]:
    """Return a lower bound of the length that each UAV must fly to its target, metres; 0 without a target.

    A path is no shorter among movers than among what stands still, so that `Taut`'s proven bound of its length holds.
    """
    airspace, fuel = Airspace(case.scenario), case.scenario.objective.fuel
    found = []
    for uav, target in enumerate(assignment):
        if target is None:
            found.append(0.0)
            continue
        problem = Problem(airspace, uav, target)
        bound = Taut().plan(problem).bound  # a price, of metres that cost `fuel` each
        apart = math.dist(problem.uav_place, problem.target_place)
        found.append(max((bound or 0.0) / fuel, apart) if fuel > 0 else apart)
    return found


def fly_job(
    job: Job,
    mission_of: Callable[[Case], Mission] = planned,
    lengths_of: Callable[[Case, tuple[int | None, ...]], list[float]] = least_lengths,
) -> Row:
    """Plan the mission with what is known, fly it among what there is, replanned as the job says, and judge it.

    Flights of the same scenario may share missions and lengths: `planned` and `least_lengths` that keep what they
    found.
    """
    case = job.case
    assert case.encounters is not None
    truth = case.encounters.truth(case.scenario, job.seed)
    if isinstance(job.planner, KnownBeforehand):
        flown = _known_beforehand(truth, case)
    else:
        known = Case("", case.encounters.known(case.scenario, job.seed), case.assignment)
        flown = _replanned(job, truth, mission_of(known))
    return _row(job, truth, flown, lengths_of(Case("", derived(truth, movers=())), flown.mission.assignment))


def _known_beforehand(truth: Scenario, case: Case) -> _Flown:
    began = time.perf_counter()
    mission = plan_mission(truth, assignment=case.assignment, workers=1)
    took = 1e3 * (time.perf_counter() - began)
    wanted = [k for k, target in enumerate(mission.assignment) if target is not None]
    flown = mission.trajectories
    certificates = [mission.certificates[k] for k in wanted] if mission.certificates else []
    proven = bool(certificates) and all(one is not None and one.verdict is Verdict.PROVEN for one in certificates)
    ends = [None if (one := flown[k]) is None else one.end for k in wanted]
    return _Flown(mission, flown, _last(ends) if proven and None not in ends else None, (), (took,), Effort(0, 0, 0))


def _replanned(job: Job, truth: Scenario, mission: Mission) -> _Flown:
    asked = job.planner
    flight = Replanner(
        mission,
        policy=asked if isinstance(asked, Policy) else None,
        rng=np.random.default_rng([job.seed, 2]),
        **({"candidates": asked.candidates} if isinstance(asked, OwnReplanner) else {}),
    )
    answers: list[Replan] = []
    case, told = job.case, answers.extend
    arrived = fly_closed_loop(flight, truth, case.sensor, longest=case.longest, rng=job.seed, on_answers=told)
    uavs = range(len(truth.uavs))
    arrival = _last([flight.arrival(uav) for uav in uavs if mission.assignment[uav] is not None]) if arrived else None
    flown = tuple(flight.flown(uav) for uav in uavs)
    return _Flown(mission, flown, arrival, answers, [1e3 * one.seconds for one in answers], flight.effort)


def _last(ends: Sequence[float | None]) -> float:
    return max((end for end in ends if end is not None), default=0.0)


def _row(job: Job, truth: Scenario, flown: _Flown, lengths: Sequence[float]) -> Row:
    bound = max(least_seconds(length, uav) for length, uav in zip(lengths, truth.uavs, strict=True))
    arrived = flown.arrival is not None
    last = job.case.longest if flown.arrival is None else flown.arrival
    gaps = _gaps(truth, flown.trajectories, last + STAY)
    wrong = _violations(truth, flown, arrived)
    success = arrived and not wrong
    return Row(
        *job.run,
        status="arrived" if arrived else "not arrived",
        success=success,
        cost=last if success else np.inf,
        fuel=None,
        divergence=None,
        end=None,
        bound=bound,
        gap=last / bound - 1.0 if success and bound > 0.0 else None,
        generated_paths=flown.effort.generated_paths,
        generated_nodes=flown.effort.generated_nodes,
        evaluations=flown.effort.evaluations,
        iterations=0,
        seconds=1e-3 * sum(flown.milliseconds),
        stopped_by="",
        verdict=" ".join(one.message for one in wrong),
        settings=settings_of(job.planner),
        versions=versions(job.made_by),
        history=no_history(),
        flown_seconds=last,
        flown_length=sum(_length(one, last) for one in flown.trajectories if one is not None),
        least_length=sum(lengths),
        contacts=int(np.count_nonzero(gaps < 0.0)),
        least_gap=float(gaps.min(initial=np.inf)),
        replans=len(flown.answers),
        unproven=sum(not one.proven for one in flown.answers),
        milliseconds=float(np.median(flown.milliseconds)),
        milliseconds_99=float(np.percentile(flown.milliseconds, 99)),
        milliseconds_worst=max(flown.milliseconds),
    )


def _violations(truth: Scenario, flown: _Flown, arrived: bool) -> list[Violation]:
    """Return what the referee finds wrong; that a flight ends elsewhere is no fault where it is told to have."""
    judged = judge_fleet(RefereeWorlds(truth), replace(flown.mission, scenario=truth, trajectories=flown.trajectories))
    found = [one for violations in judged.trajectories for one in violations] + judged.apart
    return [one for one in found if arrived or one.fault is not Fault.TRAJECTORY_ENDS]


def _length(flown: Trajectory, last: float) -> float:
    """Return how many metres are flown, from a fine polyline, which is no longer than the curve."""
    instants = np.arange(flown.start, min(flown.end, last) + SAMPLE, SAMPLE)
    steps: Floats = np.diff(flown.at(np.minimum(instants, flown.end)).position, axis=0)
    return float(np.linalg.norm(steps, axis=1).sum())


def _gaps(truth: Scenario, trajectories: Sequence[Trajectory | None], last: float) -> Floats:
    """Return the least distance beyond what must be kept of each UAV from each mover, flattened, metres."""
    instants, found = np.arange(0.0, last, SAMPLE), [np.zeros(0)]
    for uav, flown in zip(truth.uavs, trajectories, strict=True):
        if flown is not None:
            shapes = moving_shapes(timed_parts(truth), uav.tracking_error)
            places = flown.at(np.clip(instants, flown.start, flown.end)).position
            found.append(mover_gaps(shapes, instants, places).min(axis=1))
    return np.concatenate(found)


def least_seconds(length: float, uav: UAV) -> float:
    """Return the least time in which a UAV can fly so many metres from rest to rest, whatever moves.

    A UAV begins and ends at rest, without acceleration. So t seconds after the beginning, and as long before the end,
    its acceleration is at most min(a, j t), where a and j are its largest acceleration and jerk, and its speed at most

        V(t) = j t^2 / 2                for t <= a / j,
        V(t) = a t - a^2 / (2 j)        after that,

    and never above its largest speed v. The least time T for a length L is the one for which the integral of
    min(v, V(t), V(T - t)) over 0 to T is L. On curved paths, too, no flight is faster.
    """
    if length <= 0.0:
        return 0.0
    low, high = 0.0, 1.0
    while _reach(high, uav) < length:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _reach(middle, uav) < length else (low, middle)
    return low


def _reach(seconds: float, uav: UAV) -> float:
    """Return how far at most a UAV gets from rest to rest in so many seconds, metres."""
    top, a, jerk = uav.max_speed, uav.max_acceleration, uav.max_jerk
    ramp = a / jerk
    fastest = math.sqrt(2.0 * top / jerk)  # the instant at which V(t) = v
    if fastest > ramp:
        fastest = top / a + 0.5 * ramp
    rising = min(0.5 * seconds, fastest)
    if rising <= ramp:
        covered = jerk * rising**3 / 6.0
    else:
        covered = jerk * ramp**3 / 6.0 + 0.5 * a * (rising**2 - ramp**2) - 0.5 * a * ramp * (rising - ramp)
    return 2.0 * covered + top * max(seconds - 2.0 * fastest, 0.0)
