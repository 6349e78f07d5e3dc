"""The report of flights among movers, and its judgement, on rows made by hand whose truth is known."""

import numpy as np
import pytest

from skyverse.lab import Row, Rows, SectionHeading, Table, comparison_report, write_report
from skyverse.model.result import no_history

KEPT = "KeptPopulation(planner='mvo', settings={}, paths=200, sweep=1.0)"
RESTARTED = "FromScratch(planner='mvo', settings={}, paths=200, sweep=1.0)"


def row(policy, seed, ratio, settings, *, contacts=0, scenario="hall: patrols"):
    arrived = bool(np.isfinite(ratio))
    success = arrived and not contacts
    return Row(
        scenario, policy, "60 s of flight", seed, status="arrived" if arrived else "not arrived", success=success,
        cost=10.0 * ratio if success else np.inf, fuel=None, divergence=None, end=None, bound=10.0,
        gap=ratio - 1.0 if success else None, generated_paths=100, generated_nodes=0, evaluations=0, iterations=0,
        seconds=0.1, stopped_by="", verdict="too near" if contacts else "", settings=settings, versions="none",
        history=no_history(), flown_seconds=10.0 * ratio if arrived else 60.0, flown_length=20.0, least_length=18.0,
        contacts=contacts, least_gap=-0.1 if contacts else 0.2, replans=50, unproven=1, milliseconds=2.0,
        milliseconds_99=5.0, milliseconds_worst=9.0,
    )  # fmt: skip


@pytest.fixture
def rows(tmp_path):
    with Rows(tmp_path / "rows.sqlite") as rows:
        yield rows


def add(rows, label, settings, ratios, **others):
    for seed, ratio in enumerate(ratios):
        rows.add(row(label, seed, ratio, settings, **others), f"{label} {seed} {others}")


def table(rows, column):
    """Return the first table with such a column, as columns."""
    found = next(b for b in comparison_report(rows).blocks if isinstance(b, Table) and column in b.head)
    return dict(zip(found.head, zip(*found.rows, strict=True), strict=True))


@pytest.mark.parametrize(("change", "verdict"), [(-0.2, "helps"), (0.2, "harms"), (0.0, "no difference")])
def test_a_planted_difference_is_found_and_none_where_there_is_none(rows, change, verdict):
    rng = np.random.default_rng(4)
    restarted = rng.uniform(1.5, 2.0, 20)
    add(rows, "kept", KEPT, restarted + change + rng.normal(0, 0.01, 20))
    add(rows, "restarted", RESTARTED, restarted)
    judged = table(rows, "kept")
    assert judged["verdict"] == (verdict,)
    assert judged["mean difference of time over bound"][0] == pytest.approx(change, abs=0.01)
    interval = judged["95 %"][0].numbers
    assert interval["from"] <= judged["mean difference of time over bound"][0] <= interval["to"]


def test_opposite_differences_are_told_as_such(rows):
    rng = np.random.default_rng(4)
    for scenario, change in (("hall", -0.2), ("forest", 0.2)):
        ratios = rng.uniform(1.5, 2.0, 20)
        add(rows, "kept", KEPT, ratios + change, scenario=scenario)
        add(rows, "restarted", RESTARTED, ratios, scenario=scenario)
    assert table(rows, "kept")["verdict"] == ("scenarios disagree",)


def test_flights_that_fail_count_as_endless_in_tests(rows):
    add(rows, "kept", KEPT, np.full(12, 1.4))
    add(rows, "restarted", RESTARTED, np.full(12, 1.5))
    add(rows, "rash", "Rash()", np.full(12, 1.1), contacts=1)
    pairs = table(rows, "against")
    assert set(zip(pairs["planner"], pairs["against"], strict=True)) == {
        ("kept", "restarted"), ("kept", "rash"), ("restarted", "rash")
    }  # fmt: skip
    assert [chance.numbers["A12"] for chance in pairs["A12"]] == [1.0, 1.0, 1.0]
    flights = table(rows, "contacts")
    assert (flights["contacts"], flights["safe"]) == ((0, 0, 12), ("12 of 12", "12 of 12", "0 of 12"))


def test_a_study_without_a_pair_makes_no_judgement(rows, tmp_path):
    add(rows, "alone", "Alone()", [np.inf])
    headings = [block.text for block in comparison_report(rows).blocks if isinstance(block, SectionHeading)]
    assert headings == ["Effort", "Costs", "hall: patrols", "Differences", "How to read this", "Settings"]
    written = write_report(rows, tmp_path, title="One flight")
    assert {path.name for path in written} >= {"report.md", "report.html", "costs.svg"}
