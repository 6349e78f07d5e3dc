"""Runs on a Dask cluster."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import skyverse as sky
from own_planner import MODULE
from patience import PATIENCE_S
from skyverse.lab import Rows, run_jobs
from skyverse.planners import make_planner
from studies import job, timeless

# In a process of its own: a cluster leaves sockets, threads and warnings behind that are no business of the tests.
SCRIPT = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {tests!r})

if __name__ == "__main__":
    from distributed import LocalCluster
    from studies import Deadly, job
    import skyverse as sky
    from skyverse.lab import Rows, run_jobs
    from skyverse.planners import make_planner

    folder = Path({folder!r})
    options = dict(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=folder)
    with LocalCluster(**options) as cluster, Rows(folder / "rows.sqlite") as rows:
        killed = []

        def kill(done, total):
            if done == 10:
                worker = next(iter(cluster.workers.values()))
                os.kill(worker.pid, signal.SIGKILL)
                killed.append(worker.pid)

        planners = (("mvo", sky.MVO()), ("shake", make_planner("shake_on_dask:Shake")))
        wanted = [job(planner, seed, name, scenario=sky.read("map1"), stop=sky.MaxPaths(500))
                  for name, planner in planners for seed in range(30)]
        run_jobs(wanted, rows, dask=cluster.scheduler_address, on_run=kill)
        assert killed, "no worker was killed"
        print(len(rows))
"""


def test_a_cluster_whose_worker_is_killed_gives_the_rows_of_this_machine(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="needs skyverse[dask]")
    (tmp_path / "shake_on_dask.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(tests=str(Path(__file__).parents[1] / "support"), folder=str(tmp_path)))
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=PATIENCE_S)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1] == "60"
    wanted = [
        job(planner, seed, name, scenario=sky.read("map1"), stop=sky.MaxPaths(500))
        for name, planner in (("mvo", sky.MVO()), ("shake", make_planner("shake_on_dask:Shake")))
        for seed in range(30)
    ]
    with Rows(tmp_path / "rows.sqlite") as theirs, Rows(tmp_path / "here.sqlite") as here:
        run_jobs(wanted, here)
        assert timeless(theirs) == timeless(here)
        assert theirs.done() == here.done()
