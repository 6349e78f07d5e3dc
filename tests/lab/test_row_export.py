"""Rows for other programs, read by them."""

import csv
import tracemalloc

import numpy as np
import pytest

import skyverse as sky
from skyverse.lab import COLUMN_TYPES, Rows, plan_job, run_jobs
from studies import Instant, Liar, job


@pytest.fixture
def rows(tmp_path):
    shut = sky.read("map1").model_copy(update={"targets": (sky.Target(position=(5, 2.2, 1)),)})
    with Rows(tmp_path / "rows.sqlite") as rows:
        run_jobs([job(seed=s, label='say "mvo", twice', scenario=sky.read("map1")) for s in range(3)], rows)
        run_jobs([job(scenario=shut, case="shut"), job(Liar(), label="liar")], rows)
        yield rows


def told(rows, column):
    return [None if isinstance(v, float) and np.isnan(v) else v for v in rows.select((column,))[column].tolist()]


def test_csv_reads_back_by_the_standard_library_and_by_pandas(rows, tmp_path):
    runs, histories = rows.export(tmp_path / "out.csv")
    assert (runs.name, histories.name) == ("out.csv", "out-history.csv")
    with runs.open(newline="", encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert list(read[0]) == list(COLUMN_TYPES)
    for column in COLUMN_TYPES:
        assert [line[column] for line in read] == ["" if v is None else str(v) for v in told(rows, column)]
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_csv(histories)
    for seed, history in enumerate(rows.histories(scenario="map1")):
        own = frame[(frame.scenario == "map1") & (frame.seed == seed)]
        assert own.iteration.tolist() == history.iteration.tolist()
        assert own.cost.tolist() == history.cost.tolist()
        assert own.generated_nodes.tolist() == history.generated_nodes.tolist()
    assert "shut" not in set(frame.scenario)


def test_parquet_reads_back_by_pyarrow_with_types_and_nulls(rows, tmp_path):
    pytest.importorskip("pyarrow", reason="needs skyverse[parquet]")
    from pyarrow import parquet, types

    runs, histories = rows.export(tmp_path / "out.parquet")
    table = parquet.read_table(runs)
    assert table.column_names == list(COLUMN_TYPES)
    for column in COLUMN_TYPES:
        assert table.column(column).to_pylist() == told(rows, column)
    assert types.is_boolean(table.schema.field("success").type)
    assert types.is_int64(table.schema.field("seed").type)
    long = parquet.read_table(histories)
    assert long.column("cost").to_pylist() == [c for history in rows.histories() for c in history.cost.tolist()]
    assert long.num_rows == sum(len(history.cost) for history in rows.histories())


def test_other_suffixes_and_folders_that_are_not_there_are_refused(rows, tmp_path, refuses):
    for name in ("out.xlsx", "nowhere/out.csv"):
        with refuses():
            rows.export(tmp_path / name)
    assert sorted(path.suffix for path in tmp_path.iterdir() if "sqlite" not in path.name) == []


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_exporting_needs_no_more_memory_for_more_rows(tmp_path, suffix):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow", reason="needs skyverse[parquet]")
    row = plan_job(job(Instant(length=500)))
    peaks = []
    with Rows(tmp_path / "rows.sqlite") as rows:
        tracemalloc.start()
        try:
            for seed in range(100):
                rows.add(type(row)(**{**vars(row), "seed": seed}), str(seed))
                if seed in (19, 99):
                    tracemalloc.reset_peak()
                    before = tracemalloc.get_traced_memory()[0]
                    rows.export(tmp_path / f"{seed}{suffix}")
                    peaks.append(tracemalloc.get_traced_memory()[1] - before)
        finally:
            tracemalloc.stop()
    assert peaks[1] < peaks[0] + 500_000  # the 80 rows more hold 40,000 lines of histories
