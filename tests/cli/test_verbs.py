"""The command line as a user meets it."""

import contextlib
import csv
import json
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky
from patience import PATIENCE_S, wait_until

VERBS = ("scenarios", "plan", "check", "show", "export", "compare", "reproduce")


@pytest.fixture(scope="module")
def mission_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mission") / "map1.json"
    sky.write(sky.plan_mission(sky.read_scenario("map1"), sky.AStar()), path)
    return path


def test_help_shows_every_verb_and_each_verb_an_example(skyverse):
    code, out, _ = skyverse("--help")
    assert code == 0
    assert all(verb in out for verb in VERBS)
    for verb in VERBS:
        code, out, _ = skyverse(verb, "--help")
        assert code == 0
        assert f"skyverse {verb}" in out.split("Examples" if "Examples" in out else "Example")[1]


def test_the_bare_program_says_what_to_try_first_and_each_of_it_works(skyverse):
    code, out, err = skyverse()
    assert (code, err) == (0, "")
    steps = [line.split()[1:] for line in out.splitlines() if line.startswith("  skyverse ")]
    assert [words[0] for words in steps] == ["plan", "show", "scenarios"]
    plan, show, scenarios = steps
    assert skyverse(*plan, "--planner", "astar")[0] == 0
    assert skyverse(*show[:-1])[0] == 0
    assert Path("out/table-4.8.html").is_file()
    assert skyverse(*scenarios)[0] == 0
    assert sky.read("mine.yaml") == sky.read("map1")


def test_help_imports_neither_numba_nor_scipy():
    code = "import sys\nfrom skyverse.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
    code += "assert not {'numba', 'scipy', 'numpy', 'plotly', 'matplotlib'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)


def test_scenarios_lists_the_built_in_ones_and_prints_each_as_a_file_that_reads_back(skyverse, tmp_path):
    code, out, _ = skyverse("scenarios", "--json")
    names = [row["name"] for row in json.loads(out)]
    assert code == 0
    assert names[:4] == ["map1", "map2", "map3", "table-4.8"]
    assert all(name in skyverse("scenarios")[1] for name in names)
    (tmp_path / "copy.yaml").write_text(skyverse("scenarios", "table-4.8")[1])
    assert sky.read("copy.yaml") == sky.read("table-4.8")
    assert skyverse("scenarios", "map2", "-o", "copy.json")[0] == 0
    assert sky.read("copy.json") == sky.read("map2")


def test_scenarios_prints_a_map_of_voxels_without_its_voxels_and_writes_them_all(skyverse, tmp_path):
    occupied = np.zeros((60, 60, 60), dtype=bool)
    occupied[10:20, 5:50, 30] = True
    bounds = sky.Bounds(min=(0, 0, 0), max=(6, 6, 6))
    lattice = sky.Lattice(step=(0.5, 0.5, 0.5))
    voxels = sky.Voxels(origin=(0, 0, 0), step=(0.1, 0.1, 0.1), occupied=occupied)
    given = sky.Scenario(name="office", bounds=bounds, clearance=0.001, lattice=lattice, obstacles=(voxels,))
    sky.write(given, tmp_path / "office.yaml")
    code, out, err = skyverse("scenarios", "office.yaml")
    assert code == 0
    assert len(out) < 2000
    assert "shape: [60, 60, 60]\n    occupied: 450\n" in out
    assert err == "one array is too large to be printed; -o FILE writes the whole scenario\n"
    assert skyverse("scenarios", "office.yaml", "-o", "copy.yaml")[0] == 0
    assert sky.read("copy.yaml") == given


def test_scenarios_prints_the_schema(skyverse):
    code, out, _ = skyverse("scenarios", "--schema")
    assert code == 0
    assert json.loads(out) == sky.scenario_schema()


def test_plan_writes_a_mission_and_a_page_and_says_where(skyverse, tmp_path):
    code, out, err = skyverse("plan", "map2", "--planner", "mvo", "--iterations", 3, "--seed", 5)
    assert code == 0
    assert err == "" or "compiling" in err
    assert out.splitlines()[-2:] == [str(Path("out/map2.json")), str(Path("out/map2.html"))]
    mission = sky.read("out/map2.json")
    assert mission.complete
    assert mission.provenance.seed == 5
    assert sky.check(mission.scenario, mission) == []
    assert "<html" in (tmp_path / "out/map2.html").read_text(encoding="utf-8")
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["map2.html", "map2.json"]


