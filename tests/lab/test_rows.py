"""Rows in their file."""

import sqlite3
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse import History, InputError
from skyverse.lab import COLUMN_TYPES, Rows, plan_job
from studies import ROW, job


@pytest.fixture
def rows(tmp_path):
    with Rows(tmp_path / "rows.sqlite") as rows:
        yield rows


def test_a_row_comes_back_as_it_was_also_from_another_process(rows):
    made = plan_job(job())
    rows.add(made, "a")
    rows.add(ROW, "b")
    with Rows(rows.path) as again:
        assert list(again) == [made, ROW]
        assert again.done() == {"a", "b"}
        assert len(again) == 2


number = st.floats(allow_nan=False)
count = st.integers(0, 2**62)


@given(number, number, st.none() | number, count, st.text(), st.lists(st.tuples(number, count, count, count, count)))
def test_whatever_a_row_holds_comes_back(cost, end, gap, paths, verdict, history):
    columns = zip(*history, strict=True) if history else ([], [], [], [], [])
    kept = History(*(np.array(c, dtype=t) for c, t in zip(columns, (float, int, int, int, int), strict=True)))
    row = replace(ROW, cost=cost, end=end, gap=gap, generated_paths=paths, verdict=verdict, history=kept)
    with Rows(":memory:") as rows:
        rows.add(row, "k")
        (found,) = rows
    assert found == row


def test_columns_come_in_the_studys_order_whatever_the_order_of_finishing(rows):
    rows.expect("planner", ["z", "a"])
    rows.expect("scenario", ["map2", "map1", "never run"])
    runs = [("map1", "a", 1), ("map1", "z", 10), ("map2", "a", 2), ("map1", "z", 9), ("map2", "z", 0)]
    for key, (scenario, planner, seed) in enumerate(runs):
        rows.add(replace(ROW, scenario=scenario, planner=planner, seed=seed, cost=float(key)), str(key))
    found = rows.select(("scenario", "planner", "seed"))
    assert list(zip(*(found[k].tolist() for k in found), strict=True)) == [
        ("map2", "z", 0),
        ("map2", "a", 2),
        ("map1", "z", 9),
        ("map1", "z", 10),
        ("map1", "a", 1),
    ]
    assert rows.select(("cost",), scenario="map1", planner="z")["cost"].tolist() == [3, 1]
    assert rows.labels("scenario") == ["map2", "map1"]
    assert rows.labels("planner") == ["z", "a"]


def test_columns_are_arrays_of_their_type_and_none_is_nan(rows):
    rows.add(replace(ROW, gap=None, success=False, cost=np.inf), "k")
    rows.add(replace(ROW, seed=1), "l")
    found = rows.select(COLUMN_TYPES, planner="mvo", seed=np.int64(0))
    assert np.isnan(found["gap"][0])
    assert found["cost"].tolist() == [np.inf]
    assert (found["success"].dtype, found["seed"].dtype, found["scenario"].dtype.kind) == (np.bool_, np.int64, "U")
    assert rows.select(("success", "cost"), planner="none")["success"].shape == (0,)
    assert [h == ROW.history for h in rows.histories(seed=1)] == [True]


def test_a_run_is_added_once(rows):
    rows.add(ROW, "k")
    for row, key in ((ROW, "k"), (replace(ROW, seed=1), "k"), (ROW, "other")):
        with pytest.raises(InputError, match="map1, mvo, 1000 paths, seed"):
            rows.add(row, key)
    assert len(rows) == 1


def test_unknown_columns_are_refused(rows):
    with pytest.raises(ValueError, match="colour"):
        rows.select(("colour",))
    with pytest.raises(ValueError, match="colour"):
        rows.select(("cost",), colour=1)
    with pytest.raises(ValueError, match="colour"):
        rows.labels("colour")


def test_another_file_is_refused_and_left_alone(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("not a database " * 100)
    other = tmp_path / "other.sqlite"
    with sqlite3.connect(other) as file:
        file.execute("CREATE TABLE birds (name)")
    file.close()
    for path in (text, other, tmp_path, tmp_path / "no folder" / "rows"):
        with pytest.raises(InputError, match=path.name):
            Rows(path)
    assert text.read_text() == "not a database " * 100


def test_rows_can_be_read_while_they_are_written(rows):
    rows.add(ROW, "k")
    with Rows(rows.path) as reader:
        rows.add(replace(ROW, seed=1), "l")
        assert len(reader) == 2


def test_a_file_that_another_process_begins_at_the_same_instant_is_waited_for(tmp_path):
    other = sqlite3.connect(tmp_path / "rows.sqlite", isolation_level=None, check_same_thread=False)
    other.execute("BEGIN IMMEDIATE")
    timer = threading.Timer(0.3, other.close)
    timer.start()
    with Rows(tmp_path / "rows.sqlite") as rows:
        assert len(rows) == 0
    timer.join()


def test_notebooks_and_the_prompt_tell_what_rows_hold(rows):
    assert repr(rows).startswith("Rows: no runs in ")
    rows.add(ROW, "a")
    rows.add(replace(ROW, seed=ROW.seed + 1, planner="<mine>"), "b")
    assert repr(rows).startswith("Rows: 2 runs in ")
    assert "2 planners: " in repr(rows)
    shown = rows._repr_html_()
    assert shown.count("<tr>") == 3
    assert "&lt;mine&gt;" in shown
