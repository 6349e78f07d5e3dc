"""Returns along the mission: proven where legs are, with all that autopilots fly otherwise on the way back."""

import json

import numpy as np
import pytest
from test_repair import flight, mended, place, scenario

import skyverse as sky
from skyverse.waypoints import FindingKind, Subject
from written_missions import item

SHUT = sky.Box(min=(60, -250, 0), max=(80, 100, 200), kind="building", name="block")
"""As high as the bounds: nothing leads over it."""
AROUND = [(0, 150, 30), (200, 150, 30), (200, 0, 30)]
"""Around it."""


def wrong(path, world, **settings):
    (found,) = sky.check_waypoints([sky.read_waypoints(path)], world, sky.FlightSettings(**settings)).missions
    return [one for one in found.findings if one.wrong]


def test_where_no_straight_way_home_is_clear_a_mission_is_proven_to_return_along_itself(tmp_path):
    path = flight(tmp_path, AROUND)
    assert {one.kind for one in wrong(path, scenario(SHUT))} == {FindingKind.LEVEL_WAY}
    assert wrong(path, scenario(SHUT), retraces=True) == []
    path = flight(tmp_path, AROUND, name="a.plan", firmware=3)  # whose order to return leads straight home nevertheless
    assert [one.subject for one in wrong(path, scenario(SHUT), retraces=True)] == [Subject.END]


def test_px4_flies_the_whole_mission_back_from_its_order_to_return(tmp_path):
    path, there = flight(tmp_path, AROUND), scenario(SHUT)
    (once,), (again,) = (
        sky.check_waypoints([sky.read_waypoints(path)], there, sky.FlightSettings(retraces=on)).missions
        for on in (False, True)
    )
    assert again.flown.plan.ending == pytest.approx(np.array([*again.flown.plan.waypoints[-2::-1], [0, 0, 0]]), abs=0.1)
    assert once.summary.length < again.summary.length


def test_the_way_back_does_not_stop_and_cuts_the_corner_at_a_stop(tmp_path):
    corner = sky.Box(min=(40, 40, 0), max=(90, 90, 60), kind="building")
    path = flight(tmp_path, [(0, 100, 30), (100, 100, 30), (100, 0, 30)], radius=40)
    data = json.loads(path.read_text())
    for one in data["mission"]["items"]:
        one["params"][0] = 5 if one["command"] == 16 else one["params"][0]
    path.write_text(json.dumps(data))
    assert [one for one in wrong(path, scenario(corner)) if one.part is not None] == []
    found = wrong(path, scenario(corner), retraces=True)
    assert {(one.subject, one.corner) for one in found} == {(Subject.WAY_HOME, True)}
    assert (5,) in {one.items for one in found}


@pytest.mark.parametrize(("beside", "kept"), [(6.0, False), (10.0, True)])
def test_smart_rtl_may_be_off_by_the_tracking_error_twice(tmp_path, beside, kept):
    wall = sky.Box(min=(50, 0, 0), max=(150, 10, 60), kind="building")
    path = flight(tmp_path, [(0, -beside, 30), (200, -beside, 30)], firmware=3, end=(206, 0, 0, 0, 0, 0, 0, 0))
    assert not [one for one in wrong(path, scenario(wall)) if one.part is not None]
    assert (wrong(path, scenario(wall), retraces=True) == []) is kept


def test_what_does_not_return_along_a_mission_is_told(tmp_path):
    jump = flight(tmp_path, AROUND, end=(177, 3, 1, 0, 0, 0, 0, 0))
    (found,) = [one for one in wrong(jump, scenario(), retraces=True) if one.subject is Subject.WAY_HOME]
    assert (found.kind, "jumps" in found.name) == (FindingKind.NO_WAY_BACK, True)
    plain = flight(tmp_path, AROUND)
    found = wrong(plain, scenario(), retraces=True, autopilot="dji")[0]
    assert found.kind is FindingKind.NO_WAY_BACK


@pytest.mark.parametrize("firmware", [12, 3], ids=["PX4", "ArduPilot"])
def test_a_mission_is_made_to_land_at_home_and_to_return_along_itself(tmp_path, firmware):
    path = flight(tmp_path, AROUND, firmware=firmware)
    made, found, old, new = mended(path, scenario(SHUT))
    assert found.is_proven, found.findings
    assert made.missions[0].retraces
    assert new[-1]["command"] == 21
    assert new[-1]["params"][4:] == pytest.approx([*place(0, 0), 0])
    told = {number for change in made.changes[0] for number in change.items}
    kept = [{k: v for k, v in one.items() if k != "doJumpId"} for one in new]
    for number, one in enumerate(old, 1):
        if number not in told:
            assert {k: v for k, v in one.items() if k != "doJumpId"} in kept
    assert item(20, *[0] * 7, frame=2, number=len(old)) in old
