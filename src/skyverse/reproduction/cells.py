"""The runs behind the thesis's tables and figures: what is to be run, and what came of it."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.files import read_scenario
from skyverse.lab.report import Block
from skyverse.lab.rows import Rows
from skyverse.lab.run_job import Case, Job
from skyverse.mission.plan_mission import Assignment
from skyverse.planners.bbo import BBO
from skyverse.planners.gso import GSO
from skyverse.planners.lattice import LatticeSearch
from skyverse.planners.mvo import MVO
from skyverse.planners.restart import RandomRestart
from skyverse.problem import Airspace, Problem
from skyverse.stop import MaxIterations, MaxNodes, MaxPaths, Stop

FORMS = ("as run", "as described")
"""What was run in the published experiments, and what the text and the original papers describe."""

HISTORY = ("cost", "generated_paths", "generated_nodes", "evaluations")
LONGEST = 50
SCHEDULED = ("MVO",)
"""The others follow no schedule: a shorter run of theirs is the beginning of a longer one."""
EQUAL: dict[str, Stop] = {"1000 paths": MaxPaths(1000), "100000 nodes": MaxNodes(100_000)}
"""The equal efforts at which claims are judged."""
RESTART = "random restart"
RESTART_PATHS = 3500


@cache
def case(scenario: str, assignment: Assignment = "path-cost") -> Case:
    """Return a built-in scenario as a case of its own name, or of that and how its UAVs get their targets."""
    label = scenario if assignment == "path-cost" else f"{scenario}, {assignment}"
    return Case(label, read_scenario(scenario), assignment)


def planner(method: str, form: str, population: int) -> LatticeSearch:
    """Return one of the thesis's three methods in one of its two forms."""
    as_run = form == FORMS[0]
    if method == "MVO":
        return MVO(universes=population, as_run=as_run)
    if method == "GSO":
        return GSO(glowworms=population, as_run=as_run)
    return BBO(habitats=population, as_run=as_run)


def cell(given: Case, method: str, form: str, population: int, iterations: int, seeds: Iterable[int]) -> Iterator[Job]:
    """Yield the runs of one cell of a table."""
    made = planner(method, form, population)
    stop, budget = MaxIterations(iterations), f"{iterations} iterations"
    for seed in seeds:
        yield Job(given, made, label(method, form, population), stop, budget, seed)


def equal(given: Case, method: str, form: str, population: int, seeds: Iterable[int]) -> Iterator[Job]:
    """Yield the runs of a comparison at each of the equal efforts."""
    made = planner(method, form, population)
    for budget, stop in EQUAL.items():
        for seed in seeds:
            yield Job(given, made, label(method, form, population), stop, budget, seed)


def restarts(given: Case, seeds: Iterable[int]) -> Iterator[Job]:
    """Yield the runs of the memoryless baseline, from which one of any smaller effort can be read off."""
    made, stop = RandomRestart(samples=2), MaxPaths(RESTART_PATHS)
    for seed in seeds:
        yield Job(given, made, RESTART, stop, f"{RESTART_PATHS} paths", seed)


def label(method: str, form: str, population: int) -> str:
    """Return what a method is called in the rows."""
    return f"{method} {form}, {population}"


@cache
def optimum(given: Case) -> float:
    """Return the exact optimum of a case, summed over its UAVs."""
    from skyverse.mission.plan_mission import assign_targets

    airspace = Airspace(given.scenario)
    total = 0.0
    for uav, target in enumerate(assign_targets(airspace, given.assignment)):
        assert target is not None
        route = Problem(airspace, uav, target).route
        assert route is not None
        total += route.price
    return total