def test_plan_speaks_json(skyverse):
    code, out, _ = skyverse("plan", "table-4.9-2", "--planner", "astar", "--json", "--no-page", "-o", "m.json")
    said = json.loads(out)
    assert code == 0
    assert said["cost"] == 238
    assert [row["gap"] for row in said["uavs"]] == [0, 0]
    assert said["page"] is None


@pytest.mark.parametrize(("assignment", "cost"), [("identity", 732), ("euclidean", 540), ("path-cost", 538)])
def test_plan_assigns_as_told(skyverse, assignment, cost):
    words = ("plan", "table-4.8", "--planner", "astar", "--assignment", assignment)
    words += ("--json", "--no-page", "--no-keep-apart")
    assert json.loads(skyverse(*words)[1])["cost"] == cost


def test_plan_takes_a_course_map_with_a_uav_and_a_target(skyverse, tmp_path):
    (tmp_path / "room.txt").write_text("block 2 0 0 3 3 2 255 0 0\nboundary 0 0 0 5 5 3\n")
    code, out, _ = skyverse(
        "plan", "room.txt", "--uav", "1,1,1", "--target", "4,1,1", "--planner", "astar", "--no-page"
    )
    assert code == 0, out
    assert sky.read("out/room.json").scenario.uavs[0].start == (1, 1, 1)


def test_plan_takes_settings_and_negative_coordinates(skyverse):
    words = (
        "--planner",
        "mvo",
        "--set",
        "universes=5",
        "--set",
        "as_run=true",
        "--paths",
        30,
        "--uav",
        "0,-4,2",
        "--target",
        "1,17,3",
    )
    code, out, _ = skyverse("plan", "map1", *words, "--json", "--no-page")
    said = json.loads(out)
    assert code in (0, 1)
    assert "universes=5, as_run=True" in said["provenance"]["planner"]
    assert [uav["target"] for uav in said["uavs"]] == ["target-1"]


def test_plan_without_a_planner_says_which_one_it_chose_and_that_it_follows_no_budget(skyverse):
    code, out, err = skyverse("plan", "map1", "--iterations", 9, "--no-page")
    assert code == 0
    assert "\nplanned by AStar\ntotal cost 265 nodes, " in out
    assert err.endswith(
        "AStar ends by itself; without effect: --iterations (mvo and other metaheuristics follow a budget).\n"
    )
    said = json.loads(skyverse("plan", "map1", "--planner", "auto", "--no-page", "--json")[1])
    assert said["provenance"]["planner"].startswith("AStar(), ")


def test_plan_ends_with_1_where_a_target_cannot_be_reached(skyverse, tmp_path):
    (tmp_path / "shut.txt").write_text("boundary 0 0 0 5 5 3\nblock 2 0 0 3 5 3\n")
    code, out, _ = skyverse("plan", "shut.txt", "--uav", "1,1,1", "--target", "4,1,1")
    assert code == 1
    assert "no path" in out
    assert "uav-1 would have a way to target-1 without the obstacle obstacles[0]" in out
    code, out, err = skyverse("check", "out/shut.json")
    assert (code, err) == (1, "The mission is not complete: uav-1 has no way.\n")


def test_a_planner_that_seeks_length_alone_says_so_where_more_is_priced(skyverse):
    band = {"low": 1.0, "high": 2.0, "weight": 1.0}
    scenario = sky.read("map1")
    priced = sky.Scenario.model_validate({**scenario.model_dump(), "objective": {"unit": "metres", "altitude": band}})
    sky.write(priced, "band.json")
    _, _, err = skyverse("plan", "band.json", "--planner", "taut", "--shape", "stop-and-go", "--no-page")
    assert (
        "Taut seeks length alone; priced, but not sought: altitude (cheapest, astar and hybrid-mvo seek them)." in err
    )


