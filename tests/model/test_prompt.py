"""What the prompt shows: a few short lines that say what matters, whatever the scenario holds."""

import ast
import re
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

import skyverse
import skyverse as sky
from skyverse.files import BUILTIN_NAMES
from skyverse.model.caution import Caution, stands_out
from skyverse.model.geodesy import told_place
from skyverse.model.short_lines import told_area, told_instant, told_seconds
from skyverse.model.verdict import with_global_places

MAX_LINES, MAX_LINE = 6, 110


def lines(shown):
    """Return the lines of what the prompt shows, none of which is long."""
    found = repr(shown).splitlines()
    assert 1 <= len(found) <= MAX_LINES
    assert max(map(len, found)) <= MAX_LINE
    return found


@dataclass(frozen=True)
class OneWalk(sky.Planner):
    """A planner that draws random numbers, and ends by itself."""

    def plan(self, problem, *, stop=None, rng=None, on_iteration=None):
        found = sky.RandomRestart().plan(problem, stop=sky.MaxIterations(1), rng=rng)
        return replace(found, provenance=replace(found.provenance, stop="None"))


@pytest.fixture(scope="module")
def fleet():
    return sky.plan_mission(sky.read("table-4.9-2"), sky.Taut(), rng=1)


@pytest.mark.parametrize("name", BUILTIN_NAMES)
def test_a_scenario_is_shown_in_a_few_lines(name):
    scenario = sky.read(name)
    found = lines(scenario)
    assert found[0].startswith(f"Scenario {name!r}: {len(scenario.uavs)} UAV")
    assert str(scenario) == repr(scenario)
    assert not any("e+" in line for line in found)


def test_a_name_and_a_description_of_any_length_are_cut():
    scenario = sky.read("map1").model_copy(update={"name": "n" * 999, "description": "many words " * 99})
    assert lines(scenario)[1].endswith("...")


def test_a_mission_says_who_flies_what_is_proven_and_what_it_costs(fleet):
    found = lines(fleet)
    assert found[0] == "Mission 'table-4.9-2': 2 UAVs fly, proven safe at every instant"
    assert found[1].startswith(f"  total cost {fleet.cost:.6g} metres, ")
    assert found[-1] == "  by Taut"
    assert lines(replace(fleet, certificates=(), apart=None))[0].endswith("not judged")
    wrong = sky.Violation(sky.Fault.SPEED, (0,), "Too fast.")
    assert lines(replace(fleet, violations=(wrong,)))[0].endswith("1 thing found wrong")


def test_a_mission_in_which_nobody_flies_is_not_said_to_be_safe(fleet):
    grounded = replace(fleet, trajectories=(None,) * len(fleet.trajectories))
    assert lines(grounded)[0] == "Mission 'table-4.9-2': nobody flies"
    wrong = replace(grounded, violations=(sky.Violation(sky.Fault.SPEED, (0,), "Too fast."),))
    assert lines(wrong)[0] == "Mission 'table-4.9-2': nobody flies, 1 thing found wrong"


def test_a_mission_without_a_way_says_so(fleet):
    lost = replace(fleet, trajectories=(None, *fleet.trajectories[1:]))
    assert lines(lost)[0].startswith("Mission 'table-4.9-2': 1 of 2 UAVs flies")
    assert lines(lost)[1] == "  not complete: 1 UAV with a target but no way to it"


def test_a_seed_is_told_of_planners_that_draw_numbers_alone():
    scenario, stop = sky.read("map2"), sky.MaxIterations(2)
    assert lines(sky.plan_mission(scenario, sky.MVO(), stop=stop, rng=7))[-1] == "  by MVO, seed 7"
    mission = sky.plan_mission(scenario, sky.AStar(), rng=7, stop=stop)
    assert lines(mission)[-1] == "  by AStar"
    assert (mission.provenance.seed, mission.provenance.stop) == (None, "None")


def test_the_seed_of_a_planner_of_ones_own_is_told_though_it_has_no_stop_rule():
    mission = sky.plan_mission(sky.read("map2"), OneWalk(), rng=7)
    assert lines(mission)[-1] == "  by OneWalk, seed 7"


def test_the_prompt_names_metres_where_a_path_of_any_angle_costs_metres():
    problem = sky.Problem(sky.read("map2"), 0, 0)
    metres, nodes = sky.Taut().plan(problem), sky.AStar().plan(problem)
    assert lines(metres)[0].startswith(f"Result: complete, cost {metres.cost:.4g} m, ")
    assert lines(nodes)[0].startswith(f"Result: optimal, cost {nodes.cost:.6g}, ")


