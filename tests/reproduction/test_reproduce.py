"""The reproduction of the thesis: all parts, the same bytes from the same seed, verdicts either way."""

import json
import re
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import skyverse as sky
from skyverse.errors import InputError
from skyverse.lab import Rows, Table, Text, run_jobs
from skyverse.reproduction import cell_runs as cell_runs_module
from skyverse.reproduction import claims, cost_claims, effort_claims, fleets, published
from skyverse.reproduction.cell_runs import FORMS, CellRuns, all_methods, case, cell, mean, optimum, planner, restarts
from skyverse.reproduction.claim_verdict import ClaimVerdict
from skyverse.reproduction.reproduce import THESIS_PARTS, jobs, named, reproduce

TABLES = Path(__file__).resolve().parents[3] / "shared" / "thesis" / "tables.json"


def test_every_table_and_figure_is_a_part():
    wanted = {f"table-4.{k}" for k in (2, 3, 4, 5, 6, 7, 10)} | {f"fig-4.{k}" for k in range(1, 32)}
    assert wanted | {"cells", "acceptance", "claims"} == set(THESIS_PARTS)


def test_a_part_that_does_not_exist_is_refused_with_the_list_of_those_that_do():
    with pytest.raises(InputError, match=r"no part 'table-9'.*table-4\.2"):
        named(["table-4.2", "table-9"])


def test_one_run_a_cell_is_too_few(tmp_path):
    with pytest.raises(InputError, match="from 2 to 10,000, found 1"):
        reproduce(["table-4.2"], tmp_path, runs=1)


@pytest.mark.skipif(not TABLES.exists(), reason="the thesis's tables as data are not here")
def test_the_published_numbers_are_those_of_the_tables():
    tables = json.loads(TABLES.read_text())
    for number, name in (("4.2", "map1"), ("4.3", "map2"), ("4.4", "map3")):
        for row in tables[number]["rows"]:
            found = published.COSTS[name, row["algorithm"], row["population"], row["iterations"]]
            assert found == (row["mean_best_cost"], row["std_best_cost"], row["time_s"])
    for place, row in enumerate(tables["4.5"]["rows"]):
        assert published.CONVERGENCE_ITERATIONS[place] == row["iterations"]
        for name in published.THESIS_MAPS:
            assert {m: published.CONVERGENCE[name, m][place] for m in published.METHODS} == row[name]
    for number, iterations in (("4.6", 25), ("4.7", 40)):
        for place, row in enumerate(tables[number]["rows"]):
            assert published.POPULATIONS[place] == row["population"]
            for name in published.THESIS_MAPS:
                assert {m: published.TIMES[name, m, iterations][place] for m in published.METHODS} == row[name]
    for place, row in enumerate(tables["4.10"]["rows"]):
        for which in ("case1", "case2"):
            for method in published.METHODS:
                times = published.FLEET_TIMES[method, row[which]["population"], row[which]["iterations"]]
                assert times[place] == row[which][method]


def test_the_exact_optima_are_known():
    assert [optimum(case(name)) for name in published.THESIS_MAPS] == [265, 229, 267]
    assert [optimum(case("table-4.8", how)) for how in ("identity", "euclidean", "path-cost")] == [732, 540, 538]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("method", ["GSO", "BBO"])
def test_a_shorter_run_of_a_method_without_schedule_is_read_off_a_longer_one(tmp_path, method, form):
    given, problem = case("map2"), sky.Problem(sky.read("map2"))
    with Rows(tmp_path / "rows.sqlite") as rows:
        for job in cell(given, method, form, 25, cell_runs_module.LAST_ITERATION, range(3)):
            rows.add(sky_row(job), job.key)
        found = CellRuns(rows, range(3)).values("cost", given, method, form, 25, 7)
    made = planner(method, form, 25)
    assert found.tolist() == [made.plan(problem, stop=sky.MaxIterations(7), rng=seed).cost for seed in range(3)]


def test_what_another_part_has_left_half_done_is_not_taken_for_a_cell(tmp_path):
    given = case("map1")
    with Rows(tmp_path / "rows.sqlite") as rows:
        for iterations, seeds in ((40, range(1)), (cell_runs_module.LAST_ITERATION, range(3))):
            for job in cell(given, "GSO", "as run", 25, iterations, seeds):
                rows.add(sky_row(job), job.key)
        found = CellRuns(rows, range(3))
        assert len(found.values("cost", given, "GSO", "as run", 25, 40)) == 3
        assert len(found.first(2).values("cost", given, "GSO", "as run", 25, 40)) == 2
        with pytest.raises(ValueError, match="expected 3 runs of GSO as run, 25, found 1"):
            found.values("seconds", given, "GSO", "as run", 25, 40)


def sky_row(job):
    from skyverse.lab import plan_job

    return plan_job(job)


