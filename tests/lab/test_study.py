"""Studies, from files and flags."""

from pathlib import Path

import pytest

import skyverse as sky
from skyverse.lab import COLUMN_TYPES, Study, read_study, study_from_data, write_study
from skyverse.live import POLICIES

FILE = """\
name: Two maps
scenarios: [map1, {label: mine, file: maps/mine.yaml}]
planners:
- mvo
- {planner: mvo, as_run: true, label: mvo as run}
- {planner: random-restart, threshold: 50}
- astar
seeds: 3
budget: [{paths: 100}, {seconds: 0.5}]
assignment: identity
"""


@pytest.fixture
def study_file(tmp_path):
    (tmp_path / "maps").mkdir()
    sky.write(sky.read("table-4.9-2"), tmp_path / "maps/mine.yaml")
    path = tmp_path / "study.yaml"
    path.write_text(FILE)
    return path


def test_a_study_file_says_which_runs_there_are(study_file):
    jobs = list(read_study(study_file).jobs())
    assert len(jobs) == 2 * 4 * 2 * 3
    assert [str(job) for job in jobs[:4]] == [
        "map1, mvo, 100 paths, seed 0",
        "map1, mvo, 100 paths, seed 1",
        "map1, mvo, 100 paths, seed 2",
        "map1, mvo, 0.5 seconds, seed 0",
    ]
    labels = list(dict.fromkeys(job.label for job in jobs))
    assert labels == [
        "mvo",
        "mvo as run",
        "random-restart threshold=50",
        "astar",
    ]
    assert jobs[6].planner == sky.MVO(as_run=True)
    assert (jobs[0].stop, jobs[3].stop) == (sky.MaxPaths(100), sky.MaxSeconds(0.5))
    assert jobs[-1].case.scenario == sky.read("table-4.9-2")
    assert jobs[-1].case.assignment == "identity"


