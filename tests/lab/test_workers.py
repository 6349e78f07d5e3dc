"""Many runs, shared by processes."""

import multiprocessing
import signal
import tracemalloc

import pytest

import skyverse as sky
from skyverse.lab import Rows, WorkerError, run_jobs, run_study
from studies import ROOM, Deadly, Instant, job, timeless


def jobs(count, *planners):
    return [job(p, seed, type(p).__name__) for p in planners or (Instant(length=3),) for seed in range(count)]


@pytest.fixture
def rows(tmp_path):
    with Rows(tmp_path / "rows.sqlite") as rows:
        yield rows


def test_one_worker_and_three_give_the_same_rows_in_the_same_order(tmp_path):
    study = sky.Study(
        scenarios=["map1", "table-4.9-2"],
        planners=["mvo", {"planner": "mvo", "as_run": True}, "random-restart", "astar"],
        seeds=2,
        budget=[{"paths": 50}, {"iterations": 3}],
    )
    with (
        run_study(study, tmp_path / "one.sqlite") as one,
        run_study(study, tmp_path / "three.sqlite", workers=3) as three,
    ):
        assert len(one) == 2 * 4 * 2 * 2
        assert timeless(one) == timeless(three)
        assert one.done() == three.done()
        assert one.labels("planner") == ["mvo", "mvo as_run=True", "random-restart", "astar"]


def test_what_is_done_is_not_run_again(rows):
    told = []
    run_jobs(jobs(3), rows, on_run=lambda *counts: told.append(counts))
    assert told == [(0, 3), (1, 3), (2, 3), (3, 3)]
    before = list(rows)
    told.clear()
    run_jobs(jobs(5), rows, on_run=lambda *counts: told.append(counts))
    assert told == [(3, 5), (4, 5), (5, 5)]
    assert list(rows)[:3] == before
    told.clear()
    run_jobs(jobs(5), rows, workers=2, on_run=lambda *counts: told.append(counts))
    assert told == [(5, 5)]


def test_an_edited_scenario_is_not_taken_for_the_old_one(rows, refuses):
    run_jobs(jobs(2), rows)
    edited = job(Instant(length=3), 0, "Instant", scenario=ROOM.model_copy(update={"clearance": 0.2}))
    with refuses():
        run_jobs([edited], rows)
    with refuses():
        run_jobs([job(), job()], rows)


def test_a_worker_that_dies_is_replaced_and_its_run_done_again(rows, tmp_path):
    deadly = Deadly(file=str(tmp_path / "died"), once=True)
    wanted = jobs(6, deadly, Instant(length=3))
    run_jobs(wanted, rows, workers=2)
    assert len(rows) == 12
    assert rows.done() == {job.key for job in wanted}


def test_a_run_that_kills_every_worker_is_named_and_the_others_are_kept(rows, tmp_path):
    deadly = Deadly(file=str(tmp_path / "never made"), once=False)
    with pytest.raises(WorkerError, match=r"the run room, Deadly, 30 paths, seed 1 ended its process twice.* -9"):
        run_jobs(jobs(3, deadly), rows, workers=2)
    assert 0 in rows.select(("seed",))["seed"]


def test_an_error_in_a_worker_is_an_error_here_and_leaves_no_process_behind(rows, refuses):
    clock = job(sky.MVO(), stop=sky.MaxSeconds(1) | sky.MaxSeconds(2))  # counts nothing
    with refuses():
        run_jobs([clock], rows, workers=2)
    with pytest.raises(RuntimeError, match=r"in the run room, planner, 30 paths, seed 0:\n(.*\n)*TypeError"):
        run_jobs([job(Instant(length="many"))], rows, workers=2)
    assert not multiprocessing.active_children()


def test_ctrl_c_ends_the_workers_and_keeps_what_is_done(rows):
    with pytest.raises(KeyboardInterrupt):
        run_jobs(jobs(3000), rows, workers=2, on_run=lambda done, _: done == 3 and signal.raise_signal(signal.SIGINT))
    kept = len(rows)
    assert 3 <= kept < 3000
    assert not multiprocessing.active_children()
    run_jobs(jobs(kept + 5), rows)
    assert len(rows) == kept + 5


def test_memory_stays_flat_however_many_runs_there_are(tmp_path):
    held = []

    def look(done, _):
        if done in (50, 250):
            held.append(tracemalloc.get_traced_memory()[0])

    tracemalloc.start()
    try:
        with Rows(tmp_path / "rows.sqlite") as rows:
            run_jobs(jobs(250, Instant(length=1000)), rows, workers=2, on_run=look)  # each row takes 32 kB
            assert len(rows) == 250
    finally:
        tracemalloc.stop()
    few, many = held
    assert (many - few) / 200 < 2000  # bytes a run, not its row
