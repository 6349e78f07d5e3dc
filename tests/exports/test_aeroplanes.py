"""Aeroplanes, whose corners and circles at the end no export may promise more of than is proven."""

import handmade_exports as handmade
import pytest
from exported_fleets import ORIGIN

import skyverse as sky
from skyverse.exports import Apart

pytestmark = pytest.mark.usefixtures("unjudged")

WING = sky.FixedWing(speed=15, turn_radius=40, climb=15)
FAR = handmade.LOW[0] * 4, handmade.HIGH[0] * 4


def wings(*flights, separation=20.0):
    low, high = (FAR[0], FAR[0], -50.0), (FAR[1], FAR[1], 200.0)
    made = handmade.mission(flights, origin=ORIGIN, wing=WING, low=low, high=high)
    return handmade.with_uavs(made, separation=separation)


def east(y, x=0.0, seconds=40, begin=0.0):
    return handmade.along([(x - 400, y, 100), (x + 200, y, 100)], seconds, begin)


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
@pytest.mark.parametrize("apart", [25.0, 90.0, 170.0])
def test_aeroplanes_whose_circles_at_the_end_may_meet_are_refused(tmp_path, suffix, apart, refuses):
    mission = wings(east(0.0), east(apart, -50.0))
    with refuses():
        handmade.exported(mission, tmp_path, suffix)
    proof, *_ = handmade.exported(mission, tmp_path, suffix, allow_close=True)
    assert proof.apart.pairs == {(0, 1): Apart.CLOSE}


@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_aeroplanes_whose_circles_cannot_meet_are_exported(tmp_path, suffix):
    proof, *_ = handmade.exported(wings(east(0.0), east(190.0)), tmp_path, suffix)
    assert proof.apart.only(Apart.SPACE)


@pytest.mark.parametrize(("passes", "kind"), [(0.0, Apart.SCHEDULE), (60.0, Apart.CLOSE)])
def test_who_flies_through_where_an_aeroplane_circles_has_to_be_gone_before(tmp_path, passes, kind):
    across = handmade.along([(150, -400, 100), (150, 600, 100)], 60, passes)
    proof, *_ = handmade.exported(wings(east(0.0, seconds=28), across), tmp_path, "waypoints", allow_close=True)
    assert proof.apart.pairs == {(0, 1): kind}


def test_an_aeroplane_counts_as_anywhere_within_twice_its_turn_radius_of_its_end(tmp_path):
    for apart, kind in ((179.0, Apart.CLOSE), (181.0, Apart.SPACE)):
        proof, *_ = handmade.exported(wings(east(0.0), east(apart)), tmp_path, "waypoints", allow_close=True)
        assert proof.apart.pairs == {(0, 1): kind}


def test_the_verdict_says_that_circles_at_the_end_are_not_proven(tmp_path):
    proof, *_ = handmade.exported(wings(east(0.0)), tmp_path, "waypoints")
    assert proof.flights[0].at_end == "circles within 80 m of its target (NOT proven)"


def test_nothing_is_known_of_where_px4_turns_an_aeroplane(tmp_path):
    """Apart by far more than the radius, but what is flown at the corner is not known."""
    corner = [(-600, 0, 100), (0, 0, 100), (0, -600, 100)]
    fleet = wings(handmade.along(corner, 40), handmade.along([(-600, 300, 100), (600, 300, 100)], 80))
    known, *_ = handmade.exported(fleet, tmp_path, "waypoints")
    assert known.apart.only(Apart.SPACE)
    assert known.flights[0].legs_proven
    proof, *_ = handmade.exported(fleet, tmp_path, "plan")
    assert proof.apart.pairs == {(0, 1): Apart.SCHEDULE}
    assert not proof.flights[0].legs_proven
