"""One flight of a study among movers: planned, flown by a policy, judged by the referee and summarised in one row."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyverse._typing import Floats
from skyverse.lab.code_digest import code_digest, digest, settings_of, versions
from skyverse.lab.hindsight import least_lengths, least_seconds
from skyverse.lab.moving_row import MovingRow
from skyverse.live.closed_loop import fly_closed_loop
from skyverse.live.policies.policy import Policy
from skyverse.live.policy_flight import PolicyFlight
from skyverse.live.replan import Replan
from skyverse.live.replanner import Replanner
from skyverse.mission.plan_mission import plan_mission
from skyverse.model.mission import Mission
from skyverse.model.quantities import derived
from skyverse.model.result import Effort
from skyverse.model.scenario import Scenario
from skyverse.model.sensor import Sensor
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Fault, Violation
from skyverse.referee.mission import judge_fleet
from skyverse.referee.world import RefereeWorlds
from skyverse.samples.movers import MoverKind, random_movers
from skyverse.space.moving_shapes import mover_gaps, moving_shapes
from skyverse.space.timed_shapes import timed_shapes

SAMPLE = 0.01
"""Seconds between the instants at which distances from movers are measured; the verdict is the referee's."""
STAY = 1.0
"""Seconds after the last arrival for which UAVs must keep clear of movers where they are, as the referee asks."""


@dataclass(frozen=True, kw_only=True)
class OwnReplanner:
    """The `Replanner` as it is, with how many motions it tries for a UAV at most at each observation."""

    candidates: int = 128

    def __post_init__(self) -> None:
        if isinstance(self.candidates, bool) or not isinstance(self.candidates, int) or self.candidates < 1:
            raise ValueError(f"candidates is a whole number from 1 on, not {self.candidates!r}")


@dataclass(frozen=True, kw_only=True)
class KnownBeforehand:
    """No replanning: the mission is planned among all movers and obstacles, which are known beforehand."""


Contender = Policy | OwnReplanner | KnownBeforehand


@dataclass(frozen=True, eq=False)
class MovingCase:
    """A scenario, the movers that are seen in flight, and what sees them.

    Attributes
    ----------
    label, movers_label
        How the study calls the scenario and the movers.
    scenario
        As it is given. Its own movers are not known beforehand either.
    kind, count, speed
        Those of `random_movers`, which a run's seed makes.
    hidden
        How many of the scenario's obstacles nobody knows of beforehand; the seed draws which.
    sensor
        What UAVs see with.
    longest
        Seconds after which a flight is given up.
    """

    label: str
    movers_label: str
    scenario: Scenario
    kind: MoverKind
    count: int
    speed: float
    hidden: int
    sensor: Sensor
    longest: float

    @cached_property
    def digest(self) -> str:
        """A digest of all but the labels."""
        rest = (self.kind, self.count, self.speed, self.hidden, repr(self.sensor), self.longest)
        return digest(self.scenario.digest, *rest)

    def truth(self, seed: int) -> Scenario:
        """Return the scenario with all that there is."""
        return random_movers(self.scenario, self.count, kind=self.kind, speed=self.speed, seed=seed)

    def known(self, seed: int) -> Scenario:
        """Return the scenario with what is known beforehand."""
        obstacles = self.scenario.obstacles
        chosen = np.random.default_rng([seed, 1]).permutation(len(obstacles))[: self.hidden].tolist()
        left = tuple(one for k, one in enumerate(obstacles) if k not in chosen)
        return derived(self.scenario, obstacles=left, movers=())


@dataclass(frozen=True, eq=False)
class MovingJob:
    """One flight to be made; `label` is the contender's in the study."""

    case: MovingCase
    contender: Contender
    label: str
    seed: int

    @property
    def run(self) -> tuple[str, str, str, int]:
        """The labels of scenario, movers and policy, and the seed, which identify the flight in its study."""
        return self.case.label, self.case.movers_label, self.label, self.seed

    @property
    def made_by(self) -> Contender:
        """What finds the ways."""
        return self.contender

    @cached_property
    def code(self) -> str:
        """The digest of the code that makes the flight, in the process that asks for it."""
        return code_digest(self.made_by)

    @cached_property
    def key(self) -> str:
        """A digest of the labels and of all that determines the answer, including the code."""
        return digest(*self.run, self.case.digest, settings_of(self.made_by), self.code)

    def row(self) -> MovingRow:
        """Fly, and return the row of the flight."""
        return fly_job(self)

    def shortened(self) -> "MovingJob":
        """Return the same flight, given up after half a second."""
        return replace(self, case=replace(self.case, longest=0.5))

    def __str__(self) -> str:
        return "{}, {}, {}, seed {}".format(*self.run)


@dataclass(frozen=True, eq=False)
class _Flown:
    """What was flown: the arrival is ``None`` where not all UAVs arrived."""

    mission: Mission
    trajectories: tuple[Trajectory | None, ...]
    arrival: float | None
    answers: Sequence[Replan]
    milliseconds: Sequence[float]
    effort: Effort


