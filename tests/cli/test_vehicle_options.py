"""The options of the command line that limit a whole fleet."""

import pytest

import skyverse as sky


def test_plan_gives_all_uavs_the_limits_of_a_vehicle_and_those_that_are_given(skyverse):
    limits = ("--vehicle", "indoor", "--max-climb", 0.5, "--max-descent", 0.4, "--separation", 0.3)
    limits += ("--tracking-error", "0.05,0.1")
    code, out, err = skyverse("plan", "table-4.9-2", "--planner", "taut", "--no-page", "-o", "m.json", *limits)
    assert code == 0, (out, err)
    for uav in sky.read_mission("m.json").scenario.uavs:
        assert (uav.vehicle, uav.max_speed, uav.max_climb, uav.max_descent) == ("indoor", 1.0, 0.5, 0.4)
        assert uav.ellipsoid == (0.3, 0.6)
        assert uav.tracking_error == sky.TrackingError(horizontal=0.05, vertical=0.1)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ("--vehicle", "rocket"),
            "--vehicle: expected one of indoor, thesis, camera, heavy, m100, mapping, found 'rocket'",
        ),
        (("--tracking-error", "3"), "--tracking-error: expected horizontal,vertical in metres, as in 1.5,2, found '3'"),
        (("--tracking-error", "3,-1"), "--tracking-error: expected 2 numbers from 0 on"),
        (("--max-climb", "-1"), "--max-climb: expected a number from 0.001"),
        (("--vehicle", "mapping", "--max-speed", "5"), "uav-1: fixed_wing.speed of 15 m/s"),
    ],
)
def test_limits_that_cannot_be_are_refused_in_one_sentence(skyverse, words, says):
    code, _, err = skyverse("plan", "map1", *words)
    assert code == 2
    assert says in err
    assert err.count("\n") == 1
