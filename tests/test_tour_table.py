"""Tables of tours: what they say is what the mission holds, and margins are told on the safe side."""

from dataclasses import replace

import pytest

import skyverse as sky
from rounds import rounds
from skyverse.model.flight_table import battery_sentence, flight_columns, idle_sentence
from skyverse.referee.energy import energy_bounds, turning_back
from skyverse.summary import with_flight_summaries
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


def fleet(criterion, targets=3):
    """Two UAVs side by side before a row of targets."""
    bounds = sky.Bounds(min=(-50, -50, 0), max=(150, 50, 40))
    uavs = [sky.UAV(name=name, start=(0.0, y, 5.0)) for name, y in (("alpha", -10.0), ("beta", 10.0))]
    places = [sky.Target(name=f"tower {k}", position=(30.0 + 5.0 * k, 0.0, 10.0)) for k in range(targets)]
    lattice = sky.Lattice(step=(5, 5, 5))
    open_air = sky.Scenario(
        name="open", bounds=bounds, clearance=1.0, lattice=lattice, uavs=uavs, targets=places, objective=METRES
    )
    return sky.plan_mission(open_air, rng=1, options=sky.MissionOptions(criterion=criterion))


METRES = sky.Objective(unit="metres")


def test_a_uav_without_work_is_told_with_the_option_that_gives_it_some():
    mission = fleet("min-sum")
    said = idle_sentence(mission)
    idle = [uav.name for k, uav in enumerate(mission.scenario.uavs) if not mission.sorties_of(k)]
    assert len(idle) == 1
    assert said.startswith(f"{idle[0]} has no target, ")
    assert said.endswith("give criterion='min-max' for the last UAV to be done as soon as possible")
    both = fleet("min-max")
    assert all(both.sorties_of(k) for k in range(2))
    assert both.makespan < mission.makespan
    assert idle_sentence(both) == idle_sentence(fleet("min-sum", targets=1)) == ""


def test_a_battery_has_one_figure_in_all_tables_and_is_explained_once():
    mission = with_flight_summaries(rounds())
    flights, sorties = cells(flight_columns(mission)), list(numbered_sorties(mission))
    for uav, summary in enumerate(mission.flights):
        own = min(one.battery.left[-1] for one in sorties if one.uav == uav)
        assert own == pytest.approx(summary.left, abs=1e-7)
    (alone,) = [one for one in sorties if len(mission.sorties[one.uav]) == 1]
    told = cells(sortie_columns(mission))["battery left"][sorties.index(alone)]
    assert flights["battery left"][alone.uav] == told
    assert "90 % count" in battery_sentence(mission)
    assert battery_sentence(fleet("min-sum")) == ""
