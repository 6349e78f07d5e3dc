"""All runs of a study with one budget, by scenario and planner."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.lab.curves import ratios
from skyverse.lab.rows import Rows
from skyverse.lab.statistics import Costs

_COLUMNS = ("seed", "cost", "success", "gap", "bound", "seconds", "stopped_by", "flown_seconds")
_EFFORT_COLUMNS = ("generated_paths", "generated_nodes", "evaluations", "iterations")


@dataclass(frozen=True)
class BudgetRuns:
    """All runs with one budget.

    Attributes
    ----------
    budget, scenarios, planners
        Labels, in the study's order.
    cells
        Columns of `Rows` by scenario and planner; empty where there are no runs.
    """

    budget: str
    scenarios: tuple[str, ...]
    planners: tuple[str, ...]
    cells: Mapping[tuple[str, str], Mapping[str, NDArray[Any]]]

    @property
    def flown(self) -> bool:
        """Whether the runs are flights, whose costs are seconds; then a seed makes the same movers for all planners."""
        return bool(np.isfinite(np.concatenate([self.all(p, "flown_seconds") for p in self.planners])).any())

    @property
    def contestants(self) -> tuple[str, ...]:
        """The planners that are compared: all but exact ones, which end by themselves, each time at the optimum."""
        ends = {p: np.all(self.all(p, "iterations") == 0) and np.all(self.all(p, "gap") == 0) for p in self.planners}
        return tuple(planner for planner in self.planners if not ends[planner])

    def all(self, planner: str, column: str) -> NDArray[Any]:
        """Return one column of all runs of a planner."""
        return np.concatenate([self.cells[scenario, planner][column] for scenario in self.scenarios])

    def bound(self, scenario: str) -> float | None:
        """Return the lower bound of a scenario, on the lattice its exact optimum, or ``None`` where none is proven."""
        known = np.concatenate([self.cells[scenario, planner]["bound"] for planner in self.planners])
        known = known[np.isfinite(known)]
        return float(known.min()) if len(known) else None

    def reference(self, scenario: str) -> float:
        """Return the lower bound, else the least cost of a run that reached its target, else the least of any run."""
        bound = self.bound(scenario)
        if bound is not None:
            return bound
        cells = [self.cells[scenario, planner] for planner in self.planners]
        reached = np.concatenate([cell["cost"][cell["success"]] for cell in cells])
        return float(np.min(reached if len(reached) else np.concatenate([cell["cost"] for cell in cells])))

    def costs(self, planner: str, scenarios: Sequence[str]) -> Costs:
        """Return a planner's costs by scenario and seed; of several scenarios, each cost divided by its `reference`."""
        found = {}
        for scenario in scenarios:
            cell = self.cells[scenario, planner]
            costs = cell["cost"]
            if len(scenarios) > 1:
                costs = ratios(costs, np.full(len(costs), True), self.reference(scenario))
            found[scenario] = dict(zip(cell["seed"].tolist(), costs.tolist(), strict=True))
        return found

    def ratios(self, planner: str) -> Floats:
        """Return the costs of all runs of a planner divided by their `reference`, infinite where a run failed."""
        cells = {scenario: self.cells[scenario, planner] for scenario in self.scenarios}
        return np.concatenate(
            [ratios(cell["cost"], cell["success"], self.reference(scenario)) for scenario, cell in cells.items()]
        )


def runs_at_budget(rows: Rows, budget: str) -> BudgetRuns:
    """Read all runs with the budget of this label."""
    found = rows.select(("scenario", "planner"), budget=budget)
    scenarios = tuple(label for label in rows.labels("scenario") if label in set(found["scenario"].tolist()))
    planners = tuple(label for label in rows.labels("planner") if label in set(found["planner"].tolist()))
    cells = {
        (scenario, planner): rows.select(_COLUMNS + _EFFORT_COLUMNS, scenario=scenario, planner=planner, budget=budget)
        for scenario in scenarios
        for planner in planners
    }
    return BudgetRuns(budget, scenarios, planners, cells)
