"""One row a flight: what it says is what was flown, and what the referee finds."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from replanned import hall
from skyverse.lab.fly_job import KnownBeforehand, MovingCase, MovingJob, OwnReplanner
from skyverse.lab.moving_row import MovingRows
from skyverse.lab.run_study import run_jobs
from skyverse.live.policies import make_policy


def case(**changes):
    fields = {
        "label": "hall", "movers_label": "patrols", "scenario": hall(), "kind": "patrols", "count": 3, "speed": 0.5,
        "hidden": 0, "sensor": sky.Sensor(range=6.0), "longest": 30.0,
    }  # fmt: skip
    return MovingCase(**fields | changes)


def job(contender=None, seed=0, label="policy", **changes):
    return MovingJob(case(**changes), OwnReplanner() if contender is None else contender, label, seed)


@pytest.mark.parametrize(
    "contender", [OwnReplanner(), make_policy("wait"), make_policy("velocity-obstacles"), KnownBeforehand()]
)
def test_no_flight_beats_the_bounds_in_hindsight(contender):
    row = job(contender).row()
    assert (row.arrived, row.safe, row.contacts, row.verdict) == (True, True, 0, "")
    assert row.least_gap >= 0.0
    assert 1.0 <= row.time_ratio == row.seconds / row.seconds_bound
    assert 1.0 - 1e-9 <= row.length_ratio == row.length / row.length_bound
    assert row.length_bound == pytest.approx(18.0)
    assert row.milliseconds <= row.milliseconds_99 <= row.milliseconds_worst
    assert (row.replans == 0) is isinstance(contender, KnownBeforehand)


def test_a_flight_that_believes_what_it_should_not_has_a_contact_in_its_row():
    head_on = sky.Mover(
        name="ram",
        shape=sky.Box(min=(0, -4.5, -1), max=(0.5, 4.5, 3)),  # wider than any way round it that is seen in time
        motion=sky.WaypointMotion(points=[(19.5, 5, 1), (0.5, 5, 1)], times=[0, 6]),
    )
    blind = make_policy("velocity-obstacles", proven=False, horizon=0.1)
    row = job(blind, count=0, scenario=sky.Scenario(**{**dict(hall()), "movers": [head_on]})).row()
    assert row.contacts == 1
    assert row.least_gap < 0.0
    assert not row.safe
    assert "mover 'ram'" in row.verdict


def test_a_flight_that_is_given_up_is_endless_and_no_fault():
    row = job(longest=1.0).row()
    assert (row.arrived, row.safe, row.verdict) == (False, True, "")
    assert (row.time_ratio, row.length_ratio, row.seconds) == (np.inf, np.inf, 1.0)


def test_hidden_obstacles_are_met_in_flight():
    wall = sky.Box(min=(10, 2, 0), max=(10.5, 8, 4))
    known, met = (job(count=0, scenario=hall(wall), hidden=hidden).row() for hidden in (0, 1))
    assert (known.safe, met.safe) == (True, True)
    assert met.length > known.length


def test_rows_are_kept_and_not_flown_again(tmp_path):
    wanted = [job(make_policy("wait"), seed, "wait") for seed in range(2)]
    told = []
    with MovingRows(tmp_path / "rows.sqlite") as rows:
        run_jobs(wanted, rows)
        before = list(rows)
        run_jobs(wanted, rows, on_run=lambda *counts: told.append(counts))
        assert told == [(2, 2)]
        assert [row.seed for row in before] == [0, 1]
        assert rows.labels("policy") == ["wait"]
        assert rows.select(("time_ratio",))["time_ratio"].tolist() == [row.time_ratio for row in before]
        edited = [replace(one, case=case(speed=0.6)) for one in wanted]
        with pytest.raises(sky.InputError, match=r"holds the run hall, patrols, wait, seed 0, but of another scenario"):
            run_jobs(edited, rows)
        (written,) = rows.export(tmp_path / "rows.csv")
        assert written.read_text().splitlines()[0].startswith("scenario,movers,policy,seed,arrived")
        assert len(written.read_text().splitlines()) == 3
    with pytest.raises(sky.InputError, match="found rows of another kind of study"):
        sky.Rows(tmp_path / "rows.sqlite")


def test_the_same_flight_has_the_same_row_but_for_its_milliseconds():
    policy = make_policy("from-scratch", planner="mvo", paths=30)
    first, second = (job(policy).row() for _ in range(2))
    clockless = {"milliseconds": 0.0, "milliseconds_99": 0.0, "milliseconds_worst": 0.0}
    assert replace(first, **clockless) == replace(second, **clockless)
    assert first.generated_paths > 0