class Mean(NamedTuple):
    """A mean and its standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:.1f} ± {self.error:.1f}"


def mean(values: Floats) -> Mean:
    """Return the mean of two or more values and its standard error."""
    return Mean(float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))))


class Cells:
    """What came of the runs.

    Parameters
    ----------
    rows
        Of all parts that are wanted, and perhaps of more.
    seeds
        Those that count.
    """

    def __init__(self, rows: Rows, seeds: Sequence[int]) -> None:
        self.rows = rows
        self.seeds = sorted(seeds)
        budgets = [budget.split() for budget in rows.labels("budget")]
        self._lengths = sorted(int(count) for count, unit in budgets if unit == "iterations")
        self._kept: dict[tuple[str, str, str], dict[str, list[NDArray[np.float64]]]] = {}

    @property
    def runs(self) -> int:
        """How many runs a cell has."""
        return len(self.seeds)

    def values(self, column: str, given: Case, method: str, form: str, population: int, iterations: int) -> Floats:
        """Return a column, one of `History`'s, ``seconds`` or ``success``, of a cell's runs, (n,)."""
        named = label(method, form, population)
        found = self._select(column, given.label, named, f"{iterations} iterations")
        if len(found) == self.runs or method in SCHEDULED:
            return self._whole(found, named)
        for longer in self._lengths:  # a cell that another part has left half done does not count
            if longer > iterations and column in HISTORY:
                histories = self._histories(given.label, named, f"{longer} iterations")[column]
                if len(histories) == self.runs:
                    return np.array([history[iterations] for history in histories], dtype=np.float64)
        return self._whole(found, named)

    def first(self, runs: int) -> "Cells":
        """Return the same with so many seeds at most."""
        return Cells(self.rows, self.seeds[:runs])

    def _whole(self, found: Floats, named: str) -> Floats:
        if len(found) != self.runs:
            raise ValueError(f"expected {self.runs} runs of {named}, found {len(found)}")
        return found

    def equal(self, column: str, given: Case, method: str, form: str, population: int, effort: str) -> Floats:
        """Return a column of the runs at an equal effort, one of `EQUAL`, (n,)."""
        named = label(method, form, population)
        return self._whole(self._select(column, given.label, named, effort), named)

    def restart(self, given: Case, paths: float) -> Floats:
        """Return the baseline's costs after at most so many generated paths, (n,)."""
        histories = self._histories(given.label, RESTART, f"{RESTART_PATHS} paths")
        costs = []
        for cost, spent in zip(histories["cost"], histories["generated_paths"], strict=True):
            costs.append(cost[max(0, int(np.searchsorted(spent, paths, side="right")) - 1)])
        return np.array(costs, dtype=np.float64)

    def _select(self, column: str, scenario: str, planner: str, budget: str) -> Floats:
        found = self.rows.select(("seed", column), scenario=scenario, planner=planner, budget=budget)
        return found[column][np.isin(found["seed"], self.seeds)].astype(np.float64)

    def _histories(self, scenario: str, planner: str, budget: str) -> dict[str, list[NDArray[np.float64]]]:
        which = (scenario, planner, budget)
        if which not in self._kept:
            where = {"scenario": scenario, "planner": planner, "budget": budget}
            seeds = self.rows.select(("seed",), **where)["seed"].tolist()
            kept: dict[str, list[NDArray[np.float64]]] = {name: [] for name in HISTORY}
            for seed, history in zip(seeds, self.rows.histories(**where), strict=True):
                if seed in self.seeds:
                    for name, values in kept.items():
                        values.append(getattr(history, name))
            self._kept[which] = kept
        return self._kept[which]


@dataclass(frozen=True)
class Part:
    """A table or figure of the thesis, or the page of claims.

    Attributes
    ----------
    name
        What it is called on the command line, as in ``table-4.2``.
    jobs
        The runs that it needs, by their seeds.
    blocks
        What it shows; the same for the same seeds, on any machine.
    seconds
        What it shows of measured times, which differ from run to run.
    """

    name: str
    jobs: Callable[[Sequence[int]], Iterable[Job]]
    blocks: Callable[[Cells], Sequence[Block]]
    seconds: Callable[[Cells], Sequence[Block]] | None = None
