"""What is printed of a mission."""

import dataclasses
import inspect
import json
import re
from collections import Counter
from pathlib import Path

from hypothesis import example, given
from hypothesis import strategies as st
from rich.cells import cell_len

import skyverse as sky
from skyverse.cli.report import json_text, report, table
from skyverse.model.flight_table import (
    flight_columns,
    gaps_sentence,
    planners_sentence,
    told_costs,
    unit_sentence,
    unknown_gaps_sentence,
)
from skyverse.model.verdict import Action, Deconfliction
from terminals import on_a_terminal


def test_a_total_never_adds_nodes_to_metres(capsys):
    scenario = sky.read("table-4.9-2")
    nodes, metres = (sky.plan_mission(scenario, planner, rng=1) for planner in (sky.AStar(), sky.Taut()))
    around = dataclasses.replace(metres.results[1].provenance, planner="Taut, led around others")
    mixed = dataclasses.replace(
        nodes, results=(nodes.results[0], dataclasses.replace(metres.results[1], provenance=around))
    )
    first, second = nodes.results[0].cost, metres.results[1].cost
    report(mixed, [Path("mission.json")], as_json=False)
    assert f"total cost {first:.6g} nodes and {second:.2f} m, total time" in capsys.readouterr().out
    report(mixed, [Path("mission.json")], as_json=True)
    summary = json.loads(capsys.readouterr().out)
    assert summary["cost"] is None
    assert summary["costs"] == {"nodes": first, "metres": second}
    report(nodes, [Path("mission.json")], as_json=False)
    assert f"total cost {nodes.cost:.6g} nodes, total time" in capsys.readouterr().out


def test_names_with_brackets_are_printed_as_they_are(capsys):
    table(["UAV", "cost"], [["[red]", "1"], ["uav [bold]2[/bold]", "2"]])
    assert [line.split("  ")[0] for line in capsys.readouterr().out.splitlines()[1:]] == ["[red]", "uav [bold]2[/bold]"]


def wholes(width):
    """Draw a table whose words, heads and cells no column needs to cut on a terminal of a width."""
    word = st.text("0123456789.%°m²Żη[]/", min_size=1, max_size=width // 2 - 1)
    cell = st.lists(word, max_size=8).map(" ".join)
    row = st.integers(1, 8).flatmap(lambda count: st.lists(st.tuples(*[cell] * count), min_size=1, max_size=3))
    return st.tuples(st.just(width), row)


@given(st.integers(16, 140).flatmap(wholes))
@example(
    (60, [("UAV", "a sentence of many words that a terminal folds", "14.62 m"), ("uav-1", "12 " * 40, "-0.123456 m")])
)
def test_a_terminal_of_any_width_cuts_no_word_of_a_table(drawn):
    width, (head, *rows) = drawn
    with on_a_terminal(width) as terminal:
        table(head, rows)
    lines = re.sub(r"\x1b\[\d+m", "", terminal.sent).splitlines()
    assert max(map(cell_len, lines), default=0) <= width
    words = Counter(" ".join(lines).split())
    assert words >= Counter(word for row in (head, *rows) for cell in row for word in cell.split())


def test_a_table_in_a_pipe_has_a_line_for_each_row(capsys):
    table(["UAV", "why"], [["uav-1", "so " * 300], ["uav-2", "-"]])
    assert len(capsys.readouterr().out.splitlines()) == 3


def test_a_table_has_units_and_no_columns_of_optimisers_unless_asked(capsys):
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.Taut(), rng=1)
    report(mission, [Path("mission.json")], as_json=False)
    out = capsys.readouterr().out
    heads = out.splitlines()[0]
    assert all(head in heads for head in ("gap at most", "flown", "climb", "steepest", "altitude", "time"))
    assert "generated paths" not in out
    assert ", seed" not in out
    assert "-0.0" not in out
    report(mission, [Path("mission.json")], as_json=False, details=True)
    assert "generated paths" in capsys.readouterr().out


