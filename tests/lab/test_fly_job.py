"""One row a flight: what it says is what was flown, and what the referee finds."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from replanned import hall
from skyverse.lab import Case, Encounters, Job, KnownBeforehand, OwnReplanner, fly_job, run_jobs
from skyverse.live import make_policy


def case(scenario=None, longest=30.0, **changes):
    met = Encounters.model_validate({"kind": "patrols", "count": 3, "speed": 0.5} | changes)
    scenario = hall() if scenario is None else scenario
    return Case("hall", scenario, encounters=met, sensor=sky.Sensor(range=6.0), longest=longest)


def job(contender=None, seed=0, label="policy", **changes):
    return Job(case(**changes), contender or OwnReplanner(), label, None, "30 s of flight", seed)


@pytest.mark.parametrize(
    "contender", [OwnReplanner(), make_policy("wait"), make_policy("velocity-obstacles"), KnownBeforehand()]
)
def test_no_flight_beats_the_bounds_in_hindsight(contender):
    row = fly_job(job(contender))
    assert (row.status, row.success, row.contacts, row.verdict) == ("arrived", True, 0, "")
    assert row.least_gap >= 0.0
    assert row.cost == row.flown_seconds
    assert 0.0 <= row.gap == row.cost / row.bound - 1.0
    assert row.least_length - 1e-9 <= row.flown_length
    assert row.least_length == pytest.approx(18.0)
    assert row.milliseconds <= row.milliseconds_99 <= row.milliseconds_worst
    assert (row.replans == 0) is isinstance(contender, KnownBeforehand)


def test_a_flight_that_believes_what_it_should_not_has_a_contact_in_its_row():
    head_on = sky.Mover(
        name="ram",
        shape=sky.Box(min=(0, -4.5, -1), max=(0.5, 4.5, 3)),  # wider than any way round it that is seen in time
        motion=sky.WaypointMotion(points=[(19.5, 5, 1), (0.5, 5, 1)], times=[0, 6]),
    )
    blind = make_policy("velocity-obstacles", proven=False, horizon=0.1)
    row = fly_job(job(blind, count=0, scenario=sky.Scenario(**{**dict(hall()), "movers": [head_on]})))
    assert row.contacts == 1
    assert row.least_gap < 0.0
    assert (row.success, row.cost, row.gap) == (False, np.inf, None)
    assert "mover 'ram'" in row.verdict


def test_a_flight_that_is_given_up_is_endless_and_no_fault():
    row = fly_job(job(longest=1.0))
    assert (row.status, row.success, row.verdict) == ("not arrived", False, "")
    assert (row.cost, row.gap, row.flown_seconds) == (np.inf, None, 1.0)


def test_hidden_obstacles_are_met_in_flight():
    wall = sky.Box(min=(10, 2, 0), max=(10.5, 8, 4))
    known, met = (fly_job(job(count=0, scenario=hall(wall), hidden=hidden)) for hidden in (0, 1))
    assert (known.success, met.success) == (True, True)
    assert met.flown_length > known.flown_length


def test_rows_are_kept_and_not_flown_again(tmp_path, refuses):
    wanted = [job(make_policy("wait"), seed, "wait") for seed in range(2)]
    told = []
    with sky.Rows(tmp_path / "rows.sqlite") as rows:
        run_jobs(wanted, rows)
        before = list(rows)
        run_jobs(wanted, rows, on_run=lambda *counts: told.append(counts))
        assert told == [(2, 2)]
        assert [row.seed for row in before] == [0, 1]
        assert rows.labels("planner") == ["wait"]
        assert rows.select(("gap",))["gap"].tolist() == [row.gap for row in before]
        edited = [replace(one, case=case(speed=0.6)) for one in wanted]
        with refuses():
            run_jobs(edited, rows)
        written, histories = rows.export(tmp_path / "rows.csv")
        assert [len(file.read_text().splitlines()) for file in (written, histories)] == [3, 1]


def test_the_same_flight_has_the_same_row_but_for_its_milliseconds():
    policy = make_policy("from-scratch", planner="mvo", paths=30)
    first, second = (fly_job(job(policy)) for _ in range(2))
    clockless = dict.fromkeys(("seconds", "milliseconds", "milliseconds_99", "milliseconds_worst"), 0.0)
    assert replace(first, **clockless) == replace(second, **clockless)
    assert first.generated_paths > 0
