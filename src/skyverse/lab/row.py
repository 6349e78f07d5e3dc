"""What is known of one run of a study: one row."""

from dataclasses import dataclass

from skyverse.lab.columns import column_types
from skyverse.model.result import History


@dataclass(frozen=True)
class Row:
    """The run of one planner on one scenario, with one budget and one seed, summed over the UAVs of the scenario.

    Attributes
    ----------
    scenario, planner, budget, seed
        Three labels and a number that identify the run in its study. The budget is that of each UAV's search.
    status
        The worst of the UAVs' statuses; ``"not planned"`` where no UAV has a target.
    success
        Whether every UAV that has a target reached it.
    cost, fuel, divergence, end
        Sums over the UAVs, in the objective's unit.
    bound, gap
        The sum of the exact optima, and ``cost / bound - 1`` of a success; ``None`` where unknown.
    generated_paths, generated_nodes, evaluations, iterations, seconds
        Effort, summed over the UAVs; the seconds are those of the search alone, without compilation.
    stopped_by
        The names of the stop rules that ended the UAVs' searches.
    verdict
        What the referee found wrong, in sentences; empty where it found nothing.
    settings, versions
        The planner with all its parameters; skyverse, Python, numpy, numba and platform.
    history
        Best cost and effort at each improvement and after each iteration; of several UAVs their sums, after each
        iteration, where a search that has ended keeps its last values.
    """

    scenario: str
    planner: str
    budget: str
    seed: int
    status: str
    success: bool
    cost: float
    fuel: float
    divergence: float
    end: float
    bound: float | None
    gap: float | None
    generated_paths: int
    generated_nodes: int
    evaluations: int
    iterations: int
    seconds: float
    stopped_by: str
    verdict: str
    settings: str
    versions: str
    history: History


RUN_COLUMNS = ("scenario", "planner", "budget", "seed")
"""The columns that identify a run."""
COLUMN_TYPES = column_types(Row)
"""The numpy type of each field of a row except its history; ``None`` in a field of floats becomes nan."""
