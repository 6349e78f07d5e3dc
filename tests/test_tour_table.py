"""Tables of tours: what they say is what the mission holds, and margins are told on the safe side."""

from dataclasses import replace

import pytest

import skyverse as sky
from rounds import rounds
from skyverse.model.flight_table import flight_columns
from skyverse.referee.energy import energy_bounds, turning_back
from skyverse.tour_table import numbered_sorties, numbered_visits, sortie_columns, told_spare, visit_columns


def cells(columns):
    return {column.head: column.cells for column in columns}


def test_every_visit_is_told_once_in_its_order_with_its_number_through_all_sorties():
    mission = rounds()
    told = list(numbered_visits(mission))
    assert sorted(one.target.name for one in told) == [f"mast-{k}" for k in range(1, 7)]
    for uav, own in enumerate(mission.sorties):
        mine = [one for one in told if one.uav == uav]
        assert [one.number for one in mine] == [*range(1, len(mine) + 1)]
        assert [one.visit for one in mine] == [visit for sortie in own for visit in sortie.visits]
        assert [one.sortie for one in mine] == [k for k, sortie in enumerate(own, 1) for _ in sortie.visits]
    table = cells(visit_columns(mission))
    assert set(table["stays"]) == {"3 s"}
    assert dict(zip(table["target"], table["window"], strict=True))["mast-1"] == "0 s to 1,000 s"
    assert table["window"].count("-") == 5


def test_margins_and_points_of_no_return_are_near_what_the_referee_bounds_and_on_its_safe_side():
    mission = rounds()
    assert len(mission.sorties[1]) > 1  # one battery does not give all
    for one in numbered_sorties(mission):
        flown = mission.scenario, one.uav, mission.trajectories[one.uav], one.sortie.begin, one.sortie.end
        spare = (one.vehicle.usable_energy - energy_bounds(*flown)[1][-1]) / 3600
        assert one.spare == pytest.approx(spare, abs=0.01 * one.vehicle.battery)
        proven = turning_back(*flown)[2]
        assert proven - 3.0 <= one.battery.no_return <= proven + 0.2  # that of turning about is rough
        assert float(told_spare(one).removeprefix("fits by ").removesuffix(" Wh")) <= one.spare


def test_what_a_battery_does_not_give_is_told_as_lacking():
    mission = rounds()
    weak = tuple(uav.model_copy(update={"battery": 0.5}) for uav in mission.scenario.uavs)
    weaker = replace(mission, scenario=mission.scenario.model_copy(update={"uavs": weak}))
    told = cells(sortie_columns(weaker))
    for one, margin in zip(numbered_sorties(weaker), told["margin"], strict=True):
        assert one.spare < 0
        assert float(margin.removeprefix("lacks ").removesuffix(" Wh")) >= -one.spare


def test_flights_count_their_targets_and_a_mission_its_visits():
    mission = rounds()
    assert cells(flight_columns(mission))["target"] == ("2 targets", "4 targets in 2 sorties")
    assert "6 of 7 targets visited in 3 sorties" in repr(mission)
    assert mission.visited == frozenset(range(6))
    assert mission.spare_targets == (6,)


def test_a_mission_without_tours_has_no_visits_and_one_sortie_for_each_flight():
    mission = sky.plan_mission(sky.read("table-4.9-2"), sky.Taut(), rng=1)
    assert list(numbered_visits(mission)) == []
    assert [one.uav for one in numbered_sorties(mission)] == [0, 1]
    assert "margin" not in cells(sortie_columns(mission))
