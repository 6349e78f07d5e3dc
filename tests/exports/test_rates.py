"""Rates and speeds that exports promise: autopilots take them, nothing clips them, and the tolerance contains them."""

import handmade_exports as handmade
import numpy as np
import pytest
import replayed_autopilot as autopilot

from skyverse import Origin

pytestmark = pytest.mark.usefixtures("unjudged")
pytest.importorskip("pyproj", reason="an independent geodesy")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)
SWIFT = {"max_speed": 25.0, "max_climb": 12.0, "max_descent": 9.0, "max_acceleration": 20.0}
SLOW = {"max_speed": 1.5, "max_climb": 0.5, "max_descent": 0.4, "max_acceleration": 1.0}
CORNERS = [(0, 0, 30), (200, 0, 30), (200, 0, 110), (0, 200, 110), (0, 200, 40)]

PX4_MOST = {  # the largest values that PX4's parameter reference allows
    "MPC_XY_VEL_MAX": 20,
    "MPC_XY_CRUISE": 20,
    "MPC_Z_VEL_MAX_UP": 8,
    "MPC_Z_V_AUTO_UP": 8,
    "MPC_Z_VEL_MAX_DN": 4,
    "MPC_Z_V_AUTO_DN": 4,
    "MPC_TKO_SPEED": 5,
    "MPC_ACC_HOR": 15,
}
ARDUPILOT_MOST = {  # of ArduPilot's parameter list, until Copter 4.6 and since 4.7
    "WPNAV_SPEED": 2000,
    "RTL_SPEED": 2000,
    "WPNAV_SPEED_UP": 1000,
    "WPNAV_SPEED_DN": 500,
    "WPNAV_ACCEL": 500,
    "WP_SPD": 20,
    "RTL_SPEED_MS": 20,
    "WP_SPD_UP": 10,
    "WP_SPD_DN": 5,
    "WP_ACC": 5,
}


def exported(folder, suffix, limits, corners=CORNERS, seconds=10.0, **how):
    """The certificate, the orders and the parameters of one UAV's files."""
    mission = handmade.mission([handmade.along(corners, seconds)], clearance=1.0, origin=ORIGIN, low=(-300, -300, -50))
    certificate, _, (file,) = handmade.exported(handmade.with_uavs(mission, **limits), folder, suffix, **how)
    read = autopilot.read_plan if suffix == "plan" else autopilot.read_waypoints
    return certificate, read(file.read_text(), ORIGIN), handmade.parameters(folder, suffix)


@pytest.mark.parametrize("limits", [{}, SWIFT, SLOW])
def test_px4_takes_what_its_file_sets_and_no_maximum_clips_it(tmp_path, limits):
    _, orders, values = exported(tmp_path, "plan", limits)
    assert {name: values[name] for name, most in PX4_MOST.items() if not 0 < values[name] <= most} == {}
    assert values["MPC_XY_VEL_MAX"] >= max(*orders.speeds[1:], values["MPC_XY_CRUISE"])
    assert values["MPC_Z_VEL_MAX_UP"] >= max(values["MPC_Z_V_AUTO_UP"], values["MPC_TKO_SPEED"])
    assert values["MPC_Z_VEL_MAX_DN"] >= values["MPC_Z_V_AUTO_DN"]
    assert max(values[name] for name in ("MPC_XY_VEL_ALL", "MPC_Z_VEL_ALL", "SYS_VEHICLE_RESP")) < 0  # or they override


def test_px4s_maxima_stand_before_what_px4_would_clip_while_the_file_is_loaded(tmp_path):
    _, _, values = exported(tmp_path, "plan", SWIFT)
    at = list(values).index
    assert at("MPC_XY_VEL_ALL") < at("MPC_XY_VEL_MAX") < at("MPC_XY_CRUISE")
    assert at("MPC_Z_VEL_ALL") < at("MPC_Z_VEL_MAX_UP") < at("MPC_TKO_SPEED")
    assert at("SYS_VEHICLE_RESP") < at("MPC_ACC_HOR")


@pytest.mark.parametrize("limits", [{}, SWIFT, SLOW])
def test_ardupilot_takes_what_its_file_sets(tmp_path, limits):
    _, orders, values = exported(tmp_path, "waypoints", limits)
    assert {name: values[name] for name, most in ARDUPILOT_MOST.items() if not 0 < values[name] <= most} == {}
    assert max(orders.speeds[1:]) <= values["WP_SPD"] + 1e-9
    assert min(orders.speeds[1:]) >= 0.2  # Copter ignores lower ones


