"""A study killed at any instant goes on where it was."""

import os
import signal
import subprocess
import sys

import pytest

from patience import PATIENCE_S, wait_until
from skyverse.lab import Rows, read_study, run_study
from studies import timeless

WORDS = ("map1", "map2", "--planner", "mvo", "--planner", "random-restart", "--paths", "1000")
PROCESS = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}


@pytest.fixture
def started():
    """Return a function that starts `skyverse compare`; what still runs after the test is killed."""
    processes = []

    def start(*words):
        command = [sys.executable, "-m", "skyverse", "compare", "--no-report", *map(str, words)]
        processes.append(subprocess.Popen(command, **PROCESS))
        return processes[-1]

    yield start
    for process in processes:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def finished(process):
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, err
    return out, err


def kept(folder):
    if not (folder / "rows.sqlite").exists():
        return []
    with Rows(folder / "rows.sqlite") as rows:
        return list(rows)


def wait_for_rows(folder, least, process):
    """Wait until so many rows are there."""

    def there():
        if not (folder / "rows.sqlite").exists():
            return False
        with Rows(folder / "rows.sqlite") as rows:
            return len(rows) >= least

    wait_until(there, process)


@pytest.mark.skipif(os.name == "nt", reason="process groups are killed with POSIX signals")
def test_a_study_killed_again_and_again_ends_with_the_rows_of_one_that_was_not(started, tmp_path):
    folder = tmp_path / "killed"
    words = (*WORDS, "--runs", 12, "-o", folder)
    before = []
    for least in (1, 20):
        process = started(*words, "--workers", 2)
        wait_for_rows(folder, least, process)
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        rows = kept(folder)
        known = {(row.scenario, row.planner, row.seed): row for row in rows}
        assert all(known[row.scenario, row.planner, row.seed] == row for row in before)  # its seconds, too: not again
        before = rows
    assert len(before) >= 20
    out, err = finished(started(*words, "--workers", 1))
    assert f"{len(before)} of 48 runs were done before" in err
    assert "The referee found nothing wrong." in out
    rows = kept(folder)
    assert all(row in rows for row in before)
    with run_study(read_study(folder / "study.yaml"), tmp_path / "whole.sqlite") as whole:
        assert timeless(rows) == timeless(whole)


SHORT = """
scenarios: [map1]
planners: [astar]
seeds: 3
"""

FLIGHTS = """
scenarios: [map2]
movers: {kind: patrols, count: 2, speed: 0.3}
policies: [wait, {policy: from-scratch, planner: astar}]
seeds: 3
longest: 20
"""


@pytest.mark.skipif(os.name == "nt", reason="process groups are killed with POSIX signals")
def test_flights_killed_go_on_where_they_were(started, tmp_path):
    (tmp_path / "study.yaml").write_text(FLIGHTS)
    folder = tmp_path / "killed"
    words = (tmp_path / "study.yaml", "-o", folder)
    process = started(*words, "--workers", 2)
    wait_for_rows(folder, 1, process)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    before = kept(folder)
    assert before
    _, err = finished(started(*words, "--workers", 1))
    assert f"{len(before)} of 6 runs were done before" in err
    after = kept(folder)
    assert all(row in after for row in before)  # their milliseconds, too: they were not flown again
    assert [(row.planner, row.seed) for row in after] == [
        (policy, seed) for policy in ("wait", "from-scratch planner=astar") for seed in range(3)
    ]


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is a POSIX signal here")
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_ends_with_130_and_says_how_to_go_on(started, tmp_path, workers):
    process = started(*WORDS, "--runs", 500, "-o", tmp_path, "--workers", workers)  # more than it will ever get to
    wait_for_rows(tmp_path, 3, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert f"skyverse: interrupted; {len(kept(tmp_path))} of 2000 runs are kept in {tmp_path}" in err
    assert "Traceback" not in err


def test_a_study_interrupted_after_a_row_was_written_tells_of_that_row_too(tmp_path, monkeypatch):
    add, told = Rows.add, []

    def add_and_interrupt(rows, row, key):
        add(rows, row, key)
        if len(rows) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(Rows, "add", add_and_interrupt)
    (tmp_path / "study.yaml").write_text(SHORT)
    with pytest.raises(KeyboardInterrupt):
        run_study(
            read_study(tmp_path / "study.yaml"), tmp_path / "rows.sqlite", on_run=lambda *counts: told.append(counts)
        )
    assert told == [(0, 3), (1, 3), (2, 3)]
