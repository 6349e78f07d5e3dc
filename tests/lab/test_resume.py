"""A study killed at any instant goes on where it was."""

import os
import random
import signal
import subprocess
import sys
import time

import pytest

from skyverse.lab.moving_row import MovingRows
from skyverse.lab.rows import Rows
from skyverse.lab.run_study import run_study
from skyverse.lab.study import read_study
from studies import timeless

WORDS = ("map1", "map2", "--planner", "mvo", "--planner", "random-restart", "--runs", "30", "--paths", "1000")


def compare(folder, *words):
    command = [sys.executable, "-m", "skyverse", "compare", *WORDS, "--no-report", "-o", str(folder), *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)


def finished(process):
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return out, err


def kept(folder):
    if not (folder / "rows.sqlite").exists():
        return []
    with Rows(folder / "rows.sqlite") as rows:
        return list(rows)


def count_when(folder, least, process, kind=Rows):
    """Wait until so many rows are there, and return how many are."""
    for _ in range(6000):
        time.sleep(0.01)
        if (folder / "rows.sqlite").exists():
            with kind(folder / "rows.sqlite") as rows:
                if len(rows) >= least:
                    return len(rows)
        assert process.poll() is None, process.communicate()
    process.kill()
    raise AssertionError(f"no rows came: {process.communicate()}")


@pytest.mark.skipif(os.name == "nt", reason="process groups are killed with POSIX signals")
def test_a_study_killed_again_and_again_ends_with_the_rows_of_one_that_was_not(tmp_path):
    chance = random.Random(time.time_ns())
    folder = tmp_path / "killed"
    before = []
    for least in (1, 50):
        process = compare(folder, "--workers", "2")
        count_when(folder, least, process)
        time.sleep(chance.uniform(0, 0.1))
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        rows = kept(folder)
        known = {(row.scenario, row.planner, row.seed): row for row in rows}
        assert all(known[row.scenario, row.planner, row.seed] == row for row in before)  # its seconds, too: not again
        before = rows
    assert len(before) >= 50
    out, err = finished(compare(folder, "--workers", "2"))
    assert f"{len(before)} of 120 runs were done before" in err
    assert "The referee found nothing wrong." in out
    rows = kept(folder)
    assert all(row in rows for row in before)
    with run_study(read_study(folder / "study.yaml"), tmp_path / "whole.sqlite") as whole:
        assert timeless(rows) == timeless(whole)


FLIGHTS = """
scenarios: [map2]
movers: {kind: patrols, count: 2, speed: 0.3}
policies: [wait, {policy: from-scratch, planner: astar}]
seeds: 6
longest: 20
"""


@pytest.mark.skipif(os.name == "nt", reason="process groups are killed with POSIX signals")
def test_flights_killed_go_on_where_they_were(tmp_path):
    (tmp_path / "study.yaml").write_text(FLIGHTS)
    folder = tmp_path / "killed"
    command = [sys.executable, "-m", "skyverse", "compare", str(tmp_path / "study.yaml"), "-o", str(folder)]
    command += ["--workers", "2", "--no-report"]

    def start():
        return subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )

    process = start()
    count_when(folder, 2, process, MovingRows)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    with MovingRows(folder / "rows.sqlite") as rows:
        before = list(rows)
    assert 2 <= len(before) < 12
    _, err = finished(start())
    assert f"{len(before)} of 12 runs were done before" in err
    with MovingRows(folder / "rows.sqlite") as rows:
        after = list(rows)
    assert all(row in after for row in before)  # their milliseconds, too: they were not flown again
    assert [(row.policy, row.seed) for row in after] == [
        (policy, seed) for policy in ("wait", "from-scratch planner=astar") for seed in range(6)
    ]


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is a POSIX signal here")
@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_ends_with_130_and_says_how_to_go_on(tmp_path, workers):
    process = compare(tmp_path, "--workers", workers, "--seed", "100")
    count_when(tmp_path, 3, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert f"skyverse: interrupted; {len(kept(tmp_path))} of 120 runs are kept in {tmp_path}" in err
    assert "Traceback" not in err
