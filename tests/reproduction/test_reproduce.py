"""The reproduction of the thesis: all parts, the same bytes from the same seed, verdicts either way."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky
from skyverse.lab import Rows, Table, Text, plan_job, run_jobs, sample
from skyverse.reproduction import cells, claims, judges, published, reproduce, work_claims
from skyverse.reproduction.cells import FORMS, Cell, CellRuns, jobs_of
from skyverse.reproduction.claim_verdict import ClaimVerdict

TABLES = Path(__file__).resolve().parents[3] / "shared" / "thesis" / "tables.json"


def test_every_table_and_figure_is_a_part():
    wanted = {f"table-4.{k}" for k in (2, 3, 4, 5, 6, 7, 10)} | {f"fig-4.{k}" for k in range(1, 32)}
    assert wanted | {"cells", "acceptance", "claims"} == set(reproduce.THESIS_PARTS)


def test_a_part_that_does_not_exist_is_refused_with_the_list_of_those_that_do(refuses):
    with refuses():
        reproduce.named(["table-4.2", "table-9"])


def test_one_run_a_cell_is_too_few(tmp_path, refuses):
    with refuses():
        reproduce.reproduce(["table-4.2"], tmp_path, runs=1)


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


def made(*wanted):
    """Return a file of rows with the runs of cells, each with its seeds."""
    rows = Rows(":memory:")
    for job in jobs_of(wanted):
        rows.add(plan_job(job), job.key)
    return rows


def test_the_exact_optima_are_known():
    found = CellRuns(Rows(":memory:"), range(2))
    assert [found.optimum(name) for name in published.THESIS_MAPS] == [265, 229, 267]
    assert [found.optimum("table-4.8", how) for how in ("identity", "euclidean", "path-cost")] == [732, 540, 538]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("method", ["GSO", "BBO"])
def test_a_shorter_run_of_a_method_without_schedule_is_read_off_a_longer_one(method, form):
    long, problem = Cell("map2", method, form, 25, cells.LAST_ITERATION), sky.Problem(sky.read("map2"))
    with made((long, range(3))) as rows:
        found = CellRuns(rows, range(3)).values("cost", long._replace(length=7))
    planner = long.make_planner()
    assert found.tolist() == [planner.plan(problem, stop=sky.MaxIterations(7), rng=seed).cost for seed in range(3)]


def test_what_another_part_has_left_half_done_is_not_taken_for_a_cell():
    cell = Cell("map1", "GSO", "as run", 25, 40)
    with made((cell, range(1)), (cell._replace(length=cells.LAST_ITERATION), range(3))) as rows:
        found = CellRuns(rows, range(3))
        assert len(found.values("cost", cell)) == 3
        assert len(found.first(2).values("cost", cell)) == 2
        with pytest.raises(ValueError, match="expected 3 runs of GSO as run, 25, found 1"):
            found.values("seconds", cell)


def test_the_baseline_at_any_effort_is_read_off_one_long_run():
    problem = sky.Problem(sky.read("map3"))
    with made((cells.restart("map3"), range(2))) as rows:
        found = CellRuns(rows, range(2)).restart("map3", 600)
    for seed, cost in enumerate(found):
        history = sky.RandomRestart(samples=1).plan(problem, stop=sky.MaxPaths(600), rng=seed).history
        assert cost >= history.cost[-1]
        assert cost in history.cost


def test_seeds_that_were_not_asked_for_do_not_count():
    cell = Cell("map1", "BBO", "as run", 20, 2)
    with made((cell, range(6))) as rows:
        few = CellRuns(rows, range(2, 5)).values("cost", cell)
        assert few.tolist() == CellRuns(rows, range(6)).values("cost", cell)[2:5].tolist()


def test_no_run_is_asked_for_twice():
    wanted = [job.run for job in reproduce.jobs(reproduce.named([]), range(2))]
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
    reproduce.reproduce(wanted, alone, runs=2, seed=3, workers=1)
    reproduce.reproduce(wanted, shared, runs=2, seed=3, workers=2)
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
    reproduce.reproduce(wanted, alone, runs=2, seed=3)  # nothing is run again
    assert pages(alone) == pages(shared)


def test_other_seeds_give_other_numbers(tmp_path):
    reproduce.reproduce(["table-4.2"], tmp_path / "a", runs=2, seed=0)
    reproduce.reproduce(["table-4.2"], tmp_path / "b", runs=2, seed=50)
    assert pages(tmp_path / "a")["report.md"] != pages(tmp_path / "b")["report.md"]


def test_claims_on_time_are_judged_by_milliseconds_of_runs_of_their_own(monkeypatch):
    monkeypatch.setattr(work_claims, "TIMED_RUNS", 2)
    half = (4, claims.CLAIMS[3].text, claims.CLAIMS[3].judge)
    blocks = work_claims.timed_blocks([half], cells.grid(published.THESIS_MAPS, judges.EQUAL), [3, 4, 5])
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

    def values(self, column, cell):
        means = self.means if isinstance(cell.length, int) else self.at_equal
        return self.rng.normal(means[cell.method], self.deviation, self.runs)


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
    found = judges.order((("MVO", "GSO"), ("GSO", "BBO")), ["map1"])(Fake(means, equal), "as run")
    assert found.verdict is verdict
    assert found.comparisons[0].where == "Map 1, 20 x 25"


def claim_on(words):
    (claim,) = (claim for claim in claims.CLAIMS if words in claim.text)
    return claim


@pytest.mark.parametrize(
    ("mvo", "gso", "verdict"),
    [(100, 100.5, ClaimVerdict.HOLDS), (100, 110, ClaimVerdict.FAILS), (100, 102.2, ClaimVerdict.OPEN)],
)
def test_alike_means_within_two_per_cent(mvo, gso, verdict):
    fake = Fake({"MVO": mvo, "GSO": gso}, deviation=2.0)
    assert claim_on("almost alike").judge(fake, "as run").verdict is verdict


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
    assert claim_on("half of GSO's time").judge(fake, "as run").verdict is verdict


def test_the_page_of_claims_judges_each_in_both_forms():
    texts = [claim.text for claim in claims.CLAIMS]
    assert len(set(texts)) == len(texts) >= 20
    assert {re.sub(r"[ ,].*", "", claim.where) for claim in claims.CLAIMS} >= {"abstract", "4.1.1.1", "4.1.3", "4.2"}


DOCS = Path(__file__).resolve().parents[2] / "docs" / "reproduction"


def documented_runs():
    """How many runs each cell has in the documentation, by the command that its page names."""
    return int(re.search(r"`skyverse reproduce --runs (\d+) --seed 0", (DOCS / "report.md").read_text("utf-8"))[1])


def test_other_sets_of_seeds_are_run_only_where_claims_are_judged(tmp_path):
    reproduce.reproduce(["fig-4.1"], tmp_path, runs=2, sets=3)
    assert [file.name for file in tmp_path.glob("*.sqlite")] == ["rows.sqlite"]


@pytest.mark.skipif(not DOCS.exists(), reason="the documentation is not here")
def test_a_sample_of_the_pages_in_the_documentation_is_what_the_code_makes(tmp_path):
    reproduce.reproduce(["fig-4.1", "fig-4.27", "fig-4.28"], tmp_path, runs=documented_runs(), seed=0)
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
    few, all_seeds, bbo = range(20), range(documented_runs()), Cell("map1", "BBO", "as run", 20, 25)
    fleets = [Cell("table-4.8", "MVO", "as described", 25, 40, how) for how in ("identity", "euclidean")]
    with Rows(":memory:") as rows:
        run_jobs(jobs_of([(bbo, all_seeds), *((fleet, few) for fleet in fleets)]), rows)
        cost = CellRuns(rows, all_seeds).values("cost", bbo)
        found = judges.munkres_lowers("MVO")(CellRuns(rows, few), "as described")
    row = next(line for line in report.splitlines() if line.startswith("| BBO, 20 x 25"))
    assert str(sample(cost)) in row
    section = judged.split("## Claim 20\n")[1].split("\n## ")[0].split("*As described*")[1]
    assert found.verdict.value in section
    assert all(value in section for value in found.comparisons[0].record().values())


def test_the_verdicts_of_other_sets_of_seeds_are_counted():
    fake = Fake({"MVO": 270, "GSO": 280, "BBO": 290})
    claim = claims.Claim("MVO is best.", "4", judges.order((("MVO", "GSO"),), ["map1"]))
    other = [[[ClaimVerdict.HOLDS, ClaimVerdict.FAILS]], [[ClaimVerdict.HOLDS, ClaimVerdict.HOLDS]]]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(claims, "CLAIMS", (claim,))
        blocks = claims.page(fake, other)
    table = next(block for block in blocks if isinstance(block, Table))
    assert table.rows == [["1", "MVO is best.", "4", "cost", "holds", "3 of 3", "holds", "2 of 3"]]
    assert any(isinstance(block, Text) and "0.5 of the 2 verdicts change" in block.markdown for block in blocks)
