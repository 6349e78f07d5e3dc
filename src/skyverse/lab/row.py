"""What is known of one run: one row."""

from dataclasses import dataclass

from skyverse.model.result import History


@dataclass(frozen=True)
class Row:
    """One scenario x one planner x one budget x one seed, over all UAVs of the scenario.

    Attributes
    ----------
    scenario, planner, budget, seed
        Which run: three labels and a number, unique in a study. The budget is per UAV.
    status
        The worst of the UAVs' statuses; ``"not planned"`` where no UAV has a target.
    success
        Whether every UAV that has a target reached it.
    cost, fuel, divergence, end
        Sums over the UAVs, in the objective's unit.
    bound, gap
        The sum of the exact optima, and ``cost / bound - 1`` of a success; ``None`` where unknown.
    generated_paths, generated_nodes, evaluations, iterations, seconds
        Effort, summed over the UAVs; the seconds are those of the search alone, without any compilation.
    stopped_by
        What ended the UAVs' searches: the stop rules' names.
    verdict
        What the referee found wrong, sentence by sentence; empty when nothing.
    settings, versions
        The planner with all its parameters; skyverse, Python, numpy, numba and platform.
    history
        Best total cost and effort after the start and each iteration; a UAV that is done keeps its last row.
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
