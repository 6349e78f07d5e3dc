"""Starts and targets are told that are unsafe only because UAVs stray from their nominal positions."""

import skyverse as sky
from skyverse.space.unsafe_points import unsafe_points

ERROR = {"horizontal": 1.0, "vertical": 1.5}


def scenario(start, target=(3, 3, 3), **uav):
    return sky.Scenario.model_validate(
        {
            "name": "tube",
            "bounds": {"min": (0, 0, 0), "max": (20, 12, 12)},
            "clearance": 0.5,
            "lattice": {"step": (1, 1, 1)},
            "obstacles": [{"min": (9, 2, 6), "max": (15, 8, 12)}],
            "uavs": [{"start": start, "tracking_error": ERROR} | uav],
            "targets": [{"position": target}],
        }
    )


def test_a_start_below_a_free_column_is_safe_but_not_for_an_aeroplane():
    assert unsafe_points(scenario((3, 3, 0.2))) == []
    (bad,) = unsafe_points(scenario((3, 3, 0.2), fixed_wing={"speed": 3, "turn_radius": 3, "climb": 30}))
    assert bad.field == "uavs[0].start"
    assert bad.reason.startswith("lies too near the bounds, (0, 0, 0) to (20, 12, 12), for the tracking error of 1 m")


def test_a_start_and_a_target_beside_or_below_what_does_not_end_above_are_told():
    start, target = unsafe_points(scenario((12, 5, 5), target=(8.2, 5, 9)))
    assert start.field == "uavs[0].start"
    assert start.reason.startswith(
        "lies inside obstacles[0] grown by the clearance of 0.5 m and the tracking error of 1 m horizontally and 1.5 m "
        "vertically"
    )
    assert start.nearest is not None
    assert target.field == "targets[0].position"
