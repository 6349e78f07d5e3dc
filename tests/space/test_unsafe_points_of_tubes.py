"""Starts and targets are told that are unsafe only because UAVs stray from their nominal positions."""

import skyverse as sky
from skyverse.space.unsafe_points import unsafe_points

ERROR = {"horizontal": 1.0, "vertical": 1.5}


def scenario(start, target=(3, 3, 3), uav=None, **changes):
    return sky.Scenario.model_validate(
        {
            "name": "tube",
            "bounds": {"min": (0, 0, 0), "max": (20, 12, 12)},
            "clearance": 0.5,
            "lattice": {"step": (1, 1, 1)},
            "obstacles": [{"min": (9, 2, 6), "max": (15, 8, 12)}],
            "uavs": [{"start": start, "tracking_error": ERROR} | (uav or {})],
            "targets": [{"position": target}],
        }
        | changes
    )


def test_a_start_below_a_free_column_is_safe_but_not_for_an_aeroplane():
    assert unsafe_points(scenario((3, 3, 0.2))) == []
    (bad,) = unsafe_points(scenario((3, 3, 0.2), uav={"fixed_wing": {"speed": 3, "turn_radius": 3, "climb": 30}}))
    assert bad.field == "uavs[0].start"
    assert bad.reason.startswith("lies too near the bounds, (0, 0, 0) to (20, 12, 12), for the tracking error of 1 m")


def test_a_start_and_a_target_beside_or_below_what_does_not_end_above_are_told():
    start, target = unsafe_points(scenario((12, 5, 5), target=(8.2, 5, 9)))
    assert start.field == "uavs[0].start"
    assert start.reason == (
        "is 2.51 m too near obstacles[0]: all but what it stands on must keep the tracking error of 1 m horizontally "
        "and 1.5 m vertically from its pad, 1 m about it and up to z = 6.51 m"
    )
    assert start.nearest == (12, 5, 4)
    assert target.field == "targets[0].position"


def test_a_start_too_near_a_wall_is_told_by_how_much_and_where_the_nearest_place_with_room_for_a_pad_is():
    given = scenario((8.2, 5, 0.5), obstacles=(sky.Box(min=(9, 0, 0), max=(15, 12, 11)),))
    (bad,) = unsafe_points(given)
    assert bad.reason.startswith("is 1.2 m too near obstacles[0]: all but what it stands on")
    assert bad.nearest == (7.5, 5, 1.5)  # from where it may stray


def test_a_start_beside_steep_ground_is_told_so():
    terrain = {"origin": (0, 0), "step": (10, 12), "heights": [[0, 0], [0, 0], [30, 30]]}
    around = {"bounds": {"min": (0, 0, 0), "max": (20, 12, 60)}, "obstacles": ()}
    (within,) = unsafe_points(scenario((8.6, 5, 0.5), terrain=terrain, **around))
    assert within.reason.startswith(
        "is too near ground that is steeper than 45 degrees: all but what it stands on must"
    )
    assert unsafe_points(scenario((8.4, 5, 0.5), terrain=terrain, **around)) == []


def test_a_start_over_airspace_is_told_that_nobody_stands_on_it():
    zone = sky.Box(min=(0, 0, 0), max=(5, 5, 1), kind="no-fly zone", solid=False)
    (bad,) = unsafe_points(scenario((3, 3, 1.5), obstacles=(zone,)))
    assert bad.reason.startswith("is 1.5 m too near obstacles[0] (no-fly zone): all but what it stands on must keep")
