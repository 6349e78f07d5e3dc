"""What autopilots do when they lose their link: they return only if that is proven from every instant of the flight."""

import json

import handmade_exports as handmade
import pytest

from skyverse import Box, Origin

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
OPEN = ([(0, 0, 10), (100, 0, 10)], ())
SHUT_IN = (
    [(0, 0, 10), (0, 250, 10), (60, 250, 10), (60, 0, 10), (120, 0, 10), (120, 200, 10)],
    (
        Box(min=(30, -300, -50), max=(31, 240, 150)),
        Box(min=(90, 15, -50), max=(91, 300, 150)),
        Box(min=(32, -300, -50), max=(300, 245, 8), kind="no-fly zone", solid=False),
    ),
)
"""A flight around two walls up to the top, over a zone on which nobody lands: from its end no line leads back."""


def exported(folder, suffix, corners, obstacles):
    mission = handmade.mission([handmade.along(corners, 40)], clearance=1.0, origin=ORIGIN)
    return handmade.exported(handmade.changed(mission, obstacles=obstacles), folder, suffix).back


@pytest.mark.parametrize("home", [True, False])
def test_px4_returns_when_it_loses_its_link_only_if_it_comes_home_from_everywhere(tmp_path, home):
    back = exported(tmp_path, "plan", *(OPEN if home else SHUT_IN))
    assert back.everywhere == home
    values = handmade.parameters(tmp_path)
    assert values["NAV_RCL_ACT"] == values["NAV_DLL_ACT"] == (2 if home else 1)  # return, or hold
    assert values["COM_RCL_EXCEPT"] == values["RTL_TYPE"] == 0
    assert json.loads((tmp_path / "m.plan").read_text())["mission"]["firmwareType"] == 12


@pytest.mark.parametrize("home", [True, False])
def test_ardupilot_returns_when_it_loses_its_link_or_goes_on_with_the_mission(tmp_path, home):
    back = exported(tmp_path, "waypoints", *(OPEN if home else SHUT_IN))
    assert back.everywhere == home
    values = handmade.parameters(tmp_path, "waypoints")
    assert values["FS_THR_ENABLE"] == values["FS_GCS_ENABLE"] == 1
    assert int(values["FS_OPTIONS"]) & 0b11 == (0 if home else 0b11)


def test_parameters_that_ardupilot_has_renamed_are_written_in_both_units(tmp_path):
    back = exported(tmp_path, "waypoints", *OPEN)
    values = handmade.parameters(tmp_path, "waypoints")
    for until, since in {
        "RTL_ALT": "RTL_ALT_M",
        "RTL_ALT_FINAL": "RTL_ALT_FINAL_M",
        "RTL_CLIMB_MIN": "RTL_CLIMB_MIN_M",
        "RTL_SPEED": "RTL_SPEED_MS",
        "WPNAV_SPEED": "WP_SPD",
        "WPNAV_SPEED_UP": "WP_SPD_UP",
        "WPNAV_SPEED_DN": "WP_SPD_DN",
        "WPNAV_ACCEL": "WP_ACC",
        "WPNAV_RADIUS": "WP_RADIUS_M",
    }.items():
        assert values[until] == pytest.approx(100 * values[since])
    assert values["RTL_ALT_M"] == pytest.approx(back.altitude)
    assert "Copter 4.0 to 4.7" in (tmp_path / "m.param").read_text().splitlines()[0]


def test_a_dji_aircraft_hovers_when_it_loses_its_link_as_no_return_near_home_is_proven(tmp_path):
    for flight in (OPEN, SHUT_IN):
        exported(tmp_path, "wpml.kmz", *flight)
        assert "executeRCLostAction>hover<" in handmade.waylines(tmp_path / "m.wpml.kmz")
