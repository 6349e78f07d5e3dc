"""``skyverse compare`` as a user meets it."""

import json
import shutil
import sys
from pathlib import Path

import pytest

import skyverse as sky
from skyverse import cli
from skyverse.lab import Rows, WorkerError
from studies import Liar


@pytest.fixture
def compare(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)

    def run(*words, report=False):
        with pytest.raises(SystemExit) as stopped:
            cli.main(
                ["compare", *(str(word) for word in words), "--workers", "1", *([] if report else ["--no-report"])]
            )
        said = capsys.readouterr()
        return stopped.value.code or 0, said.out, said.err

    return run


@pytest.fixture
def study():
    def write(name="study.yaml", **changes):
        data = {"scenarios": ["map1"], "planners": ["mvo", "astar"], "seeds": 2, "budget": {"paths": 50}} | changes
        Path(name).write_text(json.dumps(data))
        return name

    return write


def complaint(said):
    code, out, err = said
    assert code == 2, said
    assert out == ""
    assert err.startswith("skyverse: ")
    assert err.count("\n") == 1
    return err.removeprefix("skyverse: ").strip()


def test_options_make_a_study_and_the_summary_puts_success_first(compare):
    words = ("map1", "table-4.9-2", "--planner", "mvo", "--planner", "astar", "--runs", 3, "--seed", 5, "--paths", 40)
    code, out, err = compare(*words, "--set", "mvo.universes=5")
    assert code == 0, err
    assert out.splitlines()[0] == "40 paths for each UAV"
    head = out.splitlines()[1].split()
    assert head.index("success") < head.index("median") < head.index("mean") < head.index("gap")
    assert "The referee found nothing wrong." in out
    with Rows("out/compare/rows.sqlite") as rows:
        assert len(rows) == 12
        assert rows.labels("scenario") == ["map1", "table-4.9-2"]
        assert rows.labels("planner") == ["mvo universes=5", "astar"]
        assert sorted(set(rows.select(("seed",))["seed"])) == [5, 6, 7]
        assert rows.select(("cost",), planner="astar")["cost"].tolist() == [265] * 3 + [238] * 3
    code, out, err = compare(*words, "--set", "mvo.universes=5")
    assert code == 0
    assert "12 of 12 runs were done before" in err


def test_a_study_file_and_its_copy_in_the_folder_are_the_same_study(compare, study):
    assert compare(study("peers.yaml"))[0] == 0
    code, _, err = compare("out/peers/study.yaml", "-o", "out/peers")
    assert (code, "4 of 4 runs were done before" in err) == (0, True)


def test_policies_are_compared_by_the_same_verb(compare):
    policies = ["wait", "known-beforehand"]
    data = {"scenarios": ["map2"], "movers": {"kind": "patrols", "count": 1, "speed": 0.2}, "policies": policies}
    Path("crossing.yaml").write_text(json.dumps(data | {"seeds": 1, "longest": 30}))
    code, out, err = compare("crossing.yaml", report=True)
    assert code == 0, err
    assert "The referee found nothing wrong." in out
    assert Path("out/crossing/report.html").is_file()
    code, out, err = compare("crossing.yaml", "--json", "--export", "flights.csv")
    assert "2 of 2 runs were done before" in err
    summary = json.loads(out)["summary"]
    assert [(line["planner"], line["success"], line["contacts"]) for line in summary] == [(p, 1, 0) for p in policies]
    assert len(Path("flights.csv").read_text().splitlines()) == 3


def test_the_summary_as_json_is_that_of_the_rows(compare, study):
    code, out, _ = compare(study(), "--json")
    said = json.loads(out)
    assert code == 0
    mvo, astar = said["summary"]
    assert (astar["planner"], astar["success"], astar["mean"], astar["gap"]) == ("astar", 1, 265, 0)
    assert astar["standard_error"] == 0
    with Rows("out/study/rows.sqlite") as rows:
        assert mvo["mean"] == pytest.approx(rows.select(("cost",), planner="mvo")["cost"].mean())
    assert said["violations"] == []


def test_a_report_is_written_unless_told_not_to(compare, study):
    code, out, _ = compare(study(), report=True)
    assert code == 0
    assert str(Path("out/study/report.html")) in out.splitlines()
    assert "<html" in Path("out/study/report.html").read_text(encoding="utf-8")
    assert compare(study(name="other.yaml"))[0] == 0
    assert sorted(path.name for path in Path("out/other").iterdir()) == ["rows.sqlite", "study.yaml"]


def test_rows_are_exported(compare, study):
    code, out, _ = compare(study(), "--export", "rows.csv")
    assert code == 0
    assert out.splitlines()[-2:] == ["rows.csv", "rows-history.csv"]
    assert len(Path("rows.csv").read_text().splitlines()) == 5


