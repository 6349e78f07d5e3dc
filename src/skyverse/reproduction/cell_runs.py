"""The runs behind the thesis's tables and figures: which are needed, and what they found."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.files import read_scenario
from skyverse.lab.job import Case, Job
from skyverse.lab.planned_run import problems_of
from skyverse.lab.report import Block
from skyverse.lab.rows import Rows
from skyverse.mission.plan_mission import Assignment
from skyverse.model.result import History
from skyverse.planners import make_planner
from skyverse.planners.astar import AStar
from skyverse.planners.base import Planner
from skyverse.planners.restart import RandomRestart
from skyverse.reproduction.published import METHODS
from skyverse.stop import MaxIterations, MaxNodes, MaxPaths, Stop

FORMS = ("as run", "as described")
"""The methods as run in the published experiments, and as described by the text and the original papers."""

FORM_HEADS = [f"{method} {form}" for method in METHODS for form in ("thesis", *FORMS)]
"""The heads of columns with the thesis's number and ours for each method."""
HISTORY_VALUES = ("cost", "generated_paths", "generated_nodes", "evaluations")
LAST_ITERATION = 50
SCHEDULED = ("MVO", "MVO greedy")
"""The methods with a schedule. A shorter run of any other method is the beginning of a longer one."""
VARIANTS: dict[str, dict[str, object]] = {"": {}, "greedy": {"greedy": True}, "uniform": {"generator": "uniform"}}
"""What a word behind a method's name changes: no change for the worse is kept; paths come from Algorithm 1."""
EQUAL_EFFORTS: dict[str, Stop] = {"1000 paths": MaxPaths(1000), "100000 nodes": MaxNodes(100_000)}
"""The equal efforts at which claims are judged, besides the published iterations."""
Length = int | str
"""How long a run is: its number of iterations, or one of `EQUAL_EFFORTS`."""
EXACT = "A*"
RESTART = "random restart"
RESTART_PATHS = 3500


@cache
def case(scenario: str, assignment: Assignment = "path-cost") -> Case:
    """Return a built-in scenario as a case, labelled by its name and by the assignment unless that is by path cost."""
    label = scenario if assignment == "path-cost" else f"{scenario}, {assignment}"
    return Case(label, read_scenario(scenario), assignment)


@cache
def without_obstacles(scenario: str) -> Case:
    """Return a built-in scenario from which all obstacles are taken away."""
    return Case(f"{scenario}, no obstacles", read_scenario(scenario).model_copy(update={"obstacles": ()}))


def planner(method: str, form: str, population: int) -> Planner:
    """Return one of the thesis's three methods in one of its two forms; a second word names one of `VARIANTS`."""
    name, _, variant = method.partition(" ")
    candidates = {"MVO": "universes", "GSO": "glowworms", "BBO": "habitats"}[name]
    settings = {candidates: population, "as_run": form == FORMS[0], **VARIANTS[variant]}
    return make_planner(name.lower(), **settings)


def cell(given: Case, method: str, form: str, population: int, length: Length, seeds: Iterable[int]) -> Iterator[Job]:
    """Yield the runs of one cell of a table."""
    made = planner(method, form, population)
    stop = MaxIterations(length) if isinstance(length, int) else EQUAL_EFFORTS[length]
    for seed in seeds:
        yield Job(given, made, label(method, form, population), stop, budget(length), seed)


def all_methods(cases: Iterable[Case], sizes: Iterable[tuple[int, Length]], seeds: Iterable[int]) -> Iterator[Job]:
    """Yield the runs of all methods and forms on these cases, with these populations and lengths."""
    for given, size, method, form in product(cases, sizes, METHODS, FORMS):
        yield from cell(given, method, form, *size, seeds)


def no_jobs(seeds: Sequence[int]) -> Iterable[Job]:
    """Return the runs of a part that needs none."""
    return ()


def exact_searches(given: Case, seeds: Iterable[int]) -> Iterator[Job]:
    """Yield searches of A*, which ends by itself at the optimum."""
    for seed in seeds:
        yield Job(given, AStar(), EXACT, MaxIterations(1), EXACT, seed)


def restarts(given: Case, seeds: Iterable[int]) -> Iterator[Job]:
    """Yield the runs of the baseline without memory, whose histories contain its runs of any smaller effort."""
    made, stop = RandomRestart(samples=2), MaxPaths(RESTART_PATHS)
    for seed in seeds:
        yield Job(given, made, RESTART, stop, f"{RESTART_PATHS} paths", seed)


def label(method: str, form: str, population: int) -> str:
    """Return the label of a method in the rows."""
    return f"{method} {form}, {population}"


def budget(length: Length) -> str:
    """Return the label of a length in the rows."""
    return f"{length} iterations" if isinstance(length, int) else length


@cache
def optimum(given: Case) -> float:
    """Return the exact optimum of a case, summed over its UAVs."""
    return sum(problem.route.price for problem in problems_of(given) if problem.route is not None)


