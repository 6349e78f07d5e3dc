"""Curves of a study: performance profiles, and the best cost so far against effort."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skyverse._typing import Floats
from skyverse.lab.statistics import quantile
from skyverse.model.result import History

EFFORTS = ("generated_paths", "generated_nodes", "evaluations", "iterations")


def ratios(costs: ArrayLike, success: ArrayLike, reference: float) -> Floats:
    """Return each cost over `reference`, infinite where the run failed; 1 where both are equal, (n,)."""
    numbers = np.asarray(costs, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.where(numbers == reference, 1.0, numbers / reference)
    return np.where(np.asarray(success, dtype=np.bool_), found, np.inf)


def profile(of: ArrayLike) -> tuple[Floats, Floats]:
    """Return the performance profile of some ratios, failures infinite (Dolan & More 2002).

    Returns
    -------
    ratio, share
        (m,) each, rising: the share of all runs whose ratio is at most `ratio`, a step function.
    """
    found = np.asarray(of, dtype=np.float64)
    ratio, counts = np.unique(found[np.isfinite(found)], return_counts=True)
    return ratio, np.cumsum(counts) / max(1, len(found))


def grid(most: float, *, points: int = 200, log: bool = False) -> Floats:
    """Return at most `points` whole numbers from 1 to `most`, evenly spread, or evenly in their logarithms."""
    top = max(1.0, most)
    spread = np.geomspace(1.0, top, points) if log else np.linspace(1.0, top, points)
    return np.unique(np.ceil(spread - 1e-9))


def best_so_far(history: History, effort: str, at: ArrayLike) -> Floats:
    """Return the best cost once so much `effort`, one of `EFFORTS`, was spent; infinite before the first, (m,)."""
    steps = np.arange(len(history.cost)) if effort == "iterations" else getattr(history, effort)
    best = np.concatenate([[np.inf], np.minimum.accumulate(history.cost)])
    return best[np.searchsorted(steps, at, side="right")]


@dataclass(frozen=True)
class Band:
    """The best cost so far of many runs against effort, (m,) each; a run that has ended keeps its last."""

    effort: Floats
    mean: Floats
    low: Floats
    median: Floats
    high: Floats


def band(histories: Iterable[History], effort: str, at: Floats) -> Band:
    """Return mean and quartiles of the runs' best costs at the efforts `at`; infinite where that many had no path."""
    runs = np.array([best_so_far(history, effort, at) for history in histories]).reshape(-1, len(at))
    if len(runs) == 0:
        nothing = np.full(len(at), np.inf)
        return Band(at, nothing, nothing, nothing, nothing)
    return Band(at, runs.mean(axis=0), *(quantile(runs, q) for q in (0.25, 0.5, 0.75)))


def spread(efforts: ArrayLike) -> float:
    """Return how many times the least of some mean efforts the largest is; 1 where all are equal, even zero."""
    found = np.asarray(efforts, dtype=np.float64)
    least, most = float(found.min()), float(found.max())
    return 1.0 if least == most else most / least if least > 0 else np.inf