def test_large_costs_are_told_without_powers_of_ten():
    assert told_costs({"metres": 46819.7123}) == "46,819.71 m"
    assert told_costs({"metres": 1234567.8}) == "1,234,567.80 m"
    assert told_costs({}) == "-"


def test_costs_in_nodes_are_told_apart_from_costs_in_metres(capsys):
    scenario = sky.read("table-4.9-2")
    nodes, metres = (sky.plan_mission(scenario, planner) for planner in (sky.AStar(), sky.Taut()))
    assert "paths of any angle, as of Taut, leave the lattice and cost metres" in unit_sentence(nodes)
    assert 'its cost is in metres; "flown" compares it' in unit_sentence(metres)
    for mission in (nodes, metres):
        report(mission, [Path("mission.json")], as_json=False)
        assert unit_sentence(mission) in capsys.readouterr().out
    in_metres = scenario.model_copy(update={"objective": scenario.objective.model_copy(update={"unit": "metres"})})
    assert unit_sentence(sky.plan_mission(in_metres, sky.Taut())) == ""


def test_gaps_say_what_they_are_counted_from():
    jacksboro = sky.plan_mission(sky.read("jacksboro"), sky.Taut())
    assert "straight line" in gaps_sentence(jacksboro)
    nodes = sky.plan_mission(sky.read("table-4.9-2"), sky.AStar())
    assert gaps_sentence(nodes) == ""
    worse = dataclasses.replace(nodes.results[0], cost=2 * nodes.results[0].cost)
    assert "same lattice" in gaps_sentence(dataclasses.replace(nodes, results=(worse, nodes.results[1])))


def test_a_wait_before_departure_is_told_beside_the_time():
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.Taut())
    first, second = mission.trajectories
    late = dataclasses.replace(mission, trajectories=(first.retimed(first.start + 0.18), second))
    before, after = ({one.head: one.cells for one in flight_columns(told)}["time"] for told in (mission, late))
    assert after == (f"{before[0]} + 0.18 s wait", before[1])


def test_a_missing_gap_is_explained_in_one_line(capsys):
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.Taut())
    assert unknown_gaps_sentence(mission) == ""
    unbounded = dataclasses.replace(mission.results[0], bound=None)
    mission = dataclasses.replace(mission, results=(unbounded, mission.results[1]))
    report(mission, [Path("mission.json")], as_json=False)
    assert capsys.readouterr().out.count('Where the gap is "-", what the best possible path costs') == 1


def test_paths_led_around_others_by_another_planner_are_counted():
    scenario = sky.read("table-4.9-2")
    nodes, metres = (sky.plan_mission(scenario, planner) for planner in (sky.AStar(), sky.Taut()))
    assert planners_sentence(nodes) == "planned by AStar"
    action = Action(1, "detour", "uav-2 leaves its path.")
    mixed = dataclasses.replace(nodes, results=(nodes.results[0], metres.results[1]))
    assert planners_sentence(dataclasses.replace(mixed, deconfliction=None)) == "planned by AStar and Taut"
    led = dataclasses.replace(mixed, deconfliction=Deconfliction((), (), (action,), 1.0, 1.0, 1.0, 1.0))
    assert planners_sentence(led) == "planned by AStar; 1 path led around others by Taut"


def test_keys_of_json_are_snake_case_for_all_verbs():
    said = {"departs at": 1, "milliseconds 99 %": {"to movers": [{"least gap": None}]}, "$defs": {"a-b": 0}}
    assert json.loads(json_text(said)) == {
        "departs_at": 1, "milliseconds_99": {"to_movers": [{"least_gap": None}]}, "$defs": {"a-b": 0}
    }  # fmt: skip
    verbs = Path(inspect.getfile(json_text)).parent.glob("*.py")
    assert [verb.name for verb in verbs if "json.dumps" in verb.read_text(encoding="utf-8")] == ["report.py"]
