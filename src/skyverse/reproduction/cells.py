"""The cells of the thesis's tables and figures: the runs behind each, and what they found."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from skyverse._typing import Floats
from skyverse.files import read_scenario
from skyverse.lab import Case, Job, Rows, problems_of, sample
from skyverse.lab.report import Block
from skyverse.mission.assignment import Assignment
from skyverse.model.result import History
from skyverse.planners import make_planner
from skyverse.planners.astar import AStar
from skyverse.planners.base import Planner
from skyverse.planners.restart import RandomRestart
from skyverse.reproduction.published import CASES, FLEET_RUNS, METHODS
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
EXACT, RESTART, LONG_RESTART = "A*", "random restart", "3500 paths"
_STOPS: dict[str, Stop] = EQUAL_EFFORTS | {EXACT: MaxIterations(1), LONG_RESTART: MaxPaths(3500)}
Length = int | str
"""How long a run is: its number of iterations, or the name of a stop rule."""
Size = tuple[int, Length]
"""The population, and how long runs are."""


class Cell(NamedTuple):
    """One cell of a table: the runs of a method on a scenario.

    Attributes
    ----------
    scenario
        A built-in scenario; with `bare` all of its obstacles are taken away.
    method, form
        One of the thesis's three methods in one of its two forms, where a second word names one of `VARIANTS`; or the
        exact search or the baseline without memory, which have no form.
    population, length
        The number of candidates, and how long runs are.
    assignment
        How the targets of a fleet are assigned.
    """

    scenario: str
    method: str
    form: str
    population: int
    length: Length
    assignment: Assignment = "path-cost"
    bare: bool = False

    @property
    def case(self) -> str:
        """The label of the scenario in the rows."""
        more = ", no obstacles" if self.bare else "" if self.assignment == "path-cost" else f", {self.assignment}"
        return self.scenario + more

    @property
    def planner(self) -> str:
        """The label of the method in the rows."""
        return f"{self.method} {self.form}, {self.population}" if self.form else self.method

    @property
    def budget(self) -> str:
        """The label of the length in the rows."""
        return f"{self.length} iterations" if isinstance(self.length, int) else self.length

    def make_case(self) -> Case:
        """Read the scenario."""
        scenario = read_scenario(self.scenario)
        return Case(
            self.case, scenario.model_copy(update={"obstacles": ()}) if self.bare else scenario, self.assignment
        )

    def make_planner(self) -> Planner:
        """Return the planner."""
        name, _, variant = self.method.partition(" ")
        if not self.form:
            return AStar() if name == EXACT else RandomRestart(samples=2)
        candidates = {"MVO": "universes", "GSO": "glowworms", "BBO": "habitats"}[name]
        settings = {candidates: self.population, "as_run": self.form == FORMS[0], **VARIANTS[variant]}
        return make_planner(name.lower(), **settings)

    @property
    def stop(self) -> Stop:
        """What ends a run."""
        return MaxIterations(self.length) if isinstance(self.length, int) else _STOPS[self.length]


def grid(
    scenarios: Iterable[str],
    sizes: Iterable[Size] = CASES,
    methods: Iterable[str] = METHODS,
    forms: Iterable[str] = FORMS,
    **more: Any,
) -> list[Cell]:
    """Return the cells of all methods and forms on these scenarios, with these populations and lengths."""
    return [
        Cell(name, method, form, *size, **more)
        for name, size, method, form in product(scenarios, sizes, methods, forms)
    ]


def exact(scenario: str) -> Cell:
    """Return searches of A*, which ends by itself at the optimum."""
    return Cell(scenario, EXACT, "", 0, EXACT)


def restart(scenario: str) -> Cell:
    """Return the baseline without memory, whose histories contain its runs of any smaller effort."""
    return Cell(scenario, RESTART, "", 0, LONG_RESTART)


def jobs_of(wanted: Iterable[tuple[Cell, Iterable[int]]]) -> list[Job]:
    """Return the runs of cells with these seeds, each once, scenario by scenario."""
    cases: dict[str, Case] = {}
    found: dict[tuple[str, str, str, int], Job] = {}
    for cell, seeds in wanted:
        if cell.case not in cases:
            cases[cell.case] = cell.make_case()
        case, planner = cases[cell.case], cell.make_planner()
        for seed in seeds:
            job = Job(case, planner, cell.planner, cell.stop, cell.budget, seed)
            found.setdefault(job.run, job)
    places = list(cases)
    return sorted(found.values(), key=lambda job: places.index(job.case.label))


@dataclass(frozen=True)
class ThesisPart:
    """A table or figure of the thesis, or the page of claims.

    Attributes
    ----------
    name
        Its name, such as ``table-4.2``.
    blocks
        Returns what it shows, which is the same for the same seeds on any machine.
    cells, few
        The cells that it needs, with all seeds, or only `FLEET_RUNS` of them.
    seconds
        Returns what it shows of measured times, which differ from run to run; ``None`` where it shows none.
    """

    name: str
    blocks: "Callable[[CellRuns], Sequence[Block]]"
    cells: Sequence[Cell] = ()
    few: Sequence[Cell] = ()
    seconds: "Callable[[CellRuns], Sequence[Block]] | None" = None

    def wanted(self, seeds: Sequence[int]) -> list[tuple[Cell, Sequence[int]]]:
        """Return the cells, each with the seeds of its runs."""
        return [*((cell, seeds) for cell in self.cells), *((cell, seeds[:FLEET_RUNS]) for cell in self.few)]


class CellRuns:
    """What the runs of the tables' cells found.

    Parameters
    ----------
    rows
        The rows of all parts that are wanted; there may be others.
    seeds
        The seeds of the runs that count; other runs are ignored.
    work
        The column by which claims on time are judged; it is also called ``"work"``.
    """

    def __init__(self, rows: Rows, seeds: Sequence[int], work: str = "generated_nodes") -> None:
        self.rows = rows
        self.work = work
        self.seeds = sorted(seeds)
        lengths = [budget.removesuffix(" iterations") for budget in rows.labels("budget")]
        self._lengths = sorted(int(length) for length in lengths if length.isdecimal())
        self._kept: dict[tuple[str, str, str], list[History]] = {}
        self._optima: dict[str, float] = {}

    @property
    def runs(self) -> int:
        """The number of runs of each cell."""
        return len(self.seeds)

    @property
    def unit(self) -> str:
        """The unit of work."""
        return self.work.split("_")[-1]

    def values(self, column: str, cell: Cell) -> Floats:
        """Return a column of a cell's runs, (n,): one of `History`'s, ``seconds``, ``milliseconds`` or ``success``."""
        column = self.work if column == "work" else column
        kept, factor = ("seconds", 1000.0) if column == "milliseconds" else (column, 1.0)
        rows = self.rows.select(("seed", kept), scenario=cell.case, planner=cell.planner, budget=cell.budget)
        found: Floats = factor * rows[kept][np.isin(rows["seed"], self.seeds)].astype(np.float64)
        if len(found) == self.runs:
            return found
        shorter = column in HISTORY_VALUES and cell.method not in SCHEDULED and isinstance(cell.length, int)
        for longer in self._lengths if shorter else ():  # a cell that another part has run only in part does not count
            if isinstance(cell.length, int) and longer > cell.length:
                histories = self._histories(cell._replace(length=longer))
                if len(histories) == self.runs:
                    return np.array([getattr(one.by_iteration(), column)[cell.length] for one in histories], np.float64)
        raise ValueError(f"expected {self.runs} runs of {cell.planner}, found {len(found)}")

    def means(self, cells: Iterable[Cell]) -> tuple[list[float], list[float]]:
        """Return the mean costs of cells and their standard errors."""
        found = [sample(self.values("cost", cell)) for cell in cells]
        return [each.mean for each in found], [each.error for each in found]

    def medians(self, column: str, cells: Iterable[Cell]) -> list[float]:
        """Return the medians of a column of cells."""
        return [float(np.median(self.values(column, cell))) for cell in cells]

    def first(self, runs: int = FLEET_RUNS) -> "CellRuns":
        """Return the same runs, but of only the first `runs` seeds."""
        few = CellRuns(self.rows, self.seeds[:runs], self.work)
        few._optima = self._optima
        return few

    def optimum(self, scenario: str, assignment: Assignment = "path-cost", *, bare: bool = False) -> float:
        """Return the exact optimum of a scenario, summed over its UAVs."""
        cell = exact(scenario)._replace(assignment=assignment, bare=bare)
        if cell.case not in self._optima:
            routes = [problem.route for problem in problems_of(cell.make_case())]
            self._optima[cell.case] = sum(route.price for route in routes if route is not None)
        return self._optima[cell.case]

    def restart(self, scenario: str, paths: float) -> Floats:
        """Return the baseline's costs, (n,), after `paths` generated paths."""
        histories = self._histories(restart(scenario))
        spent = [int(np.searchsorted(history.generated_paths, paths, side="right")) for history in histories]
        costs = [history.cost[max(0, count - 1)] for history, count in zip(histories, spent, strict=True)]
        return np.array(costs, dtype=np.float64)

    def iterations_until(self, bound: float, cell: Cell) -> Floats:
        """Return after how many iterations a cell's runs cost at most `bound`, (n,); one more than all if never."""
        assert isinstance(cell.length, int)
        kept = self._histories(cell)
        until = [np.flatnonzero(history.by_iteration().cost <= bound * (1 + 1e-9))[:1] for history in kept]
        return np.array([found[0] if len(found) else cell.length + 1 for found in until], dtype=np.float64)

    def _histories(self, cell: Cell) -> list[History]:
        which = (cell.case, cell.planner, cell.budget)
        if which not in self._kept:
            where = dict(zip(("scenario", "planner", "budget"), which, strict=True))
            seeds = self.rows.select(("seed",), **where)["seed"].tolist()
            found = zip(seeds, self.rows.histories(**where), strict=True)
            self._kept[which] = [history for seed, history in found if seed in self.seeds]
        return self._kept[which]
