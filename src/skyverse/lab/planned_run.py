"""One run of a study: its mission planned, judged by the referee and summarised in one row."""

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from skyverse.cost import wrong_figures
from skyverse.lab.code_versions import settings_of, versions
from skyverse.lab.job import Case, Job
from skyverse.lab.row import Row
from skyverse.mission.assignment import assign_targets
from skyverse.model.result import History, Result, Status
from skyverse.planners.base import Planner
from skyverse.planners.objective import rescored
from skyverse.planners.own_path import require_result
from skyverse.problem import Airspace, Problem
from skyverse.referee import check_result
from skyverse.stop import MaxPaths, MaxSeconds, Stop

_MIN_PILOT_PATHS = 200
"""The budget of the first pilot run, in paths, and the least budget of the second."""


Rates = dict[tuple[str, str, int, str], float]
"""The paths that planners generate in a second, by case, settings, UAV and stop rule."""


def plan_job(job: Job, problems: Sequence[Problem] | None = None, rates: Rates | None = None) -> Row:
    """Assign targets, plan and judge.

    Runs of the same case may share its `problems`, and those of the same planner the `rates` that pilot runs showed.
    """
    assert isinstance(job.planner, Planner)
    count = len(job.case.scenario.uavs)
    streams = np.random.default_rng(job.seed).spawn(count) if count > 1 else [job.seed]
    results = []
    complaints: list[str] = []
    for problem in problems_of(job.case) if problems is None else problems:
        stop = _counted(job, job.planner, problem, {} if rates is None else rates)
        result = require_result(job.planner.plan(problem, stop=stop, rng=streams[problem.uav]))
        assert problem.target is not None
        violations = check_result(job.case.scenario, problem.uav, problem.target, result)
        wrong = wrong_figures(job.case.scenario, problem.airspace.rates, result)
        complaints += [violation.message for violation in violations]
        complaints += [f"{job.case.scenario.uavs[problem.uav].name}: {wrong}."] if wrong else []
        results.append(result if job.objective is None else rescored(problem, job.objective, result))
    return _row(job, results, complaints)


def problems_of(case: Case) -> tuple[Problem, ...]:
    """Return the problem of each UAV of a case that has a target."""
    airspace = Airspace(case.scenario)
    assigned = assign_targets(airspace, case.assignment)
    return tuple(Problem(airspace, uav, target) for uav, target in enumerate(assigned) if target is not None)


def _counted(job: Job, planner: Planner, problem: Problem, rates: Rates) -> Stop:
    """Return a budget of paths for one of seconds alone, at the rate that pilot runs of this planner show.

    The rate changes during a schedule, so the second pilot run is about as long as the run itself, but at most 1 s.
    """
    stop = job.stop
    assert stop is not None
    if not isinstance(stop, MaxSeconds):
        return stop
    seconds = stop.seconds
    which = (job.case.digest, settings_of(planner), problem.uav, repr(stop))
    if which not in rates:
        paths = _MIN_PILOT_PATHS
        for _ in range(2):
            pilot = planner.plan(problem, stop=MaxPaths(paths) | MaxSeconds(max(1.0, seconds)), rng=0)
            rates[which] = max(pilot.effort.generated_paths, 1) / max(pilot.seconds, 1e-9)
            if pilot.stopped_by == "finished":  # an exact planner ends before its budget
                break
            paths = max(_MIN_PILOT_PATHS, int(rates[which] * min(1.0, seconds)))
    return MaxPaths(max(1, round(rates[which] * seconds))) | stop


def _row(job: Job, results: Sequence[Result], complaints: Sequence[str]) -> Row:
    status = max((r.status for r in results), key=list(Status).index, default=Status.NOT_PLANNED)
    success = bool(results) and all(result.status.reached for result in results)
    cost = sum(result.cost for result in results) if results else float("inf")
    bounds = [result.bound for result in results if result.bound is not None]
    bound = sum(bounds) if results and len(bounds) == len(results) else None
    gap = None
    if success and bound is not None and (bound > 0 or cost == bound):
        gap = cost / bound - 1.0 if bound > 0 else 0.0
    fuel, divergence, end = (
        sum((one.terms.get(term, 0.0) for one in results), 0.0) for term in ("fuel", "divergence", "end")
    )
    return Row(
        *job.run,
        status=status.value,
        success=success,
        cost=float(cost),
        fuel=fuel,
        divergence=divergence,
        end=end,
        bound=bound,
        gap=gap,
        generated_paths=sum(result.effort.generated_paths for result in results),
        generated_nodes=sum(result.effort.generated_nodes for result in results),
        evaluations=sum(result.effort.evaluations for result in results),
        iterations=sum(int(result.history.iteration.max(initial=0)) for result in results),
        seconds=sum((result.seconds for result in results), 0.0),
        stopped_by=", ".join(dict.fromkeys(result.stopped_by for result in results)),
        verdict=" ".join(complaints),
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
