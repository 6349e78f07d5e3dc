import csv
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from skyverse.lab import (
    Figure,
    Rows,
    SectionHeading,
    Table,
    Text,
    cells,
    comparison_report,
    figures,
    markdown,
    write_report,
)
from skyverse.model.result import no_history
from studies import ROW


def run(scenario="map1", planner="mvo", seed=0, cost=270.0, **other):
    return replace(ROW, scenario=scenario, planner=planner, seed=seed, cost=cost, gap=cost / 265 - 1, **other)


def study(path, runs):
    rows = Rows(path / "rows.db")
    for number, row in enumerate(runs):
        rows.add(row, str(number))
    return rows


def random_runs(scenarios=3, planners=3, seeds=20, step=8.0):
    rng = np.random.default_rng(5)
    for s in range(scenarios):
        for p in range(planners):
            for seed in range(seeds):
                cost = float(266 + 10 * s + step * p + np.floor(rng.exponential(6)))
                yield run(f"map{s}", f"planner {p}", seed, cost)


def text(report):
    return markdown(report)


def tables(report, first):
    return [block for block in report.blocks if isinstance(block, Table) and block.head[0] == first][
        : -1 if first == "planner" else None
    ]  # the last: settings


def draw_all(report):
    for block in report.blocks:
        if isinstance(block, Figure):
            with figures.style():
                ElementTree.fromstring(figures.image(block.draw(), "svg"))


def test_the_numbers_are_those_of_the_rows(tmp_path):
    runs = [*random_runs()]
    with study(tmp_path, runs) as rows:
        report = comparison_report(rows)
    table = cells(next(t for t in tables(report, "planner") if "median" in t.head))[1]
    costs = np.array([r.cost for r in runs if (r.scenario, r.planner) == ("map0", "planner 1")])
    error = costs.std(ddof=1) / np.sqrt(20)
    assert table[:2] == ["planner 1", "20 of 20"]
    assert table[3] == f"{costs.mean():.1f} ± {error:.1f}"
    assert table[5] == f"{np.median(costs):.1f}"
    assert table[6] == f"{100 * (costs / 265 - 1).mean():.1f} %"
    assert table[7:9] == ["1,000", "90,000"]


def test_a_clear_winner_is_named_and_far_planners_are_told_apart(tmp_path):
    with study(tmp_path, random_runs(scenarios=6, step=20.0)) as rows:
        report = comparison_report(rows)
    assert report.blocks[0].markdown.startswith("**Best: planner 0**, over all scenarios")
    assert report.blocks[-2].head == ("planner", "settings")
    assert text(report).count("Made with ") == 1
    assert text(report).count("Lowest mean: planner 0. Significantly different from it: planner 1, planner 2.") == 6
    pairs = cells(tables(report, "planner")[-1])
    assert [row[:2] for row in pairs] == [
        ["planner 0", "planner 1"],
        ["planner 0", "planner 2"],
        ["planner 1", "planner 2"],
    ]
    assert {row[5] for row in pairs} == {"< 0.001"}
    assert "Friedman's test of mean ranks over 6 scenarios" in text(report)
    assert "The planners differ" in text(report)


