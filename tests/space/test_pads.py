"""The pads of a fleet are named in one short sentence."""

import skyverse as sky
from skyverse.space.pads import fleet_pads, pads_sentence

ERROR = {"horizontal": 1.0, "vertical": 1.5}
WING = {"speed": 3, "turn_radius": 3, "climb": 30}


def scenario(*uavs):
    return sky.Scenario.model_validate(
        {
            "name": "pads",
            "bounds": {"min": (0, 0, 0), "max": (40, 12, 12)},
            "clearance": 0.5,
            "lattice": {"step": (1, 1, 1)},
            "uavs": uavs,
            "targets": [{"position": (20, 6, 0.25)}, {"position": (20, 6, 6)}],
        }
    )


def told(given, assignment):
    return pads_sentence(given, fleet_pads(given, assignment))


def straying(x, **changes):
    return {"start": (x, 6, 0.5), "tracking_error": ERROR} | changes


def test_pads_at_starts_and_targets_are_named_with_their_tops():
    given = scenario(straying(3), {"start": (6, 6, 0.5)}, straying(9, fixed_wing=WING), straying(12))
    assert told(given, (0, None, None, 1)) == (
        "On the pads at starts and targets the tracking error does not count for the ground and roofs below: "
        "of uav-1 at its start up to z = 2.01 m and at its target up to z = 1.76 m; "
        "of uav-4 at its start up to z = 2.01 m."
    )


def test_of_large_fleets_the_first_pads_are_named_and_the_others_counted():
    given = scenario(*(straying(x) for x in range(3, 33, 3)))
    assert told(given, (None,) * 10).endswith("of uav-3 at its start up to z = 2.01 m; and of 7 more UAVs.")
    four = scenario(*(straying(x) for x in range(3, 15, 3)))
    assert told(four, (None,) * 4).endswith("; and of 1 more UAV.")


def test_without_lifts_nothing_is_said():
    assert told(scenario({"start": (3, 6, 0.5)}), (0,)) == ""
    assert told(scenario(straying(3, start=(3, 6, 6))), (1,)) == ""
