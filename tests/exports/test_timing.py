"""When a UAV may be where: files that are replayed faster, slower and later stay within what separations count on."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import handmade_exports as handmade
import numpy as np
import pytest
from exported_fleets import ORIGIN, read_orders
from hypothesis import example, given, settings
from hypothesis import strategies as st
from replayed_autopilot import STEP, fly

import skyverse as sky
from skyverse import UAV, Terrain
from skyverse.exports import USUAL_TOLERANCE, timed_path
from skyverse.exports.autopilots import AUTOPILOTS, rates_of
from skyverse.exports.separation import takeoff_lag

pytestmark = pytest.mark.usefixtures("unjudged")

FLAT = Terrain(origin=(-320.0, -320.0), step=(20.0, 20.0), heights=np.zeros((33, 33)), clearance=1.0)
ROUTES = [
    [(0, 0, 3), (60, 0, 3)],
    [(0, 0, 30), (80, 0, 30), (80, 0, 60), (80, 60, 60), (0, 60, 20)],
    [(0, 0, 8), (40, 10, 20), (90, -10, 20), (90, 60, 12), (90, 60, 40), (20, 60, 40)],
]
SUFFIXES = ["plan", "waypoints", "wpml.kmz"]
LIMITS = [
    {},
    {"max_speed": 25.0, "max_climb": 12.0, "max_descent": 9.0, "max_acceleration": 20.0},
    {"max_speed": 1.5, "max_climb": 0.5, "max_descent": 0.4, "max_acceleration": 1.0},
]


@cache
def exported(suffix, route, radius=2.0, end="loiter", seconds=12.0, limits=0):
    """The orders of one UAV's files, its flight plan, where it may be when, and how fast it may climb."""
    mission = handmade.mission([handmade.along(ROUTES[route], seconds)], clearance=1.0, origin=ORIGIN, terrain=FLAT)
    mission = handmade.with_uavs(mission, home=0.0, **LIMITS[limits])
    with TemporaryDirectory() as folder:
        told = handmade.exported(mission, Path(folder), suffix, radius=radius, end=end)
        (orders,) = read_orders(mission.scenario, told.files)
    tolerance = told.certificate.apart.tolerance
    return orders, told.back.plan, timed_path(mission.scenario, told.back.plan, tolerance), tolerance


def expected(path, at, time):
    """Whether a UAV may be at a place at a time, to a few centimetres and hundredths of a second."""
    way = path.ends - path.starts
    share = np.sum((at - path.starts) * way, axis=1) / np.maximum(np.sum(way * way, axis=1), 1e-12)
    share = np.clip(share, 0, 1)
    off = path.deviation[:, 0] + share * np.diff(path.deviation)[:, 0]
    near = np.linalg.norm(path.starts + share[:, None] * way - at, axis=1) <= off + 0.06
    stay = np.linalg.norm(way, axis=1) < 1e-9
    first, last = path.earliest[:, 0], path.latest[:, 1]
    with np.errstate(invalid="ignore"):
        first = first + share * np.where(stay, 0, np.diff(path.earliest)[:, 0])
        last = np.where(stay | np.isinf(last), last, path.latest[:, 0] + share * np.diff(path.latest)[:, 0])
    return bool((near & (first <= time + 0.06) & (time <= last + 0.06)).any())


@given(
    st.sampled_from(SUFFIXES),
    st.integers(0, len(ROUTES) - 1),
    st.sampled_from([0.5, 2.0, 5.0]),
    st.sampled_from(["loiter", "land"]),
    st.sampled_from([12.0, 40.0]),
    st.sampled_from(range(len(LIMITS))),
    st.floats(0, 1),
    st.floats(0.9, 1.1),
    st.floats(0, 1.2),
)
@example("plan", 1, 5.0, "land", 40.0, 0, 1.0, 1.1, 0.0)
@example("plan", 2, 2.0, "loiter", 12.0, 0, 0.0, 0.9, 1.2)
@example("waypoints", 0, 2.0, "loiter", 12.0, 0, 0.0, 0.9, 1.2)
@settings(max_examples=60, deadline=None)
def test_a_replayed_uav_is_nowhere_earlier_or_later_than_counted(
    suffix, route, radius, end, seconds, limits, share, factor, slowness
):
    orders, _, path, tolerance = exported(suffix, route, radius, end, seconds, limits)
    climb = tolerance.slowest_climb + share * (tolerance.fastest_climb - tolerance.slowest_climb)
    track = fly(orders, climb, climb, factor, slowness)
    for k in range(0, len(track), 10):
        assert expected(path, track[k], k * STEP), (k * STEP, track[k])