def fly_job(job: MovingJob) -> MovingRow:
    """Plan the mission with what is known, fly it by the contender among what there is, and judge it."""
    truth, known = job.case.truth(job.seed), job.case.known(job.seed)
    flown = _known_beforehand(truth) if isinstance(job.contender, KnownBeforehand) else _replanned(job, truth, known)
    return _row(job, truth, flown)


def _known_beforehand(truth: Scenario) -> _Flown:
    began = time.perf_counter()
    mission = plan_mission(truth, workers=1)
    took = 1e3 * (time.perf_counter() - began)
    wanted = [k for k, target in enumerate(mission.assignment) if target is not None]
    flown = mission.trajectories
    ends = [None if flown[k] is None else flown[k].end for k in wanted]  # type: ignore[union-attr]
    certificates = [mission.certificates[k] for k in wanted] if mission.certificates else []
    proven = bool(certificates) and all(one is not None and one.verdict.value == "proven" for one in certificates)
    arrived = proven and None not in ends
    arrival = max((end for end in ends if end is not None), default=0.0) if arrived else None
    return _Flown(mission, flown, arrival, (), (took,), Effort(0, 0, 0))


def _replanned(job: MovingJob, truth: Scenario, known: Scenario) -> _Flown:
    mission = _planned(known.digest, known)
    flight: Replanner | PolicyFlight
    flight = own = Replanner(
        mission, candidates=job.contender.candidates if isinstance(job.contender, OwnReplanner) else 1
    )
    if isinstance(job.contender, Policy):
        rng = np.random.default_rng([job.seed, 2])
        flight = PolicyFlight(mission, job.contender, horizon=own.horizon, lead=own.lead, memory=own.memory, rng=rng)
    answers: list[Replan] = []
    arrived = fly_closed_loop(
        flight, truth, job.case.sensor, longest=job.case.longest, rng=job.seed, on_answers=answers.extend
    )
    uavs = range(len(known.uavs))
    ends = [flight.arrival(uav) for uav in uavs if mission.assignment[uav] is not None]
    arrival = max((end for end in ends if end is not None), default=0.0) if arrived else None
    effort = flight.effort if isinstance(flight, PolicyFlight) else Effort(0, 0, sum(one.tried for one in answers))
    flown = tuple(flight.flown(uav) for uav in uavs)
    return _Flown(mission, flown, arrival, answers, [1e3 * one.seconds for one in answers], effort)


_missions: dict[str, Mission] = {}


def _planned(digest: str, known: Scenario) -> Mission:
    """Return the mission among what is known; the last few are kept."""
    if digest not in _missions:
        while len(_missions) >= 8:
            del _missions[next(iter(_missions))]
        _missions[digest] = plan_mission(known, workers=1)
    return _missions[digest]


_lengths: dict[tuple[str, tuple[int | None, ...]], list[float]] = {}


def _row(job: MovingJob, truth: Scenario, flown: _Flown) -> MovingRow:
    scenario, movers, policy, seed = job.run
    assignment = flown.mission.assignment
    still = derived(truth, movers=())
    lengths = _least_lengths(job.case.digest, assignment, still)
    bound = max(least_seconds(length, uav) for length, uav in zip(lengths, truth.uavs, strict=True))
    arrived = flown.arrival is not None
    last = job.case.longest if flown.arrival is None else flown.arrival
    length = sum(_length(one, last) for one in flown.trajectories if one is not None)
    gaps = _gaps(truth, flown.trajectories, last + STAY)
    wrong = _violations(truth, flown, arrived)
    return MovingRow(
        scenario,
        movers,
        policy,
        seed,
        arrived=arrived,
        safe=not wrong,
        contacts=int(np.count_nonzero(gaps < 0.0)),
        least_gap=float(gaps.min(initial=np.inf)),
        seconds=last,
        seconds_bound=bound,
        time_ratio=last / bound if arrived and bound > 0.0 else np.inf,
        length=length,
        length_bound=sum(lengths),
        length_ratio=length / sum(lengths) if arrived and sum(lengths) > 0.0 else np.inf,
        replans=len(flown.answers),
        unproven=sum(not one.proven for one in flown.answers),
        milliseconds=float(np.median(flown.milliseconds)),
        milliseconds_99=float(np.percentile(flown.milliseconds, 99)),
        milliseconds_worst=max(flown.milliseconds),
        generated_paths=flown.effort.generated_paths,
        generated_nodes=flown.effort.generated_nodes,
        evaluations=flown.effort.evaluations,
        verdict=" ".join(one.message for one in wrong),
        settings=settings_of(job.contender),
        versions=versions(job.made_by),
    )


def _least_lengths(digest: str, assignment: tuple[int | None, ...], still: Scenario) -> list[float]:
    if (digest, assignment) not in _lengths:
        while len(_lengths) >= 8:
            del _lengths[next(iter(_lengths))]
        _lengths[digest, assignment] = least_lengths(still, assignment)
    return _lengths[digest, assignment]


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
            shapes = moving_shapes(timed_shapes(truth), uav.tracking_error)
            places = flown.at(np.clip(instants, flown.start, flown.end)).position
            found.append(mover_gaps(shapes, instants, places).min(axis=1))
    return np.concatenate(found)