def test_check_ends_with_0_on_a_good_mission_and_with_1_on_a_bad_one(skyverse, mission_file, tmp_path):
    code, out, err = skyverse("check", mission_file)
    assert (code, err) == (0, "")
    assert out.startswith("The referee found nothing wrong.\nJudged by scenario ")
    assert "as the mission embeds it; --scenario tells its source.\n" in out
    data = json.loads(mission_file.read_text())
    data["results"][0]["path"][20][0] += 0.05
    (tmp_path / "bad.json").write_text(json.dumps(data))
    code, out, _ = skyverse("check", "bad.json")
    assert code == 1
    assert "path off the lattice: uav-1" in out
    code, out, _ = skyverse("check", "bad.json", "--json")
    assert code == 1
    assert json.loads(out)[0]["fault"] == "path off the lattice"
    code, out, _ = skyverse("check", mission_file, "--scenario", "map3")
    assert code == 1


def test_check_names_what_was_altered_in_the_scenario_of_a_mission(skyverse, tmp_path):
    skyverse("plan", "map1", "--planner", "taut", "--no-page", "-o", "flown.json")
    code, out, _ = skyverse("check", "flown.json", "--scenario", "map1")
    assert code == 0
    assert ", from map1.\n" in out
    data = json.loads((tmp_path / "flown.json").read_text())
    data["scenario"]["clearance"] = 0.01
    (tmp_path / "altered.json").write_text(json.dumps(data))
    code, out, _ = skyverse("check", "altered.json", "--scenario", "map1")
    assert code == 1
    assert "clearance is 0.01 in the mission, not 0.25" in out
    code, out, _ = skyverse("check", "altered.json")
    assert code == 0
    assert "as the mission embeds it; --scenario tells its source.\n" in out


def test_show_draws_the_referees_verdict_and_not_the_files(skyverse, tmp_path):
    skyverse("plan", "map1", "--planner", "taut", "--no-page", "-o", "flown.json")
    data = json.loads((tmp_path / "flown.json").read_text())
    data["trajectories"][0]["coefficients"][0][0][2] += 1.0
    (tmp_path / "forged.json").write_text(json.dumps(data))
    assert skyverse("show", "forged.json")[0] == 0
    page = (tmp_path / "forged.html").read_text()
    assert "The referee found nothing wrong" not in page
    assert "jumps by 1 m" in page


def test_the_help_of_plan_says_which_planner_is_the_default(skyverse):
    code, out, _ = skyverse("plan", "--help")
    words = " ".join(out.replace("\N{BOX DRAWINGS LIGHT VERTICAL}", " ").split())
    assert code == 0
    assert "auto, which chooses by what the scenario prices: astar, exact on the lattice, where nodes" in words
    assert "taut where length is all" in words
    assert "cheapest where turns, altitude, risk or climb are priced" in words


def test_show_writes_the_page_or_the_figures(skyverse, mission_file, tmp_path):
    made = "Made the folder p, which did not exist.\n"
    assert skyverse("show", mission_file, "-o", "p/page.html") == (0, f"{Path('p/page.html')}\n", made)
    assert skyverse("show", mission_file, "-o", "p/page.html") == (0, f"{Path('p/page.html')}\n", "")
    code, out, _ = skyverse("show", mission_file, "--figures", "figures")
    assert code == 0
    assert len(out.split()) == len(list((tmp_path / "figures").iterdir())) >= 5


