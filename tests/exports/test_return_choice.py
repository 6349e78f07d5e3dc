"""Return altitudes are chosen with rally points, where from home alone there is no way home at every instant."""

import re
from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse.exports.return_choice import MAX_RALLY_POINTS
from skyverse.model.caution import stands_out
from skyverse.model.frame import Origin
from skyverse.model.shapes import Terrain

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)


def along_a_slope(rise, ceiling=50.0, above=25.0):
    """A flight of 400 m at one height above ground that rises by so many metres all along, below a ceiling."""
    x = np.linspace(-320, 320, 33)
    heights = np.interp(x, [-200, 200], [max(-rise, 0.0), max(rise, 0.0)])[:, None] * np.ones((1, 33))
    ground = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=heights, clearance=2.0)
    ends = [(-200, 0, max(-rise, 0.0) + above), (200, 0, max(rise, 0.0) + above)]
    mission = handmade.mission([handmade.along(ends, 60)], terrain=ground, clearance=1.0, origin=ORIGIN)
    return replace(mission, scenario=mission.scenario.model_copy(update={"max_height": ceiling}))


def way_home(mission, folder, suffix):
    seen = []
    sky.export(mission, folder / f"m.{suffix}", end="rtl", on_certificate=seen.append)
    (back,) = seen[0].returns
    return back


def heights_above_ground(mission, back):
    """The heights above ground on the returns from many instants, but for the descents, flown by code of the test."""
    home, altitude, found = back.plan.home, back.altitude, []
    flight = back.plan.predicted()
    for at in flight.at(np.linspace(back.plan.arrivals[0], back.plan.arrivals[-1], 100)).position:
        goals = np.array([home, *back.rally_points])
        goal = goals[np.argmin(np.hypot(*(goals[:, :2] - at[:2]).T))]
        level = {"px4": goal[2] + altitude, "ardupilot": max(home[2] + altitude, goal[2]), "dji": home[2] + altitude}
        top = max(at[2], level[back.plan.autopilot.name])
        across = np.linspace([*at[:2], top], [*goal[:2], top], 200)
        found.append(across[:, 2] - handmade.under(mission.scenario, across))
    return np.array(found)


@pytest.mark.parametrize(("suffix", "rise"), [("plan", 100.0), ("plan", -100.0), ("waypoints", 100.0)])
def test_along_a_slope_below_a_ceiling_rally_points_at_another_altitude_lead_home(tmp_path, suffix, rise):
    """At no altitude does the way home alone keep both the ground and the ceiling, and no altitude keeps the first."""
    mission = along_a_slope(rise)
    back = way_home(mission, tmp_path, suffix)
    assert len(back.lost) == 0
    assert back.proven
    assert 1 <= len(back.rally) <= MAX_RALLY_POINTS[back.plan.autopilot.name]
    heights = heights_above_ground(mission, back)
    assert heights.min() >= 2.0 - 0.5 - 0.03
    assert heights.max() <= 50.0 + 0.03


@pytest.mark.parametrize("suffix", ["plan", "waypoints", "wpml.kmz"])
def test_a_low_altitude_is_taken_where_the_flight_itself_is_high_enough(tmp_path, suffix):
    """The way up to the height of the start is above the ceiling at the far end, the flight's own height is not."""
    mission = along_a_slope(-30.0)
    back = way_home(mission, tmp_path, suffix)
    assert len(back.lost) == len(back.rally) == 0
    assert back.altitude < 25
    assert heights_above_ground(mission, back).max() <= 50.0 + 0.03


def test_where_there_is_none_it_is_said_why_and_for_which_autopilot_there_may_be_one(tmp_path):
    """ArduPilot returns above its home, which is above the ceiling at the end of the slope."""
    with pytest.raises(sky.InputError) as caught:
        way_home(along_a_slope(-100.0), tmp_path, "waypoints")
    said = str(caught.value)
    assert "the air above the ceiling of 50 m above ground" in said
    assert "export for PX4, which counts its return altitude from where it lands" in said


@pytest.mark.parametrize(("suffix", "rise"), [("plan", 100.0), ("waypoints", 100.0), ("plan", -30.0)])
def test_rally_points_that_nobody_asked_for_stand_out(tmp_path, suffix, rise):
    notes, seen = [], []
    mission = along_a_slope(rise)
    sky.export(mission, tmp_path / f"m.{suffix}", on_note=notes.append, on_certificate=seen.append)
    (back,) = seen[0].returns
    told = [note for note in notes if stands_out(note) and f"{len(back.rally)} of uav-1" in note]
    assert len(told) == (len(back.rally) > 0) == (rise > 0)


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_every_place_where_it_may_land_is_told_with_the_altitude_of_the_return(tmp_path, suffix):
    mission, notes, seen = along_a_slope(100.0), [], []
    sky.export(mission, tmp_path / f"m.{suffix}", end="rtl", on_note=notes.append, on_certificate=seen.append)
    (back,) = seen[0].returns
    (told,) = [note for note in notes if "may land at" in note]
    numbers = re.findall(
        r"at ([-\d.]+), ([-\d.]+), ([-\d.]+) m above mean sea level, returning there at ([\d.]+) m", told
    )
    places = np.array(numbers, dtype=float)
    there = [handmade.local(ORIGIN, [lat], [lon], [sea])[0] for lat, lon, sea, _ in places]
    np.testing.assert_allclose(there, [back.plan.home, *back.rally], atol=0.2)
    above_home = places[:, 3] - places[0, 2]
    assert above_home[0] == pytest.approx(back.altitude, abs=0.11)
    if suffix == "plan":  # PX4 counts from where it lands
        assert places[:, 3] - places[:, 2] == pytest.approx(np.full(len(places), back.altitude), abs=0.11)
    else:
        written = [float(row.split("\t")[3]) for row in (tmp_path / "m.ral").read_text().splitlines() if row[0] == "R"]
        assert above_home[1:] == pytest.approx(np.maximum(written, back.altitude), abs=0.11)
    (returns,) = [note for note in notes if "it returns at" in note]
    assert f"m above {'where it lands' if suffix == 'plan' else 'home'}, to the nearest" in returns
