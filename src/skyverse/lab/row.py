"""What is known of one run of a study: one row."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from skyverse.model.result import History


@dataclass(frozen=True)
class Row:
    """One run: a planner on a scenario, with one budget and one seed, or a mission flown among movers.

    Attributes
    ----------
    scenario, planner, budget, seed
        Three labels and a number that identify the run in its study. The budget is that of each UAV's search; of a
        flight it is the time after which it is given up. The label of a scenario with movers names these as well, and
        the planner of a flight is its replanning policy.
    status
        The worst of the UAVs' statuses; ``"not planned"`` where no UAV has a target. Of a flight ``"arrived"`` if all
        UAVs have come to rest at their targets, else ``"not arrived"``.
    success
        Whether every UAV that has a target reached it, and of a flight also whether the referee found nothing wrong.
    cost
        The sum over the UAVs, in the objective's unit. Of a flight the seconds after which the last UAV arrived,
        infinite without success.
    fuel, divergence, end
        Terms of the cost, summed over the UAVs; ``None`` for a flight.
    bound, gap
        The sum of the exact optima, or the least seconds that a flight can take in hindsight, and ``cost / bound - 1``
        of a success; ``None`` where unknown.
    generated_paths, generated_nodes, evaluations, iterations, seconds
        Effort, summed over the UAVs; the seconds are those of the search alone, without compilation.
    stopped_by
        The names of the stop rules that ended the UAVs' searches; empty for a flight.
    verdict
        What the referee found wrong, in sentences, with a flight among the movers as they truly moved; empty where it
        found nothing.
    settings, versions
        The planner with all its parameters; skyverse, Python, numpy, numba and platform.
    history
        Best cost and effort at each improvement and after each iteration; of several UAVs their sums, after each
        iteration, where a search that has ended keeps its last values. Empty for a flight.
    flown_seconds, flown_length, least_length
        Of a flight: when the last UAV arrived or the flight was given up; metres flown by all UAVs, and a proven lower
        bound of them. ``None``, as all that follows, where nothing was flown.
    contacts, least_gap
        Pairs of a UAV and a mover that came nearer to one another than the clearance; the least distance of a UAV from
        a mover beyond the clearance, metres; below 0 it was too near.
    replans, unproven
        Answers to observations, for all UAVs, and those of them that had no proven way out.
    milliseconds, milliseconds_99, milliseconds_worst
        One answer took: the median, the 99th percentile and the most.
    """

    scenario: str
    planner: str
    budget: str
    seed: int
    status: str
    success: bool
    cost: float
    fuel: float | None
    divergence: float | None
    end: float | None
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
    flown_seconds: float | None = None
    flown_length: float | None = None
    least_length: float | None = None
    contacts: int | None = None
    least_gap: float | None = None
    replans: int | None = None
    unproven: int | None = None
    milliseconds: float | None = None
    milliseconds_99: float | None = None
    milliseconds_worst: float | None = None


LABELS = ("scenario", "planner", "budget")
"""The columns of labels; with the seed they identify a run."""
_NUMPY_TYPES: dict[Any, type] = {str: np.str_, bool: np.bool_, int: np.int64}
COLUMN_TYPES = {
    field.name: _NUMPY_TYPES.get(field.type, np.float64) for field in fields(Row) if field.type is not History
}
"""The numpy type of each field of a row except its history; ``None`` in a field of numbers becomes nan."""
