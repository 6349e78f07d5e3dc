"""Missions of DJI's app and Litchi are mended in their own files: what is done at a waypoint stays there."""

import pytest

import skyverse as sky
import written_missions as given
from skyverse.model.waypoints import OrderKind as Kind

ORIGIN = sky.Origin(latitude=47.001, longitude=8.0, altitude=400.0)
TOWER = sky.Box(min=(60, -15, 0), max=(90, 15, 75), kind="building", name="tower")
"""On the leg between the first two waypoints, 152 m long, of all missions here."""


def world():
    return sky.Scenario(
        name="field",
        bounds=sky.Bounds(min=(-200, -250, 0), max=(500, 500, 200)),
        obstacles=(TOWER,),
        clearance=2.0,
        objective={"unit": "metres"},
        uavs=({"start": (0, 0, 1), "home": 0.0, "vehicle": "camera"},),
        frame={"origin": ORIGIN},
    )


def done(waypoints):
    """What is done at each waypoint of the file, in order, by the place of the waypoint."""
    told = {}
    for order in waypoints.orders:
        if order.kind is Kind.WAYPOINT:
            at = tuple(round(one, 6) for one in order.place[:2])
            told.setdefault(at, [])
        elif order.kind is not Kind.TAKEOFF:
            told[at].append((order.kind, order.name, order.seconds, order.heading, order.spacing))
    return told


@pytest.mark.parametrize("name", ["m.wpml.kmz", "m.csv"])
def test_a_leg_is_led_around_a_tower_and_actions_stay_at_their_waypoints(tmp_path, name):
    content = given.EVERY_FORMAT[name][0]
    if name == "m.csv":
        content = content.replace(",1,5.5,", ",0,5.5,")  # above the take-off
    path = given.write(tmp_path / name, content)
    settings = sky.FlightSettings(home=(47.001, 8.0))
    before = sky.read_waypoints(path)
    (judged,) = sky.check_waypoints([before], world(), settings).missions
    legs = {one.items for one in judged.findings if one.wrong and "building" in str(one)}
    assert (1, 2) in legs
    made = sky.repair_waypoints([before], world(), settings)
    fixed = tmp_path / f"fixed-{name}"
    sky.write_waypoints(made.missions[0], fixed)
    after = sky.read_waypoints(fixed)
    (found,) = sky.check_waypoints([after], world(), settings).missions
    assert [one for one in found.findings if one.wrong and "building" in str(one)] == []
    places, still = done(before), done(after)
    assert len(still) > len(places)
    assert all(still[at] == actions for at, actions in places.items())
    assert all(not actions for at, actions in still.items() if at not in places)
