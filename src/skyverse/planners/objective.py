"""Objectives of one's own: what paths of straight legs cost, and which vectors stand for them."""

import math
from abc import ABC, abstractmethod
from dataclasses import astuple, dataclass, replace

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_number
from skyverse.model.result import History, Result, Status
from skyverse.numerics.tolerances import OPTIMALITY_GAP
from skyverse.planners.base import numbers_of
from skyverse.planners.metaheuristic import Run
from skyverse.planners.moves import note_best
from skyverse.planners.results import SearchRecord, refused_result
from skyverse.problem import Problem

FORBIDDEN = 1e100


class PathObjective(ABC):
    """An objective of one's own: a frozen dataclass of its settings, which says what paths cost.

    A `WaypointSearch` with such an `objective` minimises it, and a study with one compares all its planners by it. What
    is in the way of a path is its own affair too: an infinite price forbids a path. The referee judges the path all
    the same, as it judges any other.
    """

    @abstractmethod
    def prices(self, problem: Problem, paths: Floats) -> Floats:
        """Return what paths of straight legs cost.

        Parameters
        ----------
        problem
            What the paths are for.
        paths
            (m, k, 3) metres: the corners of each, from the UAV's start to its target.

        Returns
        -------
        Floats
            (m,) numbers to be minimised; infinite for paths that may not be.
        """

    def bound(self, problem: Problem) -> float | None:
        """Return what every path costs at least, which must be proven, or ``None`` where nothing is known."""
        del problem
        return None

    def first(self, problem: Problem, rng: np.random.Generator, candidates: int, waypoints: int) -> Floats:
        """Return the first population, (candidates, d) in [0, 1]; waypoints sorted from start to target by default."""
        space = problem.airspace.world.space
        X = rng.random((candidates, waypoints, 3))
        return in_order(X, (space.high - space.low) * (problem.end - problem.start)).reshape(candidates, -1)

    def paths(self, problem: Problem, X: Floats) -> Floats:
        """Return the paths (m, k, 3) of vectors (m, d) in [0, 1]; by default those of waypoints within the bounds."""
        space = problem.airspace.world.space
        between = space.low + X.reshape(len(X), -1, 3) * (space.high - space.low)
        ends = (np.broadcast_to(end, (len(X), 1, 3)) for end in (problem.start, problem.end))
        return np.concatenate([next(ends), between, next(ends)], axis=1)


class PricedPath:
    """The best path so far, (k, 3) metres, and its cost, (1,)."""

    def __init__(self) -> None:
        self.path, self.cost = np.empty((0, 3)), np.array([math.inf])


@dataclass(frozen=True, kw_only=True)
class ObjectiveRun(Run):
    """A run whose candidates are priced by an objective of one's own."""

    problem: Problem
    objective: PathObjective
    best: PricedPath

    def evaluate(self, X: Floats) -> Floats:
        """Return the prices (m,) of vectors (m, d), and keep the best path; NaN where the budget is spent.

        Infinite ones are told as `FORBIDDEN`, since some optimisers cannot count with infinity.
        """
        paths = self.objective.paths(self.problem, np.clip(X, 0.0, 1.0))
        paths = numbers_of(paths, (len(X), -1, 3), f"{len(X)} paths of x, y, z in metres", "objective")
        spent, each = self.workspace.spent, np.array([1, max(1, paths.shape[1] - 1), 1])  # paths, nodes, evaluations
        left = max(0, int(((self.workspace.limit - spent + each - 1) // each).min()))
        prices = np.full(len(X), math.nan)
        for i, price in enumerate(prices_of(self.problem, self.objective, paths[:left]).tolist()):
            prices[i] = min(price, FORBIDDEN)
            spent += each
            if price < self.best.cost[0]:
                self.best.path, self.best.cost = paths[i].copy(), np.array([price])
                note_best(self.workspace, price)
        return prices

    def result(self, problem: Problem, record: SearchRecord) -> Result:
        """Return the result that holds the best path, and its price."""
        return priced_result(problem, self.objective, self.best.path, float(self.best.cost[0]), record)


def prices_of(problem: Problem, objective: PathObjective, paths: Floats) -> Floats:
    """Return what paths (m, k, 3) cost by an objective of one's own, (m,); `InputError` for what is no price."""
    found = objective.prices(problem, paths) if len(paths) else ()
    return numbers_of(found, (len(paths),), f"a price for each of {len(paths)} paths", "objective", infinite=True)


def priced_result(
    problem: Problem, objective: PathObjective, path: Floats, price: float, record: SearchRecord
) -> Result:
    """Return the result of a path that costs so much by an objective of one's own; columns at its ends are added."""
    if not math.isfinite(price):
        return replace(refused_result(problem, Status.NO_PATH, record.provenance), **vars(record))
    bound, status = objective.bound(problem), Status.COMPLETE
    if bound is not None:
        require_number(bound, "objective", "a bound that is a number or None")
        within = OPTIMALITY_GAP * abs(bound)
        if price < bound - within:
            said = f"expected no path below {objective!r:.60}'s bound of {bound:g}, found one that costs {price:g}"
            raise InputError(said, field="objective")
        status = Status.OPTIMAL if price <= bound + within else status
    terms, ends, (up, down) = {"objective": price}, (problem.uav_place, problem.target_place), problem.lifts
    path = np.concatenate([up, path, down])
    result = Result(status, path, price, terms, bound, *ends, **vars(record), any_angle=True)
    return replace(result, objective=repr(objective))


def rescored(problem: Problem, objective: PathObjective, result: Result) -> Result:
    """Return a result priced by an objective of one's own, for which it was not sought.

    A path that ends short of the target has no price. Of its history the end is kept, the only place with a price.
    """
    if result.objective or not len(result.path):
        return result
    path = problem.without_lifts(result.path) if result.any_angle else result.path
    price = float(prices_of(problem, objective, path[None])[0]) if result.status.reached else math.inf
    effort, iteration = result.effort, int(result.history.iteration.max(initial=0))
    end = History(*map(np.atleast_1d, (price, *astuple(effort), iteration)))
    record = SearchRecord(result.provenance, effort, result.seconds, end, result.stopped_by)
    return priced_result(problem, objective, path, price, record)


def in_order(X: Floats, line: Floats) -> Floats:
    """Return candidates (m, k, 3) with the waypoints of each sorted along a line of direction (3,)."""
    along = np.sum(X * line, axis=2)
    return np.take_along_axis(X, np.argsort(along, axis=1)[:, :, None], axis=1)
