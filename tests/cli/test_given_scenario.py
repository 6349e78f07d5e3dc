"""Scenarios with bad points are refused before anything is planned, and the message names all of them at once."""

import pytest

import skyverse as sky
from skyverse.cli import main
from skyverse.cli.given_scenario import MAX_NAMED_POINTS, refuse_unsafe


def with_starts(*starts):
    return sky.read("map1").model_copy(
        update={"uavs": tuple(sky.UAV(name=f"u{number}", start=start) for number, start in enumerate(starts))}
    )


def refusal(scenario):
    with pytest.raises(sky.InputError) as refused:
        refuse_unsafe("mine.yaml", scenario)
    return str(refused.value).splitlines()


def test_all_bad_points_are_named_at_once():
    first, *lines = refusal(with_starts((5, 2.2, 1), (5, -4, 1), (5, 99, 1)))
    assert first == "mine.yaml: 2 starts and targets are not safe:"
    assert lines[0].startswith("  uavs[0].start (u0): expected a safe point, found (5, 2.2, 1), which lies inside obst")
    assert "; the roof is at z = 1.5 m there; the nearest free place is (5, 1.75, 1), 0.45 m away" in lines[0]
    assert lines[1].startswith("  uavs[2].start (u2): expected a safe point, found (5, 99, 1), which lies outside")
    assert len(lines) == 2


def test_one_bad_point_is_one_sentence():
    (line,) = refusal(with_starts((5, 2.2, 1)))
    assert line.startswith("mine.yaml: uavs[0].start (u0): expected a safe point")


def test_of_very_many_bad_points_the_first_are_named():
    lines = refusal(with_starts(*[(5, 2.2, 1)] * (MAX_NAMED_POINTS + 3)))
    assert len(lines) == MAX_NAMED_POINTS + 2
    assert lines[-1] == "  ... and 3 more"


def test_a_scenario_whose_points_are_all_safe_is_not_refused():
    refuse_unsafe("map1", sky.read("map1"))


def test_show_draws_a_scenario_before_it_is_planned(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sky.write(with_starts((5, 2.2, 1)), tmp_path / "mine.yaml")
    for words, page in ((["mine.yaml"], "mine.html"), (["table-4.8"], "out/table-4.8-scenario.html")):
        with pytest.raises(SystemExit) as ended:
            main(["show", *words])
        assert not ended.value.code
        assert capsys.readouterr().out == f"{page}\n"
        assert (tmp_path / page).read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    with pytest.raises(SystemExit):
        main(["show", "mine.yaml", "--figures", "figures"])
    assert capsys.readouterr().out == "figures/scenario.png\n"
