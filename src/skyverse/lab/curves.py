"""Curves of a study: performance profiles, and the best cost so far as a function of effort."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.lab.statistics import quantile
from skyverse.model.result import History


def ratios(costs: ArrayLike, success: ArrayLike, reference: float) -> Floats:
    """Return each cost divided by `reference`, (n,): infinite where the run failed, 1 where both are equal."""
    numbers = np.asarray(costs, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(numbers == reference, 1.0, numbers / reference)
    return np.where(np.asarray(success, dtype=np.bool_), found, np.inf)


def profile(of: ArrayLike) -> tuple[Floats, Floats]:
    """Return the performance profile of cost ratios, in which failures are infinite (Dolan & More 2002).

    Returns
    -------
    ratio, share
        (m,) each, rising: the steps of the function that gives the share of all runs whose ratio is at most `ratio`.
    """
    found = np.asarray(of, dtype=np.float64)
    ratio, counts = np.unique(found[np.isfinite(found)], return_counts=True)
    return ratio, np.cumsum(counts) / max(1, len(found))


def grid(most: float, *, points: int = 200) -> Floats:
    """Return at most `points` whole numbers from 1 to `most`, at equal ratios where they are large."""
    return np.unique(np.rint(np.geomspace(1.0, max(1.0, most), points)))


def best_so_far(history: History, at: ArrayLike) -> Floats:
    """Return the best cost, (m,), after `at`, (m,), evaluations; infinite before the first."""
    best = np.concatenate([[np.inf], np.minimum.accumulate(history.cost)])
    return best[np.searchsorted(history.evaluations, at, side="right")]


Band = tuple[Floats, Floats, Floats, Floats]
"""Evaluations, and after so many the quartiles of the best cost so far over many runs: low, median, high, (m,) each."""


def band(histories: Iterable[History], at: Floats) -> Band:
    """Return quartiles of the runs' best costs after `at` evaluations.

    A run without a path costs infinity, and one that has ended keeps its last cost.
    """
    runs = np.array([best_so_far(history, at) for history in histories]).reshape(-1, len(at))
    if len(runs) == 0:
        runs = np.full((1, len(at)), np.inf)
    return at, quantile(runs, 0.25), quantile(runs, 0.5), quantile(runs, 0.75)


def run_lengths(histories: Iterable[History], targets: ArrayLike) -> Floats:
    """Return the evaluations after which each run's cost was at most each of the targets, (n, k); infinite if never."""
    wanted = np.asarray(targets, dtype=np.float64)
    found = [
        np.where(history.cost[:, None] <= wanted, history.evaluations[:, None], np.inf).min(axis=0, initial=np.inf)
        for history in histories
    ]
    return np.array(found).reshape(-1, len(wanted))


def expected_run_length(lengths: ArrayLike, spent: ArrayLike) -> float:
    """Return the evaluations that independent restarts take in the mean to reach a target (ERT; Auger, Hansen 2005).

    Parameters
    ----------
    lengths, spent
        (n,) after how many evaluations each run reached it, infinite if it did not, and how many it spent in all.
    """
    reached = np.asarray(lengths, dtype=np.float64)
    total = np.where(np.isfinite(reached), reached, np.asarray(spent, dtype=np.float64)).sum()
    hits = np.count_nonzero(np.isfinite(reached))
    return float(total / hits) if hits else np.inf


def spread(efforts: ArrayLike) -> float:
    """Return the ratio of the largest of some mean efforts to the least; 1 where all are equal, even zero."""
    found = np.asarray(efforts, dtype=np.float64)
    least, most = float(found.min()), float(found.max())
    return 1.0 if least == most else most / least if least > 0 else np.inf
