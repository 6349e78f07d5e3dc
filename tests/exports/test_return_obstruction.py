"""Where there is no way home, exports say for whom, from when to when, what is in the way, and what may help."""

from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse.model.frame import Origin
from skyverse.model.shapes import Box, Terrain

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
WALL = ((30, -300, -50), (31, 200, 150))


def changed(mission, **fields):
    return replace(mission, scenario=mission.scenario.model_copy(update=fields))


def around_a_wall(count=1, **kind):
    """UAVs that fly around a wall up to the upper bound: from beyond it there is no straight way home."""
    flights = [
        handmade.along([(0, 10 * k, 10), (0, 250 + 10 * k, 10), (60 + 10 * k, 250 + 10 * k, 10), (60, 10 * k, 10)], 10)
        for k in range(count)
    ]
    mission = handmade.mission(flights, clearance=1.0, origin=ORIGIN)
    return changed(mission, obstacles=(Box(min=WALL[0], max=WALL[1], **kind),))


def from_a_plateau(ceiling=40.0):
    """A flight from a plateau at z = 60 into a valley at z = 0, and on below the ceiling above ground."""
    heights = np.interp(np.linspace(-320, 320, 33), [-120, 60], [60.0, 0.0])[:, None] * np.ones((1, 33))
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=2.0)
    flight = handmade.along([(-200, 0, 80), (-120, 0, 80), (60, 0, 20), (200, 0, 20)], 20)
    mission = handmade.mission([flight], terrain=ground, clearance=1.0, origin=ORIGIN)
    return changed(mission, max_height=ceiling)


def refused(mission, folder, suffix="wpml.kmz"):
    with pytest.raises(sky.InputError) as caught:
        sky.export(mission, folder / f"m.{suffix}", end="rtl", allow_close=True)
    return str(caught.value)


def test_a_refused_return_names_every_uav_when_what_is_in_the_way_and_what_may_help(tmp_path):
    said = refused(around_a_wall(2, kind="building", name="tower"), tmp_path)
    assert said.startswith("end: no way home is proven from the last waypoint: uav-1: at ")
    assert "; uav-2: at " in said
    assert said.count(". ") == 1  # what and where; what to do
    met = "the straight way home comes too near to obstacle 0 (building 'tower'), which is solid, at 4"
    assert said.count(met) == 2
    assert said.count("the highest that was tried") == 2
    assert "Export for PX4 or ArduPilot, which take rally points" in said
    assert said.endswith("give end='loiter' to stay at the target")
    assert not list(tmp_path.iterdir())


def test_a_refused_return_of_many_uavs_tells_a_few_and_counts_the_others(tmp_path):
    said = refused(around_a_wall(5), tmp_path)
    assert "uav-3: at " in said
    assert "uav-4" not in said
    assert "; and 2 more UAVs. Export for PX4" in said


def test_the_place_in_the_way_is_that_of_the_obstacle(tmp_path):
    seen = []
    sky.export(around_a_wall(), tmp_path / "m.wpml.kmz", on_certificate=seen.append)
    (back,) = seen[0].returns
    (why,) = back.obstructions
    assert (why.kind, why.where) == ("solid", "straight way home")
    assert 30 - 2 <= why.position[0] <= 31 + 2
    assert why.position[2] == pytest.approx(back.level, abs=0.01)


def test_notes_say_whether_a_rule_or_a_solid_thing_is_in_the_way(tmp_path):
    told = {}
    for kind, solid in (("building", True), ("no-fly zone", False)):
        notes = []
        sky.export(around_a_wall(kind=kind, solid=solid), tmp_path / "m.wpml.kmz", on_note=notes.append)
        (told[kind],) = (note for note in notes if "no way home from t = " in note)
    assert "comes too near to obstacle 0 (building), which is solid, at " in told["building"]
    assert "breaks a rule and meets nothing solid: it enters obstacle 0 (no-fly zone) at " in told["no-fly zone"]


def test_behind_a_zone_a_solid_thing_is_told_rather_than_the_rule(tmp_path):
    mission = around_a_wall(kind="no-fly zone", solid=False)
    behind = Box(min=(10, -300, -50), max=(11, 200, 150), kind="building")
    mission = changed(mission, obstacles=(*mission.scenario.obstacles, behind))
    assert "obstacle 1 (building), which is solid" in refused(mission, tmp_path)


def test_a_ceiling_in_the_way_is_told_as_a_rule_that_can_be_changed(tmp_path):
    said = refused(from_a_plateau(), tmp_path)
    assert "it enters the air above the ceiling of 40 m above ground at " in said
    assert "Plan with a higher ceiling above ground" in said
    sky.export(from_a_plateau(100.0), tmp_path / "m.wpml.kmz", end="rtl")


def test_ground_in_the_way_is_told(tmp_path):
    """A ridge up to the upper bound, around which the flight leads."""
    heights = np.zeros((33, 33))
    heights[17:19, :26] = 149.0
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=2.0)
    flight = handmade.along([(-100, 0, 20), (-100, 285, 20), (120, 285, 20), (120, 0, 20)], 20)
    mission = handmade.mission([flight], terrain=ground, clearance=1.0, origin=ORIGIN)
    said = refused(mission, tmp_path)
    assert "the straight way home comes too near to the ground, which is solid" in said
    assert "higher ceiling" not in said
