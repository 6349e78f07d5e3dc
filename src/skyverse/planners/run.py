"""The state of one run of a metaheuristic."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from skyverse._typing import Floats
from skyverse.model.result import Result
from skyverse.planners.moves import LatticeTask, Paths, Workspace
from skyverse.planners.results import SearchRecord, lattice_result
from skyverse.problem import Problem
from skyverse.space.contact import flown_legs
from skyverse.stop import Stop

_IMPROVEMENTS = 1024
"""Of one iteration, so many improvements are noted one by one."""
_UNLIMITED = 2.0**62
"""Stands for an infinite limit of a counter: it fits into an int64."""


class Candidates(Protocol):
    """Candidate paths of any kind, each with its cost."""

    @property
    def cost(self) -> Floats:
        """(n,) the cost of each."""


@dataclass(frozen=True, kw_only=True)
class Run(ABC):
    """The state of one run: what is sought and the population are in subclasses.

    Attributes
    ----------
    workspace
        Working memory, the effort so far and its limits.
    rng
        The source of all random numbers.
    best
        One path: the best so far.
    memory
        What `Metaheuristic.begin` returned: whatever a method remembers from step to step besides paths.
    """

    workspace: Workspace
    rng: np.random.Generator
    best: Candidates
    memory: object = None

    @property
    def lowest_cost(self) -> float:
        """The cost of the best path so far."""
        return float(self.best.cost[0])

    @abstractmethod
    def result(self, problem: Problem, record: SearchRecord) -> Result:
        """Return the result that holds the best path."""


@dataclass(frozen=True, kw_only=True)
class LatticeRun(Run):
    """A run whose candidates are lattice paths.

    Attributes
    ----------
    task
        What is sought.
    paths
        The population.
    given
        (n, 3) metres each: paths with which the first population begins.
    """

    task: LatticeTask
    paths: Paths
    best: Paths
    given: tuple[Floats, ...] = ()

    def result(self, problem: Problem, record: SearchRecord) -> Result:
        """Return the result that holds the best path.

        Its cost is without what contact with movers costs, and so is the last of its history.
        """
        result = lattice_result(problem, self.best.nodes[0, : self.best.length[0]].copy(), record)
        if not len(self.task.contact.shapes.kind):
            return result
        history = replace(result.history, cost=result.history.cost + (result.cost - self.lowest_cost))
        return replace(result, history=history)


def lattice_run(
    problem: Problem, task: LatticeTask, population: int, capacity: int, stop: Stop, rng: np.random.Generator
) -> LatticeRun:
    """Return a run with memory for so many candidates, none of which is there yet, of at most `capacity` nodes each."""
    workspace = make_workspace(stop, len(problem.airspace.grid.exits), capacity)
    paths, best = _no_paths(population, capacity), _no_paths(1, capacity)
    return LatticeRun(workspace=workspace, rng=rng, task=task, paths=paths, best=best)


def make_workspace(stop: Stop, nodes: int = 0, capacity: int = 0) -> Workspace:
    """Return the working memory of a run: for a lattice of so many nodes, and drafts of at most `capacity` nodes."""
    limits = [min(stop.limit(name), _UNLIMITED) for name in ("generated_paths", "generated_nodes", "evaluations")]
    return Workspace(
        mark=np.zeros(nodes, np.uint8),
        stamp=np.zeros(1, np.int64),
        position=np.empty(nodes, np.int32),
        draft=np.empty(capacity, np.int64),
        legs=flown_legs(capacity + 2),
        spent=np.zeros(3, np.int64),
        limit=np.array(limits).astype(np.int64),
        improved=np.empty((_IMPROVEMENTS, 4)),
        improvements=np.zeros(1, np.int64),
    )


def taken_improvements(workspace: Workspace) -> list[tuple[float, int, int, int]]:
    """Return and forget the costs of new best paths, each with the paths, nodes and evaluations when it was found."""
    count = min(int(workspace.improvements[0]), len(workspace.improved))
    workspace.improvements[0] = 0
    return [(price, int(a), int(b), int(c)) for price, a, b, c in workspace.improved[:count].tolist()]


def _no_paths(count: int, capacity: int) -> Paths:
    return Paths(np.empty((count, capacity), np.int64), np.zeros(count, np.int64), np.full(count, math.inf))