@pytest.mark.parametrize("limits", [SWIFT, SLOW])
def test_no_uav_returns_faster_than_it_may_fly(tmp_path, limits):
    most = min(limits["max_speed"], 20.0)
    (tmp_path / "px4").mkdir()
    _, _, values = exported(tmp_path / "px4", "plan", limits)
    assert values["MPC_XY_CRUISE"] == pytest.approx(most)
    assert values["MPC_Z_V_AUTO_UP"] <= limits["max_climb"]
    assert max(values["MPC_Z_V_AUTO_DN"], values["MPC_Z_VEL_MAX_DN"]) <= limits["max_descent"]
    _, _, values = exported(tmp_path, "waypoints", limits)
    assert values["RTL_SPEED"] == pytest.approx(100 * most)
    assert values["RTL_SPEED_MS"] == values["WP_SPD"] == pytest.approx(most)
    assert values["WPNAV_SPEED"] == pytest.approx(100 * most)


@pytest.mark.parametrize(("limits", "said"), [({}, "1 to 5 m/s"), (SWIFT, "1 to 8.8 m/s"), (SLOW, "0.36 to 5 m/s")])
def test_a_fleet_is_told_for_which_climbs_it_is_judged(tmp_path, limits, said):
    sides = [handmade.along([(0, y, 40), (200, y, 40)], 30.0) for y in (0.0, 50.0)]
    mission = handmade.mission(sides, clearance=1.0, origin=ORIGIN)
    fleet = handmade.with_uavs(mission, **limits, separation=2.0)
    assert said in handmade.exported(fleet, tmp_path).certificate.apart.tolerance.sentence()


def test_px4_climbs_at_its_take_off_rate_only_to_10_m_above_its_home(tmp_path):
    seen, orders, values = exported(tmp_path, "plan", {"home": 0.0})
    rise = orders.places[0][2] - orders.home[2]
    assert rise > 10
    assert values["MPC_LAND_ALT1"] == 10
    seconds = handmade.takeoff_seconds(rise, "px4")
    assert seconds == pytest.approx(2.9 + 10 / values["MPC_TKO_SPEED"] + (rise - 10) / values["MPC_Z_V_AUTO_UP"])
    (back,) = seen.returns
    assert back.plan.arrivals[0] - orders.delay == pytest.approx(seconds, abs=0.05)


@pytest.mark.parametrize("radius", [0.5, 2.0, 8.0])
def test_copter_cuts_corners_within_the_radius_for_which_they_are_proven(tmp_path, radius):
    _, orders, values = exported(tmp_path, "waypoints", {}, radius=radius)
    assert values["WP_RADIUS_M"] == pytest.approx(max(orders.radii))
    assert 0.05 <= values["WP_RADIUS_M"] <= radius


@pytest.mark.parametrize("radius", [0.1, 0.3, 2.0, 8.0])
@pytest.mark.parametrize("slope", [0.0, 10.0, 14.0, 45.0, 89.0, 90.0])
def test_px4_turns_within_the_radius_for_which_corners_are_proven_however_steep_the_leg(tmp_path, radius, slope):
    _, orders, values = exported(tmp_path, "plan", {}, radius=radius)
    level, upright = max(orders.radii), values["NAV_MC_ALT_RAD"]
    assert 0.05 <= upright <= 0.5
    assert level > 0
    along, up = np.cos(np.radians(slope)), np.sin(np.radians(slope))
    before = np.linspace(0, 2 * radius, 20001)  # metres along the leg before its end
    accepted = (before * along <= level) & (before * up <= upright)  # as PX4 asks, each by itself
    assert before[accepted].max() <= radius + 1e-6


@pytest.mark.parametrize(("end", "stays"), [("land", True), ("rtl", True), ("loiter", False)])
@pytest.mark.parametrize("suffix", ["plan", "waypoints"])
def test_a_uav_settles_at_its_last_waypoint_before_it_lands_or_returns(tmp_path, suffix, end, stays):
    _, orders, _ = exported(tmp_path, suffix, {}, end=end)
    assert (orders.stays[-1] > 2) == stays  # else it turns home from within the radius, beside what is proven
