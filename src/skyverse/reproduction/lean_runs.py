"""Runs of which only cost and effort are kept and which no referee judges, for claims on many sets of seeds."""

import hashlib
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skyverse._typing import Floats
from skyverse.lab.run_job import Job
from skyverse.model.result import History
from skyverse.reproduction.cell_runs import problems

_COLUMNS = ("seed", "cost", "generated_paths", "generated_nodes", "success", "milliseconds")


class LeanRuns:
    """What `CellRuns` reads of `Rows`: by scenario, planner and budget, the totals of runs, (n, 6), and their curves.

    A curve is (3, k): best cost, paths and nodes after each iteration of a single UAV's search.
    """

    def __init__(self, runs: dict[tuple[str, ...], tuple[Floats, Floats]]) -> None:
        self._runs = runs

    def labels(self, kind: str) -> list[str]:
        """Return the labels of the runs of one kind: of scenarios, planners or budgets."""
        place = ("scenario", "planner", "budget").index(kind)
        return sorted({run[place] for run in self._runs})

    def select(self, columns: Sequence[str], **where: object) -> dict[str, NDArray[Any]]:
        """Return columns of the runs of one scenario, planner and budget, (n,) each."""
        totals, _ = self._found(where)
        return {column: totals[:, _COLUMNS.index(column)] for column in columns}

    def histories(self, **where: object) -> Iterator[History]:
        """Yield the history of each run, in the order of `select`; paths evaluated are not kept."""
        _, curves = self._found(where)
        for cost, paths, nodes in curves:
            yield History(cost, paths, nodes, np.zeros_like(paths))

    def _found(self, where: dict[str, object]) -> tuple[Floats, Floats]:
        run = tuple(str(where[kind]) for kind in ("scenario", "planner", "budget"))
        return self._runs.get(run, (np.empty((0, len(_COLUMNS))), np.empty((0, 3, 0))))


def kept_lean(jobs: Sequence[Job], path: Path) -> LeanRuns:
    """Return the runs of the file at `path`; make them first, unless the file is of the same jobs."""
    digest = hashlib.sha256("".join(job.key for job in jobs).encode()).hexdigest()
    if path.exists():
        with np.load(path, allow_pickle=False) as kept:
            if str(kept["digest"]) == digest:
                return _restored(kept)
    arrays = _made(jobs)
    path.parent.mkdir(parents=True, exist_ok=True)
    scratch = path.with_suffix(".part.npz")
    np.savez_compressed(scratch, **{"digest": np.array(digest), **arrays})  # type: ignore[arg-type]
    scratch.replace(path)
    return _restored(arrays)


def run_lean(jobs: Sequence[Job]) -> LeanRuns:
    """Make the runs, in this order, in this process."""
    return _restored(_made(jobs))


def _made(jobs: Sequence[Job]) -> dict[str, Floats]:
    totals, curves = defaultdict(list), defaultdict(list)
    for job in jobs:
        given = problems(job.case)
        many = len(given) > 1
        streams: Sequence[Any] = np.random.default_rng(job.seed).spawn(len(given)) if many else [job.seed]
        start = time.process_time()
        found = [job.planner.plan(p, stop=job.stop, rng=s) for p, s in zip(given, streams, strict=True)]
        spent = 1000 * (time.process_time() - start)
        effort = [result.effort for result in found]
        paths, nodes = sum(e.generated_paths for e in effort), sum(e.generated_nodes for e in effort)
        reached = all(result.status.reached for result in found)
        totals[job.run[:3]].append((job.seed, sum(result.cost for result in found), paths, nodes, reached, spent))
        if len(found) == 1 and "iterations" in job.budget:
            history = found[0].history.by_iteration()
            curves[job.run[:3]].append((history.cost, history.generated_paths, history.generated_nodes))
    arrays = {}
    for run, rows in totals.items():
        arrays["\t".join((*run, "totals"))] = np.array(rows, dtype=np.float64)
        arrays["\t".join((*run, "curves"))] = np.array(curves.get(run, np.empty((0, 3, 0))), dtype=np.float64)
    return arrays


def _restored(arrays: Any) -> LeanRuns:
    named = [name.rsplit("\t", 1)[0] for name in arrays if name.endswith("\ttotals")]
    return LeanRuns({tuple(run.split("\t")): (arrays[f"{run}\ttotals"], arrays[f"{run}\tcurves"]) for run in named})
