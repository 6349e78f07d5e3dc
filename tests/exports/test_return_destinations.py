"""Where a UAV returns to is what its autopilot may choose, by the distances that it reckons itself."""

import json
from types import SimpleNamespace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse.exports.return_destinations import destination, may_be_taken
from skyverse.exports.return_sentences import require_returns
from skyverse.exports.way_home import WayHome
from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_wgs84

pytestmark = pytest.mark.usefixtures("unjudged")

ORIGIN = Origin(latitude=47.0, longitude=8.5, altitude=400.0, geoid=48.0)


def px4(at, goals):
    """The destination that PX4 1.15 takes: the first, or one that is 2 m nearer than the last one it took."""
    lat, lon = np.radians(np.vstack([at, goals])).T
    half = np.sin((lat[1:] - lat[0]) / 2) ** 2 + np.cos(lat[0]) * np.cos(lat[1:]) * np.sin((lon[1:] - lon[0]) / 2) ** 2
    away, taken = 2 * 6371000.0 * np.arcsin(np.sqrt(half)), 0
    for k in range(1, len(away)):
        if away[k] + 2.0 < away[taken]:
            taken = k
    return taken


def px4_1_14(at, goals):
    """That of PX4 1.14: the nearest, with degrees of longitude as long as they are where the UAV is."""
    return int(np.argmin(np.hypot(*((goals - at) * [1.0, np.cos(np.radians(at[0]))]).T)))


def ardupilot(at, goals):
    """That of ArduPilot: the nearest on a flat Earth, by the latitude half-way."""
    middle = np.cos(np.radians((goals[:, 0] + at[0]) / 2))
    away = np.hypot(*((goals - at) * 111318.84502145034 * np.column_stack([np.ones(len(goals)), middle])).T)
    return int(np.argmin(away.astype(np.float32)))


AUTOPILOTS = [("px4", px4), ("px4", px4_1_14), ("ardupilot", ardupilot)]


@pytest.mark.parametrize(("name", "choose"), AUTOPILOTS)
def test_what_autopilots_choose_is_among_the_destinations_that_may_be_taken(name, choose):
    """Two destinations about equally near, in any direction: by which of them the nearest is not always told."""
    rng, odd = np.random.default_rng(5), 0
    for latitude in (0.0, 47.0, -70.0):
        origin = ORIGIN.model_copy(update={"latitude": latitude})
        mission = handmade.mission([handmade.along([(0, 0, 10), (9, 0, 10)], 9)], origin=origin)
        for _ in range(300):
            far, more = 10 ** rng.uniform(1, 4.3), rng.normal(0, 3)
            angles = rng.uniform(0, 2 * np.pi, 2)
            way = np.column_stack([np.cos(angles), np.sin(angles)]) * [[far], [max(far + more, 0.0)]]
            at = np.r_[rng.uniform(-20_000, 20_000, 2), 10.0]
            goals = at + np.column_stack([way, np.zeros(2)])
            off = rng.uniform(0, 2)
            turn = rng.uniform(0, 2 * np.pi)
            flown = at + off * np.array([np.cos(turn), np.sin(turn), 0.0])
            taken = choose(to_wgs84(origin, flown[None])[0, :2], to_wgs84(origin, goals)[:, :2])
            away = np.linalg.norm((goals - at)[None, :, :2], axis=2)
            autopilot = SimpleNamespace(name=name)
            assert may_be_taken(mission.scenario, autopilot, away, np.array([off]))[0, taken]
            odd += taken != np.argmin(away)
    assert odd > 20


def test_far_from_both_only_the_nearest_may_be_taken():
    mission = handmade.mission([handmade.along([(0, 0, 10), (9, 0, 10)], 9)], origin=ORIGIN)
    for name in ("px4", "ardupilot"):
        taken = may_be_taken(mission.scenario, SimpleNamespace(name=name), np.array([[300.0, 280.0]]), np.array([1.0]))
        assert taken.tolist() == [[False, True]]


def exported(mission, folder, suffix="plan", **how):
    seen = []
    sky.export(mission, folder / f"m.{suffix}", on_certificate=seen.append, **how)
    return seen[0].returns[0]


