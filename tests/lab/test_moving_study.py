"""Studies among movers, as files and as objects."""

import pytest

import skyverse as sky
from skyverse.lab.moving_study import MovingStudy, moving_study_from_data, read_moving_study, write_moving_study

FILE = {
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


def test_a_study_is_written_and_read_again(tmp_path):
    sky.write(sky.read("map3"), tmp_path / "mine.yaml")
    study = moving_study_from_data("study.yaml", FILE, tmp_path)
    write_moving_study(study, tmp_path / "out.yaml")
    again = read_moving_study(tmp_path / "out.yaml")
    assert again.seen_from(tmp_path) == study.seen_from(tmp_path)
    jobs = list(again.jobs())
    assert len({job.key for job in jobs}) == len(jobs) == 2 * 2 * 4 * 2
    assert [job.key for job in study.jobs()] == [job.key for job in jobs]
    assert jobs[0].run == ("map1", "10 patrols at 1 m/s", "default", 3)
    assert {job.label for job in jobs} == {"default", "MVO", "velocity-obstacles proven=False", "known-beforehand"}
    assert {job.case.movers_label for job in jobs} == {"10 patrols at 1 m/s", "4 knots at 2 m/s, 1 hidden"}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"policies": ["waits"]}, "policies[0]: there is no policy 'waits'; there are default, known-beforehand"),
        ({"policies": [{"policy": "wait", "paths": 3}]}, "policies[0]: there is no setting 'paths'; Wait has none"),
        ({"policies": [{"policy": "from-scratch", "planner": "mvoo"}]}, "policies[0]: there is no planner 'mvoo'"),
        ({"policies": [{"policy": "from-scratch", "paths": 0}]}, "policies[0]: paths is a whole number"),
        ({"policies": ["wait", "wait"]}, "labels of policies must differ, but 'wait' stands 2 times"),
        ({"policies": []}, "policies"),
        ({"movers": ["birds"]}, "movers[0].kind"),
        ({"movers": [{"kind": "knots", "speed": 0}]}, "movers[0].speed"),
        ({"movers": [{"kind": "knots", "cuont": 2}]}, "movers[0].cuont: there is no such key; did you mean 'count'?"),
        ({"sensor": {"range": -1}}, "sensor.range"),
        ({"longest": 0}, "longest"),
        ({"planners": ["mvo"]}, "planners: there is no such key"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence_with_file_and_field(change, sentence):
    data = {"scenarios": ["map1"], "movers": ["patrols"], "policies": ["wait"]} | change
    with pytest.raises(sky.InputError) as refused:
        moving_study_from_data("study.yaml", data)
    assert str(refused.value).startswith(f"study.yaml: {sentence}")
    assert "\n" not in str(refused.value)


def test_more_hidden_obstacles_than_there_are_are_refused():
    study = MovingStudy(scenarios=["map1"], movers=[{"hidden": 9}], policies=["wait"])
    with pytest.raises(
        sky.InputError, match=r"map1: obstacles: expected 9 or more, of which so many are hidden, found 8"
    ):
        list(study.jobs())