def test_export_writes_waypoints_and_trajectories(skyverse, mission_file, tmp_path):
    assert skyverse("export", mission_file, "m.waypoints.csv")[0] == 0
    assert skyverse("export", mission_file, "m.csv", "--rate", 10)[0] == 0
    with (tmp_path / "m.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[1]["t"]) == pytest.approx(0.1)
    with (tmp_path / "m.waypoints.csv").open() as file:
        assert next(csv.DictReader(file))["uav"] == "uav-1"


def test_export_tells_that_waypoints_are_not_sampled(skyverse, mission_file):
    told = "Without effect on waypoints: --rate"
    for asked, said in (((), False), (("--rate", 5), True)):
        code, _, err = skyverse("export", mission_file, "m.plan", "--origin", "46.8,9.85,1500 m amsl", *asked)
        assert (code, told in err) == (0, said)


BAD_INPUT = """
plann
plan
show
export m.json
plan map1 --seed
plan nowhere
plan map1 --planner mvp
plan map1 --planner mvo --set universe=5
plan map1 --set universes
plan map1 --planner mvo --set universes=few
plan map1 --planner mvo --set as_run=maybe
plan map1 --iterations 0
plan map1 --iterations many
plan map1 --iterations 1.5
plan map1 --seconds -1 --paths 9
plan map1 --seconds -1
plan map1 --seconds nan --paths 9
plan map1 --seconds 5
plan map1 --seed -1
plan map1 --assignment best
plan map1 --max-speed nan
plan map1 --max-speed -1
plan map1 --tracking-error -1,2
plan map1 --max-height '-5 m agl'
fly MISSION --wind 1
fly MISSION --wind -1,0,zero
fly MISSION --mismatch -5%
fly MISSION --mismatch much
fly MISSION --mismatch 90%
fly MISSION --wind north
fly MISSION --wind-speed 8
fly MISSION --wind-speed 8 --wind-from 270 --wind 1,0,0
fly MISSION --wind-speed -8 --wind-from 270
fly MISSION --wind-speed 8 --wind-from nan
fly MISSION --gusts --runs 2
fly MISSION --runs 2 --margin 0.1
fly MISSION --noise -1
fly MISSION --position-noise -1
fly MISSION --rounds 3
fly MISSION --vehicle balloon
fly MISSION --animation a.avi
fly MISSION -o a.csv
plan map1 --uav 1,2
plan map1 --uav 1,2,nan
plan map1 --uav 5,2.2,1
plan map1 --target 5,99,1
check map1
check missing.json
export MISSION m.kml
export MISSION m.foo
export MISSION m.csv --rate 0
export MISSION m.csv --rate 1e10
export MISSION /dev/null/m.csv
show MISSION -o m.pdf
scenarios map9
scenarios -o mine.yaml
scenarios map1 --schema
scenarios map1 -o map1.xml
plan map1 --set universes=5
"""


@pytest.mark.parametrize("words", BAD_INPUT.strip().splitlines())
def test_bad_input_gets_one_sentence_and_exit_code_2(refused, mission_file, tmp_path, words):
    refused(*(mission_file if word == "MISSION" else word for word in shlex.split(words)))
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


@pytest.mark.parametrize("text", ["name: x\nbounds: {min: [0, 0, 0], max: [1, 1, 1]}\ncleerance: 1\n", "name: [", ""])
def test_a_bad_file_is_named_with_its_field(refused, tmp_path, text):
    (tmp_path / "mine.yaml").write_text(text)
    refused("plan", "mine.yaml")


def test_output_that_cannot_be_kept_is_refused_before_the_run(refused, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.json").mkdir()
    monkeypatch.setattr(sky, "plan_mission", lambda *_, **__: pytest.fail("planned for nothing"))
    (tmp_path / "page.html").mkdir()
    for name in ("file/m.json", "folder.json", "page.json", "m.yaml"):
        refused("plan", "map1", "-o", name)


def test_what_is_read_is_never_replaced(refused, tmp_path):
    sky.write(sky.read_scenario("map2"), "map.json")
    square = [[8.5, 47.3], [8.51, 47.3], [8.51, 47.31], [8.5, 47.3]]
    shape = {"type": "Polygon", "coordinates": [square]}
    shape = {"type": "Feature", "properties": {"height": "9 m"}, "geometry": shape}
    (tmp_path / "town.json").write_text(json.dumps({"type": "FeatureCollection", "features": [shape]}))
    before = {name: (tmp_path / name).read_bytes() for name in ("map.json", "town.json")}
    build = ("scenario", "build", "--ground", "0 m amsl", "--buildings", "town.json", "-o", "./town.json")
    copied = ("scenarios", "map.json", "-o", "map.json")
    flown = ("fly", "map.json", "-o", "map.json")
    for words in (("plan", "map.json", "-o", str(tmp_path / "map.json")), build, copied, flown):
        refused(*words)
    assert {name: (tmp_path / name).read_bytes() for name in before} == before


@pytest.mark.parametrize("name", ["../../up", "/tmp/abs", "..", "a\nb", "x" * 300, "<b>", "übung 1"])
def test_a_mission_is_named_after_its_scenarios_file_whatever_the_scenarios_own_name_is(skyverse, tmp_path, name):
    sky.write(sky.read_scenario("map2").model_copy(update={"name": name}), "my yard.json")
    code, out, _ = skyverse("plan", "my yard.json", "--no-page")
    assert code == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["my_yard.json"]
    assert out.splitlines()[-1] == str(Path("out/my_yard.json"))
    assert sky.read_mission("out/my_yard.json").scenario.name == name


def test_no_mission_replaces_that_of_another_scenario(skyverse, tmp_path):
    for folder, world in (("north", "map1"), ("south", "map2")):
        (tmp_path / folder).mkdir()
        sky.write(sky.read_scenario(world).model_copy(update={"name": "room"}), f"{folder}/room.yaml")
    assert skyverse("plan", "north/room.yaml", "--no-page")[1].splitlines()[-1] == str(Path("out/room.json"))
    first = (tmp_path / "out/room.json").read_bytes()
    second = str(Path("out/room-2.json"))
    for _ in range(2):  # planned anew, it replaces itself
        code, out, err = skyverse("plan", "south/room.yaml", "--no-page")
        assert (code, out.splitlines()[-1]) == (0, second)
        assert f"out/room.json is of another scenario and stays as it is; this mission is {second}." in err
    assert (tmp_path / "out/room.json").read_bytes() == first
    assert sky.read_mission(second).scenario == sky.read_scenario("south/room.yaml")
    (tmp_path / "out/room-2.json").write_text("{}")  # no mission at all
    assert skyverse("plan", "south/room.yaml", "--no-page")[1].splitlines()[-1] == str(Path("out/room-3.json"))
    assert (tmp_path / "out/room-2.json").read_text() == "{}"
    _, out, err = skyverse("plan", "north/room.yaml", "--no-page")
    assert out.splitlines()[-1] == str(Path("out/room.json"))
    assert "another scenario" not in err


def test_a_changed_scenario_replaces_its_own_mission(skyverse, tmp_path):
    first = sky.read_scenario("map1")
    sky.write(first, "mine.yaml")
    for clearance in (0.25, 0.3):
        sky.write(first.model_copy(update={"clearance": clearance}), "mine.yaml")
        code, out, err = skyverse("plan", "mine.yaml", "--no-page")
        assert (code, out.splitlines()[-1], err) == (0, str(Path("out/mine.json")), "")
        assert sky.read_mission("out/mine.json").scenario.clearance == clearance
    assert sky.read_mission("out/mine.json").source == "../mine.yaml"
    assert skyverse("plan", str(tmp_path / "mine.yaml"), "--max-speed", 2, "--no-page")[2] == ""
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["mine.json"]


def test_a_mission_that_is_planned_anew_stays_as_it_is(skyverse, tmp_path):
    skyverse("plan", "map1", "--no-page")
    before = (tmp_path / "out/map1.json").read_bytes()
    for _ in range(2):
        code, out, err = skyverse("plan", "out/map1.json", "--no-page")
        assert (code, out.splitlines()[-1]) == (0, str(Path("out/map1-2.json")))
        assert "out/map1.json is what is read and stays as it is; this mission is out/map1-2.json." in err
    assert (tmp_path / "out/map1.json").read_bytes() == before
    assert sky.read_mission("out/map1-2.json").source == "map1.json"


def test_the_page_of_a_built_in_scenario_does_not_replace_that_of_its_mission(skyverse, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/map1.html").write_text("the mission's page")
    assert skyverse("show", "map1") == (0, f"{Path('out/map1-scenario.html')}\n", "")
    assert (tmp_path / "out/map1.html").read_text() == "the mission's page"


def test_a_uav_in_the_place_of_another_keeps_its_name(skyverse):
    given = sky.read_scenario("map1").model_dump()
    given["uavs"][0]["name"] = "uav-2"
    sky.write(sky.Scenario.model_validate(given), "named.json")
    skyverse("plan", "named.json", "--uav", "1,-4,1", "--target", "3,17,3", "--planner", "astar", "--no-page")
    assert [uav.name for uav in sky.read_mission("out/named.json").scenario.uavs] == ["uav-2"]


@pytest.mark.parametrize("verb", ["show", "export", "check"])
@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("coefficients", [1]),
        ("coefficients", None),
        ("knots", [[]]),
        ("knots", [0, float("nan")]),
        ("knots", [0, 10**400]),
        ("history", 0),
    ],
    ids=["few", "none", "empty", "nan", "huge", "history"],
)
def test_a_mission_whose_arrays_do_not_fit_is_refused_by_every_verb(refused, mission_file, verb, field, value):
    data = json.loads(mission_file.read_text())
    if field == "history":
        data["results"][0]["history"]["cost"] = value
    else:
        data["trajectories"][0][field] = value
    Path("broken.json").write_text(json.dumps(data))
    refused(verb, "broken.json", *(["x.csv"] if verb == "export" else []))


@pytest.mark.skipif(os.name == "nt", reason="signals to a process are POSIX here")
def test_ctrl_c_keeps_the_best_mission_so_far_and_marks_it(tmp_path):
    words = ["plan", "table-4.8", "--planner", "mvo", "--iterations", "100000000", "-o", str(tmp_path / "m.json")]
    command = [sys.executable, "-m", "skyverse", *words]
    pty = pytest.importorskip("pty")
    terminal, stderr = pty.openpty()
    err = ""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True) as process:
        os.close(stderr)
        try:
            while not re.search(r"best \d", err):  # the progress bar tells what a path to the target costs
                err += os.read(terminal, 65536).decode()
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(OSError):  # Linux: there is nothing more to read
                while more := os.read(terminal, 65536):
                    err += more.decode()
            out, _ = process.communicate(timeout=PATIENCE_S)
        finally:
            process.kill()
            os.close(terminal)
    assert process.returncode == 130, err
    assert "keeping the best so far" in err
    assert "Interrupted: this is the best so far, not judged yet; skyverse show" in out
    assert "proven" not in out.lower()
    mission = sky.read_mission(tmp_path / "m.json")
    assert mission.interrupted
    assert mission.results[0].status.reached
    assert mission.results[4].status is sky.Status.NOT_PLANNED
    assert {v.fault for v in sky.check(mission.scenario, mission)} <= {sky.Fault.SEPARATION}