def test_a_folder_holds_one_study(compare, study):
    assert compare(study(), "-o", "here")[0] == 0
    said = complaint(compare(study(seeds=3), "-o", "here"))
    assert said.startswith("here: expected the same study as before or a new folder")
    sky.write(sky.read("map1"), "mine.yaml")
    assert compare(study(scenarios=["mine.yaml"]), "-o", "there")[0] == 0
    sky.write(sky.read("map1").model_copy(update={"clearance": 0.2}), "mine.yaml")
    said = complaint(compare(study(scenarios=["mine.yaml"]), "-o", "there"))
    assert said.startswith("there/rows.sqlite: expected rows of this study only, found 4 of others")
    shutil.rmtree("there")
    assert compare(study(scenarios=["mine.yaml"]), "-o", "there")[0] == 0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("map1", "study.yaml"), "study.yaml: expected one study file or scenarios, found both"),
        (("study.yaml", "--paths", 5), "--paths: expected a study file or options, found both"),
        (("study.yaml", "--seed", 0), "--seed: expected a study file or options, found both"),
        (("map1", "--paths", 5, "--iterations", 5), "--paths --iterations: expected one budget"),
        (("map1", "--set", "gso.x=5"), "--set: gso.x: expected a planner that is compared, found 'gso'"),
        (("map1", "--set", "univers=5"), "compare: planners[0]: MVO has no setting 'univers'"),
        (("map1", "--planner", "mvoo"), 'Invalid value "mvoo" for --planner. Choose from:'),
        (("map9",), "map9: no such file, nor a built-in scenario"),
        (("map1", "--runs", 0), "--runs: expected a whole number from 1 on"),
        (("map1", "--seconds", -1), "compare: budget.seconds: expected a number above 0"),
        (("map1", "--export", "rows.xlsx"), "rows.xlsx: rows are exported as .csv or .parquet"),
        (("map1", "-o", "study.yaml"), "study.yaml: expected a folder, found a file"),
        (("wall.yaml",), "wall: targets[0].position (target-1): expected a safe point"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_claims_no_folder(compare, study, words, sentence):
    study()
    walled = sky.read("map1").model_copy(update={"targets": (sky.Target(name="target-1", position=(5, 2.2, 1)),)})
    sky.write(walled, "wall.yaml")
    assert sentence in complaint(compare(*words))
    assert not Path("out").exists()


def test_what_the_referee_finds_wrong_ends_with_1(compare, study, monkeypatch):
    monkeypatch.setattr("skyverse.lab.study_parts.make_planner", lambda name: Liar())
    code, out, _ = compare(study(planners=["liar"]))
    assert code == 1
    assert "map1, liar, 50 paths, seed 0: uav-1: it states fuel" in out
    assert "nothing wrong" not in out


def test_a_run_that_cannot_be_done_ends_with_1_and_keeps_the_others(compare, study, monkeypatch):
    def die(jobs, *_, **__):
        raise WorkerError("the run x ended its process twice")

    monkeypatch.setattr("skyverse.lab.run_jobs", die)
    code, out, err = compare(study())
    assert (code, out) == (1, "")
    assert err.startswith("skyverse: the run x ended its process twice; 0 of 0 runs are kept in out")


def test_without_dask_and_without_a_scheduler_one_sentence_says_so(compare, study, monkeypatch, says):
    monkeypatch.setitem(sys.modules, "distributed", None)
    says(complaint(compare(study(), "--dask", "tcp://127.0.0.1:1")))


def test_rows_of_another_study_do_not_enter_the_report(compare, study):
    assert compare(study(), "-o", "one")[0] == 0
    Path("two").mkdir()
    shutil.copy("one/rows.sqlite", "two/rows.sqlite")
    said = complaint(compare(study(scenarios=["map2"]), "-o", "two"))
    assert said.startswith("two/rows.sqlite: expected rows of this study only")


def test_a_damaged_database_is_told_in_one_sentence(compare, study):
    assert compare(study(), "-o", "one")[0] == 0
    with Path("one/rows.sqlite").open("r+b") as file:
        file.seek(4096)
        file.write(b"\xff" * 8192)
    said = complaint(compare(study(), "-o", "one"))
    assert said.startswith("one/rows.sqlite: expected a database of rows")


@pytest.mark.parametrize("address", ["banana", "tcp://", "host:port"])
def test_an_address_that_is_none_is_refused_at_once(compare, study, address):
    pytest.importorskip("distributed")
    assert "expected a scheduler's address" in complaint(compare(study(), "--dask", address))


def test_so_many_runs_are_refused(compare):
    assert "--runs: expected at most 1,000,000" in complaint(compare("map1", "--runs", "1000000000"))
