"""Studies, from files and flags."""

from pathlib import Path

import pytest

import skyverse as sky
from skyverse.lab import COLUMN_TYPES, Study, plan_job, problems_of, read_study, study_from_data, write_study
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


WRONG = {
    "scenarios": [[], ["map1", "map1"]],
    "planners": [
        *(["mvoo"], [{"planner": "mvo", "univers": 3}], [{"planner": "mvo", "universes": 0}], [{"label": "mvo"}]),
        ["mvo", {"planner": "astar", "label": "mvo"}],
    ],
    "seeds": [0, True, [1, 1], [-1], []],
    "sedes": [3],
    "budget": [
        *({"paths": 1, "nodes": 2}, [{"paths": 5}, {"path": 5}], {}, [{"paths": 5}, {"paths": 5}], {"path": 5}),
        *({"paths": 0.5}, {"seconds": float("inf")}, 1000),
    ],
    "assignment": ["best"],
}


@pytest.mark.parametrize("key", WRONG)
def test_what_is_wrong_is_said_in_one_sentence_with_file_and_field(key, refuses):
    for value in WRONG[key]:
        with refuses() as refused:
            study_from_data("study.yaml", {"scenarios": ["map1"], "planners": ["mvo"]} | {key: value})
        assert str(refused.value).startswith("study.yaml: ")
        assert "\n" not in str(refused.value)


def test_a_scenario_that_is_not_there_or_empty_is_refused(tmp_path, refuses):
    room = tmp_path / "room.txt"
    room.write_text("boundary 0 0 0 5 5 3\n")
    for name in ("nowhere", str(room)):
        with refuses():
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


def test_nodes_are_not_compared_with_metres(refuses):
    study = sky.Study(scenarios="map1", planners=["astar", "taut"])
    with refuses():
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


USUAL = {"scenarios": ["map1"], "movers": ["patrols"], "policies": ["wait"]}
WRONG_FLIGHTS = {
    "policies": [
        *(["waits"], [{"policy": "wait", "paths": 3}], [{"policy": "from-scratch", "planner": "mvoo"}]),
        *([{"policy": "from-scratch", "paths": 0}], ["wait", "wait"], []),
    ],
    "movers": [["birds"], [{"kind": "knots", "speed": 0}], [{"kind": "knots", "cuont": 2}]],
    "sensor": [{"range": -1}],
    "longest": [0],
    "planners": [["mvo"]],
    "budget": [{"paths": 10}],
}


@pytest.mark.parametrize("key", WRONG_FLIGHTS)
def test_what_is_wrong_with_flights_is_said_in_one_sentence_with_file_and_field(key, refuses):
    for value in WRONG_FLIGHTS[key]:
        with refuses() as refused:
            study_from_data("study.yaml", USUAL | {key: value})
        assert str(refused.value).startswith("study.yaml: ")
        assert "\n" not in str(refused.value)


def test_more_hidden_obstacles_than_there_are_are_refused(refuses):
    study = Study(scenarios=["map1"], movers=[{"hidden": 9}], policies=["wait"])
    with refuses():
        list(study.jobs())


def tours(tmp_path, **changes):
    """Return the file of a scenario of the thesis's smallest fleet with more targets, and other changes."""
    fleet = sky.read("table-4.9-2")
    more = (*fleet.targets, fleet.targets[0].model_copy(update={"name": "third"}))
    sky.write(fleet.model_copy(update={"targets": more, **changes}), tmp_path / "more.yaml")
    return str(tmp_path / "more.yaml")


@pytest.mark.parametrize("kind", ["planners", "policies"])
def test_scenarios_of_tours_are_refused(kind, tmp_path, refuses):
    uavs = tuple(uav.model_copy(update={"end": "home"}) for uav in sky.read("table-4.9-2").uavs)
    some = {"planners": ["astar"]} if kind == "planners" else {"policies": ["wait"], "movers": ["spinners"]}
    with refuses():
        list(Study(scenarios=[tours(tmp_path, uavs=uavs)], **some).jobs())


def test_planners_have_one_target_each_where_there_are_more(tmp_path):
    (job,) = Study(scenarios=[tours(tmp_path)], planners=["astar"], seeds=1).jobs()
    alone = plan_job(next(Study(scenarios=["table-4.9-2"], planners=["astar"], seeds=1).jobs()))
    assert len(problems_of(job.case)) == 2
    assert plan_job(job).cost <= alone.cost


def test_flights_among_movers_have_no_more_targets_than_uavs_unless_each_has_one(tmp_path, refuses):
    study = {"scenarios": [tours(tmp_path)], "policies": ["wait"], "movers": ["spinners"], "seeds": 1}
    with refuses():
        list(Study(**study).jobs())
    (job,) = Study(**study, assignment="euclidean").jobs()
    assert sky.plan_mission(job.case.scenario, assignment=job.case.assignment).sorties == ()
