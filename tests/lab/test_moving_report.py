"""The report of a study among movers, and its judgement, on rows made by hand whose truth is known."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.lab.moving_report import moving_report, write_moving_report
from skyverse.lab.moving_row import MovingRow, MovingRows
from skyverse.lab.report import Table, Text

KEPT = "KeptPopulation(planner='mvo', settings={}, paths=200, sweep=1.0)"
RESTARTED = "FromScratch(planner='mvo', settings={}, paths=200, sweep=1.0)"


def row(policy, seed, ratio, settings, *, contacts=0, scenario="hall"):
    arrived = bool(np.isfinite(ratio))
    return MovingRow(
        scenario, "patrols", policy, seed, arrived=arrived, safe=not contacts, contacts=contacts,
        least_gap=-0.1 if contacts else 0.2, seconds=10.0 * ratio if arrived else 60.0, seconds_bound=10.0,
        time_ratio=ratio, length=20.0, length_bound=18.0, length_ratio=20 / 18 if arrived else np.inf, replans=50,
        unproven=1, milliseconds=2.0, milliseconds_99=5.0, milliseconds_worst=9.0, generated_paths=100,
        generated_nodes=0, evaluations=0, verdict="too near" if contacts else "", settings=settings, versions="none",
    )  # fmt: skip


def rows_of(path, kept, restarted):
    rows = MovingRows(path / "rows.sqlite")
    for label, settings, ratios in (("kept", KEPT, kept), ("restarted", RESTARTED, restarted)):
        for seed, ratio in enumerate(ratios):
            rows.add(row(label, seed, ratio, settings), f"{label} {seed}")
    return rows


def said(report):
    return "\n".join(block.markdown for block in report.blocks if isinstance(block, Text))


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        (-0.2, "**It helps**: kept takes less time"),
        (0.2, "**It harms**: kept takes more time"),
        (0.0, "**No difference"),
    ],
)
def test_a_planted_difference_is_found_and_none_where_there_is_none(tmp_path, change, verdict):
    rng = np.random.default_rng(4)
    restarted = rng.uniform(1.5, 2.0, 20)
    with rows_of(tmp_path, restarted + change + rng.normal(0, 0.01, 20), restarted) as rows:
        report = moving_report(rows)
    assert verdict in said(report)
    (judged,) = [block for block in report.blocks if isinstance(block, Table) and block.head[0] == "kept"]
    if change:
        assert f"{change:+.2f}"[:4] in str(judged.rows[0][judged.head.index("95 %")])


def test_opposite_differences_are_told_as_such(tmp_path):
    rng = np.random.default_rng(4)
    with MovingRows(tmp_path / "rows.sqlite") as rows:
        for scenario, change in (("hall", -0.2), ("forest", 0.2)):
            for seed, ratio in enumerate(rng.uniform(1.5, 2.0, 20)):
                rows.add(row("kept", seed, ratio + change, KEPT, scenario=scenario), f"kept {scenario} {seed}")
                rows.add(row("restarted", seed, ratio, RESTARTED, scenario=scenario), f"restarted {scenario} {seed}")
        report = moving_report(rows)
    assert "**Scenarios disagree**: kept is faster in some" in said(report)
    (matrix,) = [block for block in report.blocks if isinstance(block, Table) and block.head[0] == "faster than"]
    assert "scenarios disagree" in matrix.rows[0][2].text


def test_flights_that_fail_count_as_endless_in_tests(tmp_path):
    restarted = np.full(12, 1.5)
    with rows_of(tmp_path, np.full(12, 1.4), restarted) as rows:
        for seed in range(12):
            rows.add(row("rash", seed, 1.1, "Rash()", contacts=1), f"rash {seed}")
        report = moving_report(rows)
    (matrix,) = [block for block in report.blocks if isinstance(block, Table) and block.head[0] == "faster than"]
    rash = dict(zip(matrix.head, matrix.rows[2], strict=True))
    assert rash["kept"].text.startswith("0.00")
    table = next(block for block in report.blocks if isinstance(block, Table) and "contacts" in block.head)
    assert [line[table.head.index("contacts")] for line in table.rows] == [0, 0, 12]


def test_a_study_without_a_pair_says_that_it_does_not_tell(tmp_path):
    with MovingRows(tmp_path / "rows.sqlite") as rows:
        rows.add(row("alone", 0, np.inf, "Alone()"), "0")
        assert "this study does not tell" in said(moving_report(rows))
        written = write_moving_report(rows, tmp_path, title="One flight")
    assert {path.name for path in written} >= {"report.md", "report.html", "times-1.svg"}
    assert "| alone" in (tmp_path / "report.md").read_text(encoding="utf-8")


def test_no_flights_are_no_report(tmp_path):
    with MovingRows(tmp_path / "rows.sqlite") as rows, pytest.raises(sky.InputError, match="expected finished flights"):
        moving_report(rows)
