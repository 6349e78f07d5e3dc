"""One run of a study: its mission planned, judged by the referee and summarised in one row."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from skyverse.lab.code_digest import code_digest, digest, settings_of, versions
from skyverse.lab.row import Row
from skyverse.mission.plan_mission import Assignment, assign_targets
from skyverse.model.result import History, Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Violation
from skyverse.planners.base import Planner
from skyverse.planners.objective import PathObjective, rescored
from skyverse.planners.own_path import require_result
from skyverse.problem import Airspace, Problem
from skyverse.referee import check_result
from skyverse.stop import MaxIterations, MaxPaths, MaxSeconds, Progress, Stop

_MIN_PILOT_PATHS = 200
"""The budget of the first pilot run, in paths, and the least budget of the second."""


@dataclass(frozen=True, eq=False)
class Case:
    """A scenario, its label, and the assignment of its targets. Cases with the same content are equal."""

    label: str
    scenario: Scenario
    assignment: Assignment = "path-cost"

    @cached_property
    def digest(self) -> str:
        """A digest of scenario and assignment, without the label."""
        return digest(self.scenario.digest, self.assignment)

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, Case) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)


@dataclass(frozen=True, eq=False)
class Job:
    """One run to be made.

    Attributes
    ----------
    case
        The scenario; jobs on the same scenario should share one case.
    planner, label
        The planner, and its label in the study.
    stop, budget
        The rule that ends each UAV's search, and its label. `MaxSeconds` alone is turned into paths by a pilot run.
    seed
        The search of a single UAV gets ``rng=seed``; those of several get a random stream each, as in
        `plan_mission`.
    objective
        An objective of one's own by which the results of all planners are priced.
    """

    case: Case
    planner: Planner
    label: str
    stop: Stop
    budget: str
    seed: int
    objective: PathObjective | None = None

    @property
    def run(self) -> tuple[str, str, str, int]:
        """The labels of scenario, planner and budget, and the seed, which identify the run in its study."""
        return self.case.label, self.label, self.budget, self.seed

    @property
    def made_by(self) -> tuple[Planner, PathObjective | None]:
        """What makes the run."""
        return self.planner, self.objective

    @cached_property
    def code(self) -> str:
        """The digest of the code that makes the run, in the process that asks for it."""
        return code_digest(self.made_by)

    @cached_property
    def key(self) -> str:
        """A digest of the labels and of all that determines the answer, including the code."""
        return digest(*self.run, self.case.digest, settings_of(self.made_by), repr(self.stop), self.code)

    def row(self) -> Row:
        """Make the run and return its row."""
        return run_job(self)

    def shortened(self) -> "Job":
        """Return the same run with one iteration."""
        return replace(self, stop=MaxIterations(1))

    def __str__(self) -> str:
        return "{}, {}, {}, seed {}".format(*self.run)


def run_job(job: Job) -> Row:
    """Assign targets, plan and judge; the problems of a scenario are kept for the next job on it."""
    problems = problems_of(job.case)
    count = len(job.case.scenario.uavs)
    streams = np.random.default_rng(job.seed).spawn(count) if count > 1 else [job.seed]
    results = []
    violations: list[Violation] = []
    for problem in problems:
        stop = job.stop if job.stop.spent(Progress()) is not None else _counted(job, problem)
        result = require_result(job.planner.plan(problem, stop=stop, rng=streams[problem.uav]))
        violations += check_result(job.case.scenario, problem.uav, problem.target, result)
        results.append(result if job.objective is None else rescored(problem, job.objective, result))
    return _row(job, results, violations)


@lru_cache(maxsize=4)
def problems_of(case: Case) -> tuple[Problem, ...]:
    """Return the problem of each UAV of a case that has a target."""
    airspace = Airspace(case.scenario)
    assigned = assign_targets(airspace, case.assignment)
    return tuple(Problem(airspace, uav, target) for uav, target in enumerate(assigned) if target is not None)


_rates: dict[tuple[str, str, int, str], float] = {}


def _counted(job: Job, problem: Problem) -> Stop:
    """Return a budget of paths for one of seconds, at the rate that pilot runs of this planner on this problem show.

    The rate changes during a schedule, so the second pilot run is about as long as the run itself, but at most 1 s.
    """
    if not isinstance(job.stop, MaxSeconds):
        return job.stop
    seconds = job.stop.seconds
    which = (job.case.digest, settings_of(job.planner), problem.uav, repr(job.stop))
    if which not in _rates:
        paths = _MIN_PILOT_PATHS
        for _ in range(2):
            pilot = job.planner.plan(problem, stop=MaxPaths(paths) | MaxSeconds(max(1.0, seconds)), rng=0)
            _rates[which] = max(pilot.effort.generated_paths, 1) / max(pilot.seconds, 1e-9)
            if pilot.stopped_by == "finished":  # an exact planner ends before its budget
                break
            paths = max(_MIN_PILOT_PATHS, int(_rates[which] * min(1.0, seconds)))
    return MaxPaths(max(1, round(_rates[which] * seconds))) | job.stop


def _row(job: Job, results: Sequence[Result], violations: Sequence[Violation]) -> Row:
    scenario, planner, budget, seed = job.run
    status = max((r.status for r in results), key=list(Status).index, default=Status.NOT_PLANNED)
    success = bool(results) and all(result.status.reached for result in results)
    cost = sum(result.cost for result in results) if results else float("inf")
    bounds = [result.bound for result in results if result.bound is not None]
    bound = sum(bounds) if results and len(bounds) == len(results) else None
    gap = None
    if success and bound is not None and (bound > 0 or cost == bound):
        gap = cost / bound - 1.0 if bound > 0 else 0.0
    return Row(
        scenario,
        planner,
        budget,
        seed,
        status=status.value,
        success=success,
        cost=float(cost),
        fuel=sum((result.terms.get("fuel", 0.0) for result in results), 0.0),
        divergence=sum((result.terms.get("divergence", 0.0) for result in results), 0.0),
        end=sum((result.terms.get("end", 0.0) for result in results), 0.0),
        bound=bound,
        gap=gap,
        generated_paths=sum(result.effort.generated_paths for result in results),
        generated_nodes=sum(result.effort.generated_nodes for result in results),
        evaluations=sum(result.effort.evaluations for result in results),
        iterations=sum(int(result.history.iteration.max(initial=0)) for result in results),
        seconds=sum((result.seconds for result in results), 0.0),
        stopped_by=", ".join(dict.fromkeys(result.stopped_by for result in results)),
        verdict=" ".join(violation.message for violation in violations),
        settings=settings_of(job.planner),
        versions=versions(job.made_by),
        history=_history(results),
    )


def _history(results: Sequence[Result]) -> History:
    """Return the history of one UAV, or add up those of several, iteration by iteration.

    A shorter one repeats its last row, an empty one counts its final cost.
    """
    if len(results) == 1:
        return results[0].history
    found = [result.history.by_iteration() for result in results]
    length = max((len(history.cost) for history in found), default=0)
    totals = [np.zeros(length), *np.zeros((3, length), np.int64)]
    for result, history in zip(results, found, strict=True):
        missing = length - len(history.cost)
        for total, column, final in zip(totals, astuple(history), (result.cost, 0, 0, 0), strict=False):
            total += np.pad(column, (0, missing), mode="edge") if missing < length else final
    return History(*totals)
