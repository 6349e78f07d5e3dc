"""Lean runs are the same runs, kept for as long as the jobs are the same."""

import numpy as np

from skyverse.lab.rows import Rows
from skyverse.lab.run_job import run_job
from skyverse.reproduction import lean_runs
from skyverse.reproduction.cell_runs import CellRuns, case, cell, equal
from skyverse.reproduction.lean_runs import kept_lean, run_lean

ONE, FLEET = case("map2"), case("table-4.9-2", "euclidean")


def wanted(seeds=range(3)):
    return [
        *cell(ONE, "GSO", "as described", 25, 50, seeds),
        *cell(FLEET, "MVO", "as run", 20, 3, seeds),
        *equal(ONE, "BBO", "as run", 25, seeds),
    ]


def read(cells):
    return {
        "shorter": cells.values("cost", ONE, "GSO", "as described", 25, 7),
        "nodes": cells.values("generated_nodes", ONE, "GSO", "as described", 25, 50),
        "fleet": cells.values("cost", FLEET, "MVO", "as run", 20, 3),
        "equal": cells.equal("generated_nodes", ONE, "BBO", "as run", 25, "1000 paths"),
        "until": cells.iterations_until(300.0, ONE, "GSO", "as described", 25, 50),
        "exact": cells.exact("generated_nodes", ONE),
    }


def test_lean_runs_are_those_that_studies_make(tmp_path):
    with Rows(tmp_path / "rows.sqlite") as rows:
        for job in wanted():
            rows.add(run_job(job), job.key)
        truth = read(CellRuns(rows, range(3)))
    found = read(CellRuns(run_lean(wanted()), range(3)))
    for name, values in truth.items():
        assert np.array_equal(found[name], values), name
    curve = truth["until"]
    assert ((curve >= 0) & (curve <= 51)).all()


def test_kept_runs_are_not_made_again_unless_the_jobs_are_others(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(lean_runs, "_made", lambda jobs, make=lean_runs._made: made.append(len(jobs)) or make(jobs))
    jobs, path = wanted(), tmp_path / "sets" / "seeds-0.npz"
    first = read(CellRuns(kept_lean(jobs, path), range(3)))
    again = read(CellRuns(kept_lean(jobs, path), range(3)))
    assert made == [len(jobs)]
    assert all(np.array_equal(again[name], first[name]) for name in first)
    kept_lean(wanted(range(2)), path)
    assert len(made) == 2