@pytest.mark.skipif(os.name == "nt", reason="signals to a process are POSIX here")
def test_ctrl_c_while_kernels_compile_ends_all_processes_with_130_and_says_what_is_kept(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-m", "skyverse", "plan", "map1", "-o", str(tmp_path / "m.json")],
        env={**os.environ, "SKYVERSE_CACHE": str(tmp_path / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            first = process.stderr.readline()
            wait_until(lambda: list((tmp_path / "cache").rglob("*.kernel")), process)  # then processes compile
            os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the processes that compile, too
            _, rest = process.communicate(timeout=PATIENCE_S)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    assert re.fullmatch(r"skyverse: compiling \d+ kernels, once for each version; about \d+ s\n", first)
    assert process.returncode == 130
    assert [line for line in rest.splitlines() if "compiling" not in line] == [
        "skyverse: stopping, and keeping the best so far; Ctrl-C again to end at once",
        "skyverse: interrupted; nothing was planned yet, and nothing is written",
    ]
    assert not (tmp_path / "m.json").exists()


def test_whoever_cannot_keep_kernels_is_told_that_they_compile(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SKYVERSE_CACHE", str(tmp_path / "file" / "cache"))
    run = subprocess.run(
        [sys.executable, "-m", "skyverse", "cache", "--compile"], capture_output=True, text=True, check=True
    )
    told = re.fullmatch(r"skyverse: compiling \d+ kernels, each time, as (.+); .* SKYVERSE_CACHE .*\n", run.stderr)
    assert str(tmp_path / "file" / "cache") in told[1]
    assert f"not used: {told[1]}" in run.stdout