def test_the_baseline_at_any_effort_is_read_off_one_long_run(tmp_path):
    given, problem = case("map3"), sky.Problem(sky.read("map3"))
    with Rows(tmp_path / "rows.sqlite") as rows:
        for job in restarts(given, range(2)):
            rows.add(sky_row(job), job.key)
        found = CellRuns(rows, range(2)).restart(given, 600)
    for seed, cost in enumerate(found):
        history = sky.RandomRestart(samples=1).plan(problem, stop=sky.MaxPaths(600), rng=seed).history
        assert cost >= history.cost[-1]
        assert cost in history.cost


def test_seeds_that_were_not_asked_for_do_not_count(tmp_path):
    given = case("map1")
    with Rows(tmp_path / "rows.sqlite") as rows:
        for job in cell(given, "BBO", "as run", 20, 2, range(6)):
            rows.add(sky_row(job), job.key)
        few = CellRuns(rows, range(2, 5)).values("cost", given, "BBO", "as run", 20, 2)
        assert few.tolist() == CellRuns(rows, range(6)).values("cost", given, "BBO", "as run", 20, 2)[2:5].tolist()


def test_no_run_is_asked_for_twice():
    wanted = [job.run for job in jobs(named([]), range(2))]
    assert len(set(wanted)) == len(wanted)