class Mean(NamedTuple):
    """A mean and its standard error."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:.1f} ± {self.error:.1f}"


def mean(values: Floats) -> Mean:
    """Return the mean of two or more values and its standard error."""
    return Mean(float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))))


class CellRuns:
    """What the runs of the tables' cells found.

    Parameters
    ----------
    rows
        The rows of all parts that are wanted; there may be others.
    seeds
        The seeds of the runs that count; other runs are ignored.
    work
        The column by which claims on time are judged.
    """

    def __init__(self, rows: Rows, seeds: Sequence[int], work: str = "generated_nodes") -> None:
        self.rows = rows
        self.work = work
        self.seeds = sorted(seeds)
        lengths = [budget.removesuffix(" iterations") for budget in rows.labels("budget")]
        self._lengths = sorted(int(length) for length in lengths if length.isdecimal())
        self._kept: dict[tuple[str, str, str], list[History]] = {}

    @property
    def runs(self) -> int:
        """The number of runs of each cell."""
        return len(self.seeds)

    @property
    def unit(self) -> str:
        """The unit of work."""
        return self.work.split("_")[-1]

    def values(self, column: str, given: Case, method: str, form: str, population: int, length: Length) -> Floats:
        """Return a column of a cell's runs, (n,): one of `History`'s, ``seconds``, ``milliseconds`` or ``success``."""
        named = label(method, form, population)
        found = self._select(column, given.label, named, budget(length))
        if len(found) == self.runs or method in SCHEDULED or not isinstance(length, int):
            return self._whole(found, named)
        for longer in self._lengths:  # a cell that another part has run only in part does not count
            if longer > length and column in HISTORY_VALUES:
                histories = self._histories(given.label, named, budget(longer))
                if len(histories) == self.runs:
                    values = [getattr(history.by_iteration(), column)[length] for history in histories]
                    return np.array(values, dtype=np.float64)
        return self._whole(found, named)

    def means(
        self, cases: Iterable[Case], method: str, form: str, sizes: Iterable[tuple[int, int]]
    ) -> tuple[list[float], list[float]]:
        """Return the mean costs of cells and their standard errors, case by case, with each population and length."""
        found = [mean(self.values("cost", given, method, form, *size)) for given, size in product(cases, sizes)]
        return [each.value for each in found], [each.error for each in found]

    def medians(
        self, column: str, cases: Iterable[Case], method: str, form: str, sizes: Iterable[tuple[int, int]]
    ) -> list[float]:
        """Return the medians of a column of cells, case by case, with each population and number of iterations."""
        cells = product(cases, sizes)
        return [float(np.median(self.values(column, given, method, form, *size))) for given, size in cells]

    def first(self, runs: int) -> "CellRuns":
        """Return the same runs, but of only the first `runs` seeds."""
        return CellRuns(self.rows, self.seeds[:runs], self.work)

    def _whole(self, found: Floats, named: str) -> Floats:
        if len(found) != self.runs:
            raise ValueError(f"expected {self.runs} runs of {named}, found {len(found)}")
        return found

    def exact(self, column: str, given: Case) -> Floats:
        """Return a column of exact searches, (n,)."""
        return self._whole(self._select(column, given.label, EXACT, EXACT), EXACT)

    def restart(self, given: Case, paths: float) -> Floats:
        """Return the baseline's costs, (n,), after `paths` generated paths."""
        histories = self._histories(given.label, RESTART, f"{RESTART_PATHS} paths")
        spent = [int(np.searchsorted(history.generated_paths, paths, side="right")) for history in histories]
        costs = [history.cost[max(0, count - 1)] for history, count in zip(histories, spent, strict=True)]
        return np.array(costs, dtype=np.float64)

    def iterations_until(
        self, bound: float, given: Case, method: str, form: str, population: int, iterations: int
    ) -> Floats:
        """Return after how many iterations a cell's runs cost at most `bound`, (n,); one more than all if never."""
        kept = self._histories(given.label, label(method, form, population), budget(iterations))
        until = [np.flatnonzero(history.by_iteration().cost <= bound * (1 + 1e-9))[:1] for history in kept]
        return np.array([found[0] if len(found) else iterations + 1 for found in until], dtype=np.float64)

    def _select(self, column: str, scenario: str, planner: str, budget: str) -> Floats:
        kept, factor = ("seconds", 1000.0) if column == "milliseconds" else (column, 1.0)
        found = self.rows.select(("seed", kept), scenario=scenario, planner=planner, budget=budget)
        return factor * found[kept][np.isin(found["seed"], self.seeds)].astype(np.float64)

    def _histories(self, scenario: str, planner: str, budget: str) -> list[History]:
        which = (scenario, planner, budget)
        if which not in self._kept:
            where = {"scenario": scenario, "planner": planner, "budget": budget}
            seeds = self.rows.select(("seed",), **where)["seed"].tolist()
            found = zip(seeds, self.rows.histories(**where), strict=True)
            self._kept[which] = [history for seed, history in found if seed in self.seeds]
        return self._kept[which]


@dataclass(frozen=True)
class ThesisPart:
    """A table or figure of the thesis, or the page of claims.

    Attributes
    ----------
    name
        Its name, such as ``table-4.2``.
    jobs
        Returns the runs that it needs, given the seeds.
    blocks
        Returns what it shows, which is the same for the same seeds on any machine.
    seconds
        Returns what it shows of measured times, which differ from run to run; ``None`` where it shows none.
    """

    name: str
    jobs: Callable[[Sequence[int]], Iterable[Job]]
    blocks: Callable[[CellRuns], Sequence[Block]]
    seconds: Callable[[CellRuns], Sequence[Block]] | None = None