def test_equal_rows_give_equal_bytes(tmp_path):
    written = []
    for name in "ab":
        (tmp_path / name).mkdir()
        with study(tmp_path / name, random_runs(scenarios=1)) as rows:
            written.append(write_report(rows, tmp_path / name / "out", figures=("svg", "png")))
    assert [path.name for path in written[0]][-2:] == ["report.md", "report.html"]
    for one, other in zip(*written, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_one_run_of_one_planner_is_reported(tmp_path):
    with study(tmp_path, [ROW]) as rows:
        report = comparison_report(rows)
    draw_all(report)
    assert "There are no ranks" in text(report)
    assert cells(tables(report, "planner")[1])[0][:4] == ["mvo", "1 of 1", "21 to 100 %", "270"]


def test_three_runs_are_said_to_be_too_few(tmp_path):
    with study(tmp_path, random_runs(scenarios=1, planners=2, seeds=3)) as rows:
        told = text(comparison_report(rows))
    assert "Too few runs to test whether they differ from it (6 runs of both): planner 1." in told
    assert "nan" not in told


def test_runs_that_all_failed_are_reported_and_drawn(tmp_path):
    lost = [
        run("map1", name, seed, np.inf, success=False, status="no path", bound=None, history=no_history())
        for name in ("a", "b", "c")
        for seed in range(8)
    ]
    lost = [replace(row, gap=None) for row in lost]
    with study(tmp_path, lost) as rows:
        report = comparison_report(rows)
        draw_all(report)
    assert "0 of 8" in text(report)
    assert "nan" not in text(report)
    assert "No planner has a finite mean." in text(report)


def test_equal_costs_are_not_told_apart(tmp_path):
    with study(tmp_path, random_runs(scenarios=2, planners=1)) as rows:
        alike = [replace(row, planner=name) for row in rows for name in ("a", "b", "c", "d")]
    (tmp_path / "alike").mkdir()
    with study(tmp_path / "alike", alike) as rows:
        report = comparison_report(rows)
        draw_all(report)
    rows = [row[2:] for row in cells(tables(report, "planner")[-1])]
    assert rows == [["0.50", "negligible", "0, 0", "1.00", "1.00"]] * 6
    assert "nan" not in text(report)


@pytest.mark.parametrize(
    ("least", "says"), [(265.0, "The exact optimum is 265."), (270.0, "No path costs less than 265.")]
)
def test_a_bound_that_no_run_attains_is_not_called_an_optimum(tmp_path, least, says):
    costs = [least + seed for seed in range(8)]
    runs = [run(planner=p, seed=k, cost=c) for p in "ab" for k, c in enumerate(costs)]
    with study(tmp_path, runs) as rows:
        captions = [table.caption for table in tables(comparison_report(rows), "planner")]
    assert says in captions


def test_unequal_seeds_are_said(tmp_path):
    first = [run(planner="a", seed=seed, cost=270.0 + seed) for seed in range(10)]
    second = [run(planner="b", seed=100 + seed, cost=290.0 + seed) for seed in range(10)]
    third = [run(planner="c", seed=seed, cost=271.0 + seed) for seed in range(7)]
    with study(tmp_path, [*first, *second, *third]) as rows:
        report = comparison_report(rows)
        draw_all(report)
    assert "Not every planner has run everywhere with every seed" in text(report)


def test_opposite_differences_are_told_as_such_and_failures_counted(tmp_path):
    runs = [
        replace(row, cost=row.cost + 30.0 * (row.planner[-1] == "1") * (row.scenario != "map2"))
        for row in random_runs()
    ]
    runs = [replace(row, cost=row.cost - 20.0 * (row.planner[-1] == "1") * (row.scenario == "map2")) for row in runs]
    runs = [replace(row, success=row.seed > 2) if row.planner[-1] == "0" else row for row in runs]
    with study(tmp_path, runs) as rows:
        report = comparison_report(rows)
    (row,) = [row for row in cells(tables(report, "planner")[-1]) if {*row[:2]} == {"planner 0", "planner 1"}]
    assert row[4] in ("9, 0", "0, 9")
    assert row[5] == "scenarios disagree"


@pytest.mark.parametrize("unit", ["iterations", "seconds"])
def test_a_budget_that_is_not_equal_effort_is_said_so(unit, tmp_path):
    runs = [replace(row, budget=f"40 {unit}") for row in random_runs(planners=2)]
    runs = [replace(row, generated_paths=3500) if row.planner == "planner 1" else row for row in runs]
    with study(tmp_path, runs) as rows:
        told = text(comparison_report(rows))
    assert f"> **The budget is in {unit}: this does not compare planners at equal effort.**" in told
    assert "**Not equal in generated paths**: planner 1 had 3.5 times as many as planner 0." in told
    assert "The effort was equal in generated nodes" in told


def test_exact_planners_are_the_reference_and_no_contestants(tmp_path):
    ended = {"generated_paths": 1, "iterations": 0, "stopped_by": "finished", "history": no_history()}
    exact = [run("map0", "astar", seed, 265.0, **ended) for seed in range(20)]
    with study(tmp_path, [*exact, *random_runs(scenarios=1)]) as rows:
        report = comparison_report(rows)
    assert {name for row in cells(tables(report, "planner")[-1]) for name in row[:2]} == {
        f"planner {k}" for k in range(3)
    }
    assert "Lowest mean: planner 0." in text(report)
    assert "The effort was equal in generated paths." in text(report)
    assert "whatever the budget: astar" in text(report)


def test_what_the_referee_found_is_not_hidden(tmp_path):
    with study(tmp_path, [replace(ROW, verdict="Cost 3 is told as 2."), run(seed=1)]) as rows:
        assert "**The referee found fault with 1 run**, first: Cost 3 is told as 2." in text(comparison_report(rows))


def test_budgets_have_sections_of_their_own(tmp_path):
    runs = [replace(row, budget=budget) for budget in ("100 paths", "200 paths") for row in random_runs(2, 3, 6)]
    with study(tmp_path, runs) as rows:
        report = comparison_report(rows)
    headings = [block.text for block in report.blocks if isinstance(block, SectionHeading) and block.level == 2]
    assert headings[:2] == ["Effort, 100 paths", "Costs, 100 paths"]
    assert "Effort, 200 paths" in headings
    names = [block.name for block in report.blocks if isinstance(block, Figure)]
    assert len(names) == len(set(names)) == 12


def test_fourteen_planners_with_names_that_bite_are_written(tmp_path):
    names = [
        "<script>x</script>",
        "a|b",
        "$x$ and $",
        "_y_",
        "名前",
        *(f"{k} a very long label " * 4 for k in range(9)),
    ]
    runs = [replace(row, planner=names[int(row.planner.split()[1])]) for row in random_runs(7, 14, 1)]
    with study(tmp_path, runs) as rows:
        page = write_report(rows, tmp_path / "out")[-1].read_text("utf-8")
    assert "<script" not in page
    assert "&lt;script&gt;x&lt;/script&gt;" in page
    assert sorted(path.name for path in (tmp_path / "out" / "figures").iterdir() if "costs" in path.name) == [
        "costs-a.svg",
        "costs-b.svg",
    ]


def test_the_file_may_be_closed_before_the_figures_are_drawn(tmp_path):
    with study(tmp_path, random_runs(scenarios=1)) as rows:
        report = comparison_report(rows, title="Mine")
    draw_all(report)
    assert report.title == "Mine"
    assert not re.search(r"None|\bnan\b", text(report))
    assert isinstance(report.blocks[-1], Text)


def test_a_planner_without_a_history_has_a_run_length(tmp_path):
    bare = {"history": no_history(), "iterations": 1, "evaluations": 7}
    direct = [run("map0", "direct", seed, cost, **bare) for seed, cost in enumerate((270.0, 290.0, 400.0))]
    with study(tmp_path, [*direct, *random_runs(scenarios=1, planners=1, seeds=3)]) as rows:
        (table,) = [table for table in tables(comparison_report(rows), "scenario") if "10 %" in table.head]
    assert cells(table)[0][1:] == ["direct", "10 (2)", "21 (1)", "21 (1)", "\u221e (0)"]  # 1.9 % above the bound


CLAIMS = {
    "two planners": ("Mann-Whitney", "A12"),
    "several scenarios": ("Stouffer", "Gail"),
    "ranks": ("Friedman",),
    "seeds": ("bootstrapped",),
}


@pytest.mark.parametrize(
    ("sizes", "made"),
    [
        ((1, 1, 1), ()),
        ((1, 1, 8), ("seeds",)),
        ((1, 2, 8), ("two planners", "seeds")),
        ((3, 2, 8), ("two planners", "several scenarios", "seeds")),
        ((3, 3, 8), ("two planners", "several scenarios", "ranks", "seeds")),
    ],
)
def test_methods_claim_no_test_that_was_not_made(tmp_path, sizes, made):
    with study(tmp_path, random_runs(*sizes)) as rows:
        blocks = comparison_report(rows).blocks
    (place,) = [k for k, block in enumerate(blocks) if isinstance(block, SectionHeading) and block.text == "Methods"]
    for needed, names in CLAIMS.items():
        assert {name in blocks[place + 1].markdown for name in names} == {needed in made}


def test_numbers_of_the_tables_are_read_back_from_csv(tmp_path):
    runs = [*random_runs(scenarios=1, planners=2)]
    with study(tmp_path, runs) as rows:
        write_report(rows, tmp_path / "out", formats=("csv",), figures=())
    found = {}
    for path in (tmp_path / "out" / "tables").glob("*.csv"):
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(csv.DictReader(file))
        found |= dict.fromkeys(lines[0], lines)
        for line in lines:
            for name, value in line.items():
                if name not in ("planner", "settings", "scenario", "against", "effect"):
                    float(value or "nan")
    for line in found["standard error"]:
        costs = np.array([r.cost for r in runs if r.planner == line["planner"]])
        assert float(line["mean"]) == pytest.approx(costs.mean(), rel=1e-12)
        assert float(line["standard error"]) == pytest.approx(costs.std(ddof=1) / np.sqrt(len(costs)), rel=1e-12)
        assert (int(line["reached"]), int(line["runs"])) == (20, 20)
    assert 0 < float(found["p (Holm)"][0]["p (Holm)"]) < 0.05


def test_no_runs_are_one_sentence(tmp_path, refuses):
    with Rows(tmp_path / "rows.db") as rows, refuses():
        comparison_report(rows)
