"""The 3-D view begins where the flight is seen, in front of the mountain."""

import json

import numpy as np
import pytest

import skyverse as sky
from browser import opened
from skyverse.draw import FROM_THE_SOUTH, first_view, scene, scene_data


def beside_a_ridge(side):
    """A flight along the foot of a ridge from west to east, which stands south of it, north of it, or nowhere."""
    y = np.arange(-500.0, 501.0, 20.0)
    heights = 300.0 * np.exp(-(((y - {"south": -60, "north": 60, "none": 1e9}[side]) / 25.0) ** 2))
    ground = sky.Terrain(origin=(-500.0, -500.0), step=(20.0, 20.0), heights=np.tile(heights, (51, 1)), clearance=1.0)
    scenario = sky.Scenario.model_validate(
        {
            "name": "ridge",
            "bounds": {"min": (-500, -500, 0), "max": (500, 500, 400)},
            "clearance": 1.0,
            "lattice": {"step": (50, 50, 50), "connectivity": 26},
            "objective": {"unit": "metres"},
            "terrain": ground,
            "uavs": ({"start": (-450, 20 if side == "south" else -20, 120)},),
            "targets": ({"position": (450, 20 if side == "south" else -20, 120)},),
        }
    )
    return sky.plan_mission(scenario, sky.Taut())


@pytest.mark.parametrize(("side", "north"), [("south", True), ("north", False), ("none", False)])
def test_the_view_begins_on_the_side_of_the_ridge_on_which_the_flight_is(side, north):
    drawn = scene(beside_a_ridge(side))
    east, ahead = first_view(drawn.world, drawn.tracks, drawn.scenario.terrain)
    assert (ahead > 0) == north
    assert np.hypot(east, ahead) == pytest.approx(np.hypot(*FROM_THE_SOUTH))
    if not north:
        assert (east, ahead) == FROM_THE_SOUTH
    assert json.loads(json.dumps(scene_data(drawn)["overview"])) == [east, ahead]


@pytest.mark.parametrize(("side", "north"), [("south", True), ("north", False)])
def test_the_page_looks_from_that_side(side, north, tmp_path, tab):
    sky.write_html(beside_a_ridge(side), tmp_path / "ridge.html")
    opened(tab, tmp_path / "ridge.html")
    eye = tab.evaluate("internals.space(document.getElementById('space')).getCamera().eye")
    assert (eye["y"] > 0) == north