def test_the_parts_of_a_mission_are_shown_in_a_few_lines(fleet):
    result, trajectory = fleet.results[0], fleet.trajectories[0]
    assert lines(result)[0].startswith(f"Result: {result.status.value}, cost {result.cost:.4g} m")
    assert lines(trajectory)[0].startswith(f"Trajectory: {trajectory.form}, ")
    assert lines(result.history)[0].startswith("History: no iterations, best cost ")
    problem = sky.Problem(fleet.scenario, 1, 0)
    assert lines(problem)[0].startswith("Problem in scenario 'table-4.9-2': uav-2 from ")
    certificates = sky.certify(fleet.scenario, fleet)
    assert repr(certificates) == "Certificates: 2 of 2 trajectories proven, separation proven"
    assert repr(certificates.apart).startswith("Certificate: proven\n  All 2 UAVs keep")


def test_what_is_not_proven_is_named():
    scenario = sky.read("table-4.9-2")
    mission = sky.plan_mission(scenario, sky.Taut(), rng=1)
    certificates = sky.certify(scenario.model_copy(update={"clearance": 3.0}), mission)
    assert lines(certificates)[0].startswith("Certificates: 0 of 2 trajectories proven")
    assert len(lines(certificates)) > 2


def test_a_result_without_a_path_says_what_to_try():
    scenario = sky.read("map1").model_copy(update={"clearance": 4.9})
    found = lines(sky.AStar().plan(sky.Problem(scenario)))
    assert found[1].strip() == sky.AStar().plan(sky.Problem(scenario)).status.sentence


def test_grids_are_shown_by_their_shape():
    terrain = sky.read("jacksboro").terrain
    assert "heights=array of 148 x 95" in repr(terrain)
    assert len(repr(terrain)) < 200


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (0.0, "0 s"),
        (3.25, "3.25 s"),
        (40.0, "40 s"),
        (48.504, "48.5 s"),
        (113.46, "113.5 s"),
        (2010.4, "2,010 s"),
        (123456.7, "123,457 s"),
        (-0.0, "0 s"),
    ],
)
def test_seconds_are_told_in_digits(seconds, said):
    assert told_seconds(seconds) == said


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (3.254, "at 3.25 s"),
        (0.0, "at 0.00 s"),
        (-2.01, "2.01 s before the mission begins, in the hover at the start"),
    ],
)
def test_an_instant_is_told_without_a_negative_number(seconds, said):
    assert told_instant(seconds) == said


SOURCE = Path(skyverse.__file__).parent
ITS_OWN, SQL = SOURCE / "model/caution.py", {SOURCE / "lab/rows.py"}


@pytest.mark.parametrize(
    ("said", "stands"),
    [
        ("WARNING: homes that are not level", True),
        ("NOT", True),
        ("NOT from uav-3", True),
        ("ONLY on schedule", True),
        ("NOTES of the flight", False),
        ("corners NOT proven", False),
        ("Only on schedule", False),
        ("", False),
    ],
)
def test_what_begins_with_a_caution_stands_out(said, stands):
    assert stands_out(said) is stands


def strings(file):
    """The texts in a file that are no docstrings, those of f-strings in pieces."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    found = (node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in alone)
    return [node.value for node in found if isinstance(node.value, str)]


def test_no_file_writes_a_caution_of_its_own():
    word = re.compile(rf"\b({'|'.join(Caution)})\b")
    assert {file for file in SOURCE.rglob("*.py") if any(map(word.search, strings(file)))} == {ITS_OWN, *SQL}


@pytest.mark.parametrize(
    ("area", "said"),
    [
        (0.0, "0 m²"),
        (430.4, "430 m²"),
        (9_876.0, "9,880 m²"),
        (19_812.0, "1.98 ha"),
        (1_234_567.0, "123 ha"),
        (12_345_678.0, "12.3 km²"),
        (3.2e9, "3,200 km²"),
    ],
)
def test_areas_are_told_in_units_that_fit_and_never_in_powers_of_ten(area, said):
    assert told_area(area) == said


def test_places_are_told_by_latitude_and_longitude_where_there_is_an_origin():
    origin = sky.Origin(latitude=46.81, longitude=9.85, altitude=1500.0)
    (place,) = sky.to_wgs84(origin, [(-87.1, 212.9, 0.0)])
    said = f"{place[0]:.6f}, {place[1]:.6f} (-87.1, 212.9)"
    assert told_place(origin, (-87.1, 212.9)) == said
    assert told_place(None, (-87.1, 212.9, 3.04)) == "(-87.1, 212.9, 3)"
    assert told_place(origin, (float("nan"), 0.0)) == "(nan, 0)"
    frame, fault = sky.Frame(origin=origin), sky.Fault.TRAJECTORY_BOUNDS
    given = sky.Violation(fault, (0,), "uav-1 is out of bounds.", 1.0, (-87.1, 212.9, 3.0))
    bare = sky.Violation(fault, (0,), "uav-1 was not planned.")
    told = with_global_places(frame, [given, bare])
    assert told[0].message == f"uav-1 is out of bounds (at {place[0]:.6f}, {place[1]:.6f})."
    assert told[1] == bare
    assert with_global_places(sky.Frame(), [given]) == [given]
