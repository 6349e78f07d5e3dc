"""Descents keep clear of what stands beside, down to the clearance above where a UAV lands."""

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain
from skyverse.exports import WAYS

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
ERROR = sky.TrackingError(horizontal=1.5, vertical=2.0)
OUT = [(0, 0, 12), (100, 0, 12)]


def flat(clearance):
    return Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=clearance)


def flight(x, away, high, *, ground=1.0, error=None):
    """A flight 12 m above a plain, with a wall so far beyond the place (x, 0) that is so high; clearance 1 m."""
    near, far = (x + away, x + away + 1) if x else (-away - 1, -away)
    wall = ((near, -10, -5), (far, 10, high))
    mission = handmade.mission(
        [handmade.along(OUT, 20)], boxes=[wall], clearance=1.0, origin=ORIGIN, terrain=flat(ground)
    )
    return mission if error is None else handmade.with_uavs(mission, tracking_error=error)


@pytest.mark.parametrize(
    ("away", "high", "clear"), [(0.3, 9.0, False), (0.3, 1.4, False), (0.3, 0.2, True), (0.8, 9.0, True)]
)
@pytest.mark.parametrize("ground", [0.5, 5.0])
def test_the_descent_at_home_keeps_half_the_clearance_from_a_wall_that_is_lower_than_the_start(
    tmp_path, away, high, clear, ground
):
    """The start is 12 m above the ground on which the UAV lands; the lines end 1 m above that."""
    back = handmade.exported(flight(0, away, high, ground=ground), tmp_path, "waypoints").back
    assert (not back.gaps) == clear
    if not clear:
        assert {gap.why for gap in back.gaps} == {WAYS[2]}


@pytest.mark.parametrize(
    ("away", "high", "clear"), [(1.6, 9.0, False), (1.6, 0.4, False), (1.6, -0.1, True), (4.0, 9.0, True)]
)
def test_it_keeps_the_tracking_error_from_that_wall_as_well(tmp_path, away, high, clear):
    """Twice above home, where it is called back off its path and strays again."""
    back = handmade.exported(flight(0, away, high, error=ERROR), tmp_path, "waypoints").back
    assert (not back.gaps) == clear


@pytest.mark.parametrize(
    ("away", "high", "ground", "lands"),
    [
        (0.3, 0.9, 1.0, False),
        (0.3, -0.2, 1.0, True),
        (1.1, 9.0, 1.0, True),
        (0.3, 3.0, 5.0, False),
        (0.9, 3.0, 5.0, False),
        (1.1, 3.0, 5.0, True),
    ],
)
def test_a_landing_keeps_the_clearance_from_walls_down_to_the_clearance_above_ground(
    tmp_path, away, high, ground, lands, refuses
):
    mission = flight(100, away, high, ground=ground)
    if lands:
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))
    else:
        with refuses():
            sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))


@pytest.mark.parametrize(("away", "lands"), [(1.6, False), (2.4, False), (2.6, True)])
def test_a_landing_keeps_the_tracking_error_from_walls_where_the_ground_is_kept_farther(tmp_path, away, lands, refuses):
    mission = flight(100, away, 3.0, ground=5.0, error=ERROR)
    if lands:
        sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))
    else:
        with refuses():
            sky.export(mission, tmp_path / "m.plan", sky.ExportOptions(end="land"))


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
@pytest.mark.parametrize(("rise", "clear"), [(0.97, True), (1.03, False), (1.3, False)])
def test_a_slope_steeper_than_45_degrees_beside_home_is_a_wall_within_the_error(tmp_path, suffix, rise, clear):
    """The UAV may stray by 3 m to the side, where the slope is 3.9 m higher; it descends from 25 m to 1 m."""
    east = np.linspace(-320, 320, 641)
    heights = np.clip(rise * east, -50, 50)[:, None] * np.ones((1, 33))
    hill = Terrain(origin=(-320.0, -320.0), step=(1.0, 20.0), heights=heights, clearance=1.0)
    away = handmade.along([(0, 0, 25), (-40, 100, 25)], 20)
    mission = handmade.mission([away], clearance=1.0, origin=ORIGIN, terrain=hill)
    error = sky.TrackingError(horizontal=3.0, vertical=1.5)
    back = handmade.exported(handmade.with_uavs(mission, tracking_error=error), tmp_path, suffix).back
    assert back.everywhere == clear
    assert back.nowhere != clear


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
@pytest.mark.parametrize("end", ["land", "rtl"])
def test_no_aeroplane_is_sent_straight_down(tmp_path, suffix, end, refuses):
    wing = sky.FixedWing(speed=15.0, turn_radius=30.0, climb=15.0)
    mission = handmade.mission([handmade.along(OUT, 20)], origin=ORIGIN, terrain=flat(1.0), wing=wing)
    with refuses():
        sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(end=end))
    assert not list(tmp_path.iterdir())