@pytest.mark.parametrize("route", [0, 1])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_an_autopilot_with_its_usual_rates_takes_off_on_schedule(suffix, route):
    orders, plan, *_ = exported(suffix, route)
    track = fly(orders, plan.rates.takeoff, plan.rates.descent, 1.0, braking=plan.rates.acceleration)
    turned = np.argmax(np.hypot(*(track - plan.waypoints[0])[:, :2].T) > 0.02) * STEP
    faster = 0.0 if suffix != "plan" else max(plan.waypoints[0][2] - 10, 0) * (1 / 1.5 - 1 / 3)  # above 10 m
    assert turned - faster == pytest.approx(plan.arrivals[0], abs=0.5)


@pytest.mark.parametrize(("suffix", "metres"), [("plan", 2.0), ("waypoints", 0.0)])
def test_px4_counts_a_stop_from_when_it_is_within_the_acceptance_radius(suffix, metres):
    _, plan, *_ = exported(suffix, 1)
    mission = handmade.mission([handmade.along(ROUTES[1], 12.0)], clearance=1.0, origin=ORIGIN, terrain=FLAT)
    stop = np.array([80.0, 0.0, 30.0])
    at = np.linalg.norm(plan.route.points - stop, axis=1) < 0.1
    assert at.sum() == 1
    plan = replace(plan, route=replace(plan.route, holds=np.where(at, 7.0, 0.0)))
    path = timed_path(mission.scenario, plan, USUAL_TOLERANCE)
    (k,) = np.flatnonzero((np.linalg.norm(path.starts - stop, axis=1) < 0.1) & (path.starts == path.ends).all(axis=1))
    assert np.linalg.norm(path.ends[k - 1] - stop) < 0.1
    sooner = path.earliest[k - 1, 1] - path.earliest[k, 0]
    assert 0.9 * metres - 1e-9 <= sooner * 1.1 * plan.speeds[0] <= metres + 1e-9
    assert np.diff(path.earliest[k]) == np.diff(path.latest[k]) == pytest.approx(7.0)


@pytest.mark.parametrize(("name", "least"), [("px4", 3.4), ("ardupilot", 2.2), ("dji", 2.4)])
def test_a_take_off_takes_longer_than_its_climb(name, least):
    rates = rates_of(UAV(start=(0, 0, 0)), AUTOPILOTS[name])
    assert takeoff_lag(rates, USUAL_TOLERANCE) == pytest.approx(least + USUAL_TOLERANCE.takeoff)


@pytest.mark.parametrize(("delay", "px4", "ardupilot"), [(0.0, 12, 10), (50.0, 60, 60), (200.0, 210, 0)])
def test_no_autopilot_disarms_while_it_waits_for_its_take_off(tmp_path, delay, px4, ardupilot):
    sides = [handmade.along([(0, y, 10), (200, y, 10)], 30.0, begin) for y, begin in ((0.0, 0.0), (50.0, delay))]
    mission = handmade.mission(sides, clearance=1.0, origin=ORIGIN, terrain=FLAT)
    for suffix, beside, name, seconds in (
        ("plan", "params", "COM_DISARM_PRFLT", px4),
        ("waypoints", "param", "DISARM_DELAY", ardupilot),
    ):
        sky.export(mission, tmp_path / f"m.{suffix}", sky.ExportOptions(altitude="home"))
        rows = (tmp_path / f"m-uav-2.{beside}").read_text().replace(",", "\t").splitlines()
        (row,) = [row.split("\t") for row in rows if name in row]
        value = float(row[row.index(name) + 1])
        assert value >= seconds if seconds else value == 0
        assert value <= seconds + 3 if seconds else value == 0