def pages(folder):
    """What a reproduction has written, but for what is measured."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.suffix in (".md", ".html", ".svg") and "times" not in path.name and "seconds" not in path.name
    }


def test_the_same_seed_gives_the_same_pages_byte_by_byte_whatever_the_number_of_workers(tmp_path):
    wanted = ["table-4.2", "fig-4.10", "fig-4.12", "fig-4.5"]
    alone, shared = tmp_path / "alone", tmp_path / "shared"
    reproduce(wanted, alone, runs=2, seed=3, workers=1)
    reproduce(wanted, shared, runs=2, seed=3, workers=2)
    assert pages(alone) == pages(shared)
    assert set(pages(alone)) == {
        "report.md",
        "report.html",
        "figures/fig-4.10.svg",
        "figures/fig-4.12.svg",
        "figures/fig-4.5.svg",
    }
    text = (alone / "report.md").read_text(encoding="utf-8")
    assert "skyverse reproduce table-4.2 fig-4.10 fig-4.12 fig-4.5 --runs 2 --seed 3" in text
    assert "280.4" in text  # the published mean of MVO, 20 x 25
    assert "| 265 " in text or "265 |" in text
    assert "seconds" not in text.lower()
    reproduce(wanted, alone, runs=2, seed=3)  # nothing is run again
    assert pages(alone) == pages(shared)


def test_other_seeds_give_other_numbers(tmp_path):
    reproduce(["table-4.2"], tmp_path / "a", runs=2, seed=0)
    reproduce(["table-4.2"], tmp_path / "b", runs=2, seed=50)
    assert pages(tmp_path / "a")["report.md"] != pages(tmp_path / "b")["report.md"]


def test_claims_on_time_are_judged_by_milliseconds_of_runs_of_their_own(monkeypatch):
    monkeypatch.setattr(effort_claims, "TIMED_RUNS", 2)
    maps = [case(name) for name in published.THESIS_MAPS]
    blocks = effort_claims.timed_blocks(
        [(4, "MVO takes about half of GSO's time.", effort_claims.half_the_time)],
        lambda seeds: all_methods(maps, cost_claims.EQUAL, seeds),
        SimpleNamespace(seeds=[3, 4, 5]),
    )
    judged, measured, *_ = (block for block in blocks if isinstance(block, Table))
    assert [row[0] for row in judged.rows] == ["Claim 4", "Munkres"]
    assert "2 runs of each method" in blocks[1].markdown
    milliseconds = [float(number) for number in re.findall(r"[A-Z]{3} ([\d.]+)", measured.rows[0][1])]
    assert len(milliseconds) == 2
    assert all(0.05 < each < 5000 for each in milliseconds)


class Fake:
    """Cells whose costs are drawn around means of our choice."""

    def __init__(self, means, equal=None, runs=50, deviation=5.0):
        self.means, self.at_equal, self.runs, self.deviation = means, equal or means, runs, deviation
        self.rng, self.work, self.unit = np.random.default_rng(0), "generated_nodes", "nodes"

    def values(self, column, given, method, form, population, length):
        means = self.means if isinstance(length, int) else self.at_equal
        return self.rng.normal(means[method], self.deviation, self.runs)


@pytest.mark.parametrize(
    ("means", "equal", "verdict"),
    [
        ({"MVO": 270, "GSO": 280, "BBO": 290}, None, ClaimVerdict.HOLDS),
        ({"MVO": 270, "GSO": 280, "BBO": 290}, {"MVO": 280, "GSO": 280, "BBO": 290}, ClaimVerdict.UNEQUAL),
        ({"MVO": 280, "GSO": 270, "BBO": 290}, None, ClaimVerdict.FAILS),
        ({"MVO": 280, "GSO": 280, "BBO": 290}, None, ClaimVerdict.OPEN),
    ],
)
def test_an_order_of_methods_gets_the_verdict_that_it_deserves(means, equal, verdict):
    found = cost_claims.order((("MVO", "GSO"), ("GSO", "BBO")), ("map1",), Fake(means, equal), "as run")
    assert found.verdict is verdict
    assert found.comparisons[0].where == "Map 1, 20 x 25"


@pytest.mark.parametrize(
    ("mvo", "gso", "verdict"),
    [(100, 100.5, ClaimVerdict.HOLDS), (100, 110, ClaimVerdict.FAILS), (100, 102.2, ClaimVerdict.OPEN)],
)
def test_alike_means_within_two_per_cent(mvo, gso, verdict):
    fake = Fake({"MVO": mvo, "GSO": gso}, deviation=2.0)
    assert cost_claims.alike_in_the_end(fake, "as run").verdict is verdict


@pytest.mark.parametrize(
    ("mvo", "equal", "verdict"),
    [
        (50, None, ClaimVerdict.HOLDS),
        (50, {"MVO": 100, "GSO": 100}, ClaimVerdict.UNEQUAL),
        (90, None, ClaimVerdict.FAILS),
    ],
)
def test_half_the_time_is_judged_by_nodes(mvo, equal, verdict):
    fake = Fake({"MVO": mvo, "GSO": 100}, equal, deviation=0.5)
    assert effort_claims.half_the_time(fake, "as run").verdict is verdict


def test_the_page_of_claims_judges_each_in_both_forms():
    texts = [claim.text for claim in claims.CLAIMS]
    assert len(set(texts)) == len(texts) >= 20
    assert {re.sub(r"[ ,].*", "", claim.where) for claim in claims.CLAIMS} >= {"abstract", "4.1.1.1", "4.1.3", "4.2"}


DOCS = Path(__file__).resolve().parents[2] / "docs" / "reproduction"


def documented_runs():
    """How many runs each cell has in the documentation, by the command that its page names."""
    return int(re.search(r"`skyverse reproduce --runs (\d+) --seed 0", (DOCS / "report.md").read_text("utf-8"))[1])


def test_other_sets_of_seeds_are_run_only_where_claims_are_judged(tmp_path):
    reproduce(["fig-4.1"], tmp_path, runs=2, sets=3)
    assert [file.name for file in tmp_path.glob("*.sqlite")] == ["rows.sqlite"]


@pytest.mark.skipif(not DOCS.exists(), reason="the documentation is not here")
def test_a_sample_of_the_pages_in_the_documentation_is_what_the_code_makes(tmp_path):
    reproduce(["fig-4.1", "fig-4.27", "fig-4.28"], tmp_path, runs=documented_runs(), seed=0)
    checked_in, made = ((folder / "report.md").read_text(encoding="utf-8") for folder in (DOCS, tmp_path))
    sample = [block for block in made.split("\n\n") if block.startswith(("|", "**Figure"))]
    assert len(sample) == 5
    for block in sample:
        assert block in checked_in
    for name in ("fig-4.1", "fig-4.28"):
        drawing = f"figures/{name}.svg"
        assert (tmp_path / drawing).stat().st_size == pytest.approx((DOCS / drawing).stat().st_size, rel=0.05)


@pytest.mark.skipif(not DOCS.exists(), reason="the documentation is not here")
def test_a_cell_and_a_claim_in_the_documentation_are_what_the_code_finds():
    report, judged = ((DOCS / f"{page}.md").read_text(encoding="utf-8") for page in ("report", "claims"))
    given, few, all_seeds = case("map1"), range(20), range(documented_runs())
    jobs_ = [*cell(given, "BBO", "as run", 20, 25, all_seeds)]
    for how in ("identity", "euclidean"):
        jobs_ += cell(fleets.coordinated(how), "MVO", "as described", 25, 40, few)
    with Rows(":memory:") as rows:
        run_jobs(jobs_, rows)
        cost = CellRuns(rows, all_seeds).values("cost", given, "BBO", "as run", 20, 25)
        found = cost_claims.munkres_lowers(("MVO",), CellRuns(rows, few), "as described")
    row = next(line for line in report.splitlines() if line.startswith("| BBO, 20 x 25"))
    assert str(mean(cost)) in row
    section = judged.split("## Claim 20\n")[1].split("\n## ")[0].split("*As described*")[1]
    assert found.verdict.value in section
    assert all(value in section for value in found.comparisons[0].record().values())


def test_the_verdicts_of_other_sets_of_seeds_are_counted():
    fake = Fake({"MVO": 270, "GSO": 280, "BBO": 290})
    claim = claims.Claim("MVO is best.", "4", partial(cost_claims.order, (("MVO", "GSO"),), ("map1",)))
    other = [[[ClaimVerdict.HOLDS, ClaimVerdict.FAILS]], [[ClaimVerdict.HOLDS, ClaimVerdict.HOLDS]]]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(claims, "CLAIMS", (claim,))
        blocks = claims.page(fake, other)
    table = next(block for block in blocks if isinstance(block, Table))
    assert table.rows == [["1", "MVO is best.", "4", "cost", "holds", "3 of 3", "holds", "2 of 3"]]
    assert any(isinstance(block, Text) and "0.5 of the 2 verdicts change" in block.markdown for block in blocks)