def with_rally_point(back, place, altitude):
    """The same flight with one rally point."""
    goal = destination(back.way.scenario, back.way.space, back.plan, np.array(place), place[2] + 1.0)
    home, end = back.way.destinations[0], back.way.end
    return WayHome(back.way.scenario, back.way.space, back.plan, [home, goal], end, altitude)


def test_the_way_home_that_px4_prefers_is_judged_where_a_rally_point_is_a_little_nearer(tmp_path):
    """From x = 20 m on the rally point is nearer. A metre farther on PX4 still flies home, into the wall."""
    wall = ((19.5, -300, -50), (20.2, 48, 150))
    flight = handmade.along([(0, 0, 10), (0, 50, 10), (40, 50, 10), (40, 0, 10)], 10)
    back = exported(handmade.mission([flight], boxes=[wall], clearance=1.0, origin=ORIGIN), tmp_path)
    way = with_rally_point(back, (40.0, 0.0, 9.0), 5.0)
    lost = way.search().lost
    x = way.legs.places(lost, lost.begin, np.zeros(len(lost.leg)))[:, 0]
    end = way.legs.places(lost, lost.end, np.zeros(len(lost.leg)))[:, 0]
    across = lost.leg == 1
    goals = np.array([[0.0, 0.0, 10.0], [40.0, 0.0, 10.0]])
    seen = 0
    for at in np.linspace(15, 25, 101):
        place = np.array([at, 50.0, 10.0])
        taken = px4(to_wgs84(ORIGIN, place[None])[0, :2], to_wgs84(ORIGIN, goals)[:, :2])
        line = place + np.linspace(0, 1, 2000)[:, None] * (goals[taken] - place)
        inside = ((line > np.array(wall[0]) - 0.5) & (line < np.array(wall[1]) + 0.5)).all(axis=1)
        if inside.any():
            seen += taken == 0 and at > 20
            assert ((x <= at) & (at <= end))[across].any(), at
    assert seen > 5


@pytest.mark.parametrize(("suffix", "how"), [("waypoints", {}), ("plan", {"autopilot": "ardupilot"})])
def test_rally_points_for_ardupilot_are_in_whole_metres_at_which_the_return_is_proven(tmp_path, suffix, how):
    """It keeps no more of their altitude, and returns at that."""
    corners = [(0, 0, 10.37), (0, 250, 10.37), (60, 250, 24.61), (60, 0, 24.61)]
    wall = ((30, -300, -50), (31, 200, 150))
    mission = handmade.mission([handmade.along(corners, 10)], boxes=[wall], clearance=1.0, origin=ORIGIN)
    back = exported(mission, tmp_path, suffix, **how)
    assert len(back.lost) == 0
    assert len(back.rally) > 0
    if suffix == "plan":
        rows = json.loads((tmp_path / "m.plan").read_text())["rallyPoints"]["points"]
    else:
        rows = [list(map(float, row.split("\t")[1:4])) for row in (tmp_path / "m.ral").read_text().splitlines()]
    kept = [float(int(altitude)) for _, _, altitude in rows]  # an int16 on board
    assert [altitude for _, _, altitude in rows] == kept
    places = handmade.local(ORIGIN, *(np.array(rows).T[:2]), np.array(kept) + 400.0 + back.plan.home[2])
    np.testing.assert_allclose(
        np.maximum(places[:, 2], back.plan.home[2] + back.altitude), back.way.levels[1:], atol=0.02
    )


def test_a_return_at_the_end_to_one_of_two_places_about_equally_near_is_refused(tmp_path):
    flight = handmade.along([(0, 0, 10), (100, 0, 10)], 20)
    back = exported(handmade.mission([flight], origin=ORIGIN), tmp_path)
    require_returns(back.way.scenario, [(0, back)])
    both = back.__class__(**{**vars(back), "landings": np.array([[0.0, 0.0, 10.0], [199.0, 0.0, 10.0]])})
    with pytest.raises(sky.InputError, match="uav-1: from the end, home and rally points are about equally near"):
        require_returns(back.way.scenario, [(0, both)])