def test_scenarios_are_found_from_the_study_file_wherever_one_stands(study_file, tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    study = read_study("../study.yaml")
    write_study(study, tmp_path / "elsewhere/study.yaml")
    assert "../maps/mine.yaml" in (tmp_path / "elsewhere/study.yaml").read_text()
    monkeypatch.chdir(tmp_path)
    again = read_study("elsewhere/study.yaml")
    assert [job.key for job in again.jobs()] == [job.key for job in read_study(study_file).jobs()]
    assert again.seen_from(tmp_path) == read_study(study_file).seen_from(tmp_path)


def test_the_shortest_study_has_thirty_seeds_and_a_thousand_paths():
    study = Study(scenarios=["map1"], planners=["mvo"])
    jobs = list(study.jobs())
    assert [job.seed for job in jobs] == list(range(30))
    assert {job.budget for job in jobs} == {"1000 paths"}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"scenarios": []}, "scenarios"),
        ({"planners": ["mvoo"]}, "planners[0]: there is no planner 'mvoo'"),
        ({"planners": [{"planner": "mvo", "univers": 3}]}, "planners[0]: MVO has no setting 'univers'"),
        ({"planners": [{"planner": "mvo", "universes": 0}]}, "planners[0]: MVO's universes is a whole number"),
        ({"planners": [{"label": "mvo"}]}, "planners[0].planner: is missing"),
        ({"planners": ["mvo", {"planner": "astar", "label": "mvo"}]}, "labels of planners must differ, but 'mvo'"),
        ({"scenarios": ["map1", "map1"]}, "labels of scenarios must differ, but 'map1'"),
        ({"seeds": 0}, "seeds: expected how many, from 1 on, or a list of seeds, found 0"),
        ({"seeds": True}, "seeds"),
        ({"seeds": [1, 1]}, "seeds must differ, but 1 stands 2 times"),
        ({"seeds": [-1]}, "seeds[0]"),
        ({"seeds": []}, "seeds"),
        ({"sedes": 3}, "sedes: there is no such key; did you mean 'seeds'?"),
        ({"budget": {"paths": 1, "nodes": 2}}, "budget: expected one of paths, nodes"),
        ({"budget": [{"paths": 5}, {"path": 5}]}, "budget[1].path: there is no such key"),
        ({"budget": {}}, "budget: expected one of paths, nodes"),
        ({"budget": [{"paths": 5}, {"paths": 5}]}, "budget must differ, but '5 paths'"),
        ({"budget": {"path": 5}}, "budget.path: there is no such key; did you mean 'paths'?"),
        ({"budget": {"paths": 0.5}}, "budget.paths"),
        ({"budget": {"seconds": float("inf")}}, "budget.seconds"),
        ({"budget": 1000}, "budget: "),
        ({"assignment": "best"}, "assignment"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence_with_file_and_field(change, sentence):
    with pytest.raises(sky.InputError) as refused:
        study_from_data("study.yaml", {"scenarios": ["map1"], "planners": ["mvo"]} | change)
    assert str(refused.value).startswith(f"study.yaml: {sentence}")
    assert "\n" not in str(refused.value)


def test_a_scenario_that_is_not_there_or_empty_is_refused(tmp_path):
    room = tmp_path / "room.txt"
    room.write_text("boundary 0 0 0 5 5 3\n")
    for name, sentence in (("nowhere", "no such file"), (str(room), "uavs: there are none")):
        with pytest.raises(sky.InputError, match=sentence):
            list(Study(scenarios=[name], planners=["mvo"]).jobs())


def test_a_key_tells_apart_whatever_changes_the_answer(study_file):
    jobs = list(read_study(study_file).jobs())
    assert len({job.key for job in jobs}) == len(jobs)
    edited = FILE.replace("seeds: 3", "seeds: 4").replace("threshold: 50", "threshold: 51")
    study_file.write_text(edited.replace("label: mvo as run", "label: mvo as run, wep_min: 0.3"))
    mine = study_file.parent / "maps/mine.yaml"
    mine.write_text(mine.read_text().replace("clearance: 0.25", "clearance: 0.2"))
    same = {job.key for job in jobs} & {job.key for job in read_study(study_file).jobs()}
    kept = [job for job in jobs if job.key in same]
    assert {(job.case.label, job.label) for job in kept} == {("map1", "mvo"), ("map1", "astar")}
    assert len(kept) == 2 * 2 * 3


def test_the_documentations_study_file_is_one(tmp_path):
    page = (Path(__file__).parents[2] / "docs/studies.md").read_text(encoding="utf-8")
    (tmp_path / "study.yaml").write_text(page.split("```yaml\n")[1].split("```")[0])
    study = read_study(tmp_path / "study.yaml")
    assert (study.name, len(study.seeds), len(study.planners)) == ("Two maps", 30, 4)
    for field in set(Study.model_fields) - {"format"}:
        assert f"| `{field}` |" in page
    for column in COLUMN_TYPES:
        assert f"`{column}`" in page.split("## Columns")[1]


def test_the_documentations_study_among_movers_is_one(tmp_path):
    page = (Path(__file__).parents[2] / "docs/studies.md").read_text(encoding="utf-8")
    (tmp_path / "study.yaml").write_text("name: Crossing" + page.split("```yaml\nname: Crossing")[1].split("```")[0])
    study = read_study(tmp_path / "study.yaml")
    assert (len(study.seeds), len(study.movers), len(study.policies)) == (20, 2, 8)
    section = page.split("## Replanning among movers")[1].split("\n## ")[0]
    for name in POLICIES:
        assert f"| `{name}` |" in section


def test_nodes_are_not_compared_with_metres():
    study = sky.Study(scenarios="map1", planners=["astar", "taut"])
    with pytest.raises(sky.InputError, match=r"map1: objective.unit: expected 'metres' to compare taut with"):
        list(study.jobs())
    assert len(list(sky.Study(scenarios="map1", planners=["theta-star", "taut"], seeds=1).jobs())) == 2


FLIGHTS = {
    "name": "Crossing",
    "scenarios": ["map1", {"label": "mine", "file": "mine.yaml"}],
    "movers": ["patrols", {"kind": "knots", "count": 4, "speed": 2, "hidden": 1}],
    "policies": [
        "default",
        {"policy": "from-scratch", "planner": "mvo", "settings": {"universes": 9}, "label": "MVO"},
        {"policy": "velocity-obstacles", "proven": False},
        "known-beforehand",
    ],
    "seeds": [3, 5],
    "sensor": {"range": 5, "error": 0.1},
    "longest": 20,
}


def test_a_study_of_flights_is_written_and_read_again(tmp_path):
    sky.write(sky.read("map3"), tmp_path / "mine.yaml")
    study = study_from_data("study.yaml", FLIGHTS, tmp_path)
    write_study(study, tmp_path / "out.yaml")
    again = read_study(tmp_path / "out.yaml")
    assert again.seen_from(tmp_path) == study.seen_from(tmp_path)
    jobs = list(again.jobs())
    assert len({job.key for job in jobs}) == len(jobs) == 2 * 2 * 4 * 2
    assert [job.key for job in study.jobs()] == [job.key for job in jobs]
    assert jobs[0].run == ("map1: 10 patrols at 1 m/s", "default", "20 s of flight", 3)
    assert {job.label for job in jobs} == {"default", "MVO", "velocity-obstacles proven=False", "known-beforehand"}
    assert {job.case.label for job in jobs[16:]} == {"mine: 10 patrols at 1 m/s", "mine: 4 knots at 2 m/s, 1 hidden"}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"policies": ["waits"]}, "policies[0]: there is no policy 'waits'; there are default, known-beforehand"),
        ({"policies": [{"policy": "wait", "paths": 3}]}, "policies[0]: there is no setting 'paths'; Wait has none"),
        ({"policies": [{"policy": "from-scratch", "planner": "mvoo"}]}, "policies[0]: there is no planner 'mvoo'"),
        ({"policies": [{"policy": "from-scratch", "paths": 0}]}, "policies[0]: paths: expected a whole number"),
        ({"policies": ["wait", "wait"]}, "labels of policies must differ, but 'wait' stands 2 times"),
        ({"policies": []}, "policies"),
        ({"movers": ["birds"]}, "movers[0].kind"),
        ({"movers": [{"kind": "knots", "speed": 0}]}, "movers[0].speed"),
        ({"movers": [{"kind": "knots", "cuont": 2}]}, "movers[0].cuont: there is no such key; did you mean 'count'?"),
        ({"sensor": {"range": -1}}, "sensor.range"),
        ({"longest": 0}, "longest"),
        ({"planners": ["mvo"]}, "expected either planners, or policies and movers"),
        ({"budget": {"paths": 10}}, "expected no budget in a study of policies"),
    ],
)
def test_what_is_wrong_with_flights_is_said_in_one_sentence_with_file_and_field(change, sentence):
    data = {"scenarios": ["map1"], "movers": ["patrols"], "policies": ["wait"]} | change
    with pytest.raises(sky.InputError) as refused:
        study_from_data("study.yaml", data)
    assert str(refused.value).startswith(f"study.yaml: {sentence}")
    assert "\n" not in str(refused.value)


def test_more_hidden_obstacles_than_there_are_are_refused():
    study = Study(scenarios=["map1"], movers=[{"hidden": 9}], policies=["wait"])
    with pytest.raises(
        sky.InputError, match=r"map1: obstacles: expected 9 or more, of which so many are hidden, found 8"
    ):
        list(study.jobs())
