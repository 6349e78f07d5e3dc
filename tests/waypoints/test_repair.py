"""Missions are mended: proven afterwards, little longer than must be, and otherwise as they were."""

import json
import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize

import skyverse as sky
from skyverse.waypoints.taut_line import taut_line, with_fewer_bends
from written_missions import NAN, item, plan

ORIGIN = sky.Origin(latitude=47.0, longitude=8.0, altitude=400.0)
TOWER = sky.Box(min=(140, -20, 0), max=(160, 20, 90), kind="building", name="tower")
WALL = sky.Box(min=(140, -200, 0), max=(160, 200, 45), kind="building", name="wall")


def ridge(top):
    x = np.arange(-100, 501, 10.0)
    heights = np.repeat(top * np.exp(-(((x - 150) / 40) ** 2))[:, None], 61, axis=1)
    return sky.Terrain(origin=(-100, -300), step=(10, 10), heights=heights, clearance=2.0)


def scenario(*obstacles, terrain=None, **more):
    return sky.Scenario(
        name="field",
        bounds=sky.Bounds(min=(-100, -300, 0), max=(500, 300, 200)),
        obstacles=obstacles,
        terrain=ridge(0.0) if terrain is None else terrain,
        clearance=2.0,
        objective={"unit": "metres"},
        uavs=({"start": (0, 0, 1), "home": 0.0, "vehicle": "camera"},),
        frame={"origin": ORIGIN},
        **more,
    )


def place(x, y):
    return sky.to_wgs84(ORIGIN, [[x, y, 0.0]])[0, :2].tolist()


def flight(tmp_path, points, *, radius=0.0, name="m.plan", end=(20, 0, 0, 0, 0, 0, 0, 0), firmware=12):
    items = [item(22, 0, 0, 0, NAN, *place(0, 0), points[0][2], number=1)]
    for x, y, z in points:
        items.append(item(206, 12, 0, 1, 0, 0, 0, 0, frame=2, number=len(items) + 1))
        items.append(item(16, 0, radius, 0, NAN, *place(x, y), z, number=len(items) + 1))
    items.append(item(*end, frame=2, number=len(items) + 1))
    path = tmp_path / name
    path.write_text(plan(items, firmware=firmware), encoding="utf-8")
    return path


def mended(path, world, *, settings=None, **more):
    """Return a mission mended, judged anew from its file, and the items of both files."""
    fixed = path.with_name(f"fixed-{path.name}")
    made = sky.repair_waypoints([sky.read_waypoints(path)], world, settings, **more)
    sky.write_waypoints(made.missions[0], fixed)
    new = made.missions[0]  # the autopilot's parameters hold how it returns, not its mission
    settings = sky.FlightSettings(return_altitude=new.return_altitude, retraces=new.retraces)
    (found,) = sky.check_waypoints([sky.read_waypoints(fixed)], world, settings).missions
    return made, found, *(json.loads(one.read_text())["mission"]["items"] for one in (path, fixed))


def without_numbers(items):
    return [{key: value for key, value in one.items() if key != "doJumpId"} for one in items]


@pytest.mark.parametrize(
    "world",
    [scenario(TOWER), scenario(WALL), scenario(terrain=ridge(60.0)), scenario(terrain=ridge(60.0), max_height=80.0)],
    ids=["around a tower", "over a wall", "over a ridge", "over a ridge, below a ceiling"],
)
def test_a_leg_is_led_around_or_over_what_it_meets_and_all_else_stays(tmp_path, world):
    path = flight(tmp_path, [(0, 50, 30), (300, -10, 30), (300, 60, 30)])
    (before,) = sky.check_waypoints([sky.read_waypoints(path)], world).missions
    assert {one.items for one in before.findings if one.wrong and one.part is not None} == {(3, 5)}
    made, found, old, new = mended(path, world, settings=sky.FlightSettings(return_altitude=100))
    assert found.is_proven, found.findings
    assert [one.items for one in made.changes[0]] == [(3, 5)]
    kept = without_numbers(new)
    for one in without_numbers(old):
        kept.remove(one)  # each item of old is there, word for word
    assert {one["command"] for one in kept} == {16}


def test_the_way_that_is_led_is_as_short_as_a_planner_finds_it(tmp_path):
    world = scenario(TOWER)
    path = flight(tmp_path, [(0, 50, 30), (300, -10, 30)])
    _, found, *_ = mended(path, world)
    places = [visit.at for visit in found.flown.visits]
    (uav,) = world.uavs
    best = sky.Auto().plan(
        sky.Problem(
            world.model_copy(
                update={
                    "uavs": (uav.model_copy(update={"start": tuple(places[1]), "home": None}),),
                    "targets": (sky.Target(name="end", position=tuple(places[-1])),),
                }
            )
        )
    )
    flown = sum(math.dist(a, b) for a, b in pairwise(places[1:]))
    shortest = sum(math.dist(a, b) for a, b in pairwise(best.path))
    assert shortest - 1e-6 <= flown <= 1.02 * shortest


def test_a_place_in_the_ground_is_lifted_and_one_in_a_tower_moved_aside(tmp_path):
    _, found, old, new = mended(
        flight(tmp_path, [(0, 50, 30), (150, 100, 30), (300, 50, 50)]), scenario(terrain=ridge(60.0))
    )
    (was,), (now,) = (
        [one["params"][4:] for one in items if one["params"][4:6] == place(150, 100)] for items in (old, new)
    )
    assert found.is_proven, found.findings
    assert was[2] == 30
    assert 62 < now[2] < 75
    made, found, *_ = mended(flight(tmp_path, [(0, 50, 30), (150, 15, 30), (300, 50, 30)]), scenario(TOWER))
    assert found.is_proven, found.findings
    assert next(one.items for one in made.changes[0]) == (5,)
    (moved,) = (visit.at for visit in found.flown.visits if visit.order.item == 4)
    assert moved[2] == pytest.approx(30, abs=0.02)
    assert 20 + 2 < moved[1] < 20 + 9


def test_lift_only_changes_nothing_but_heights(tmp_path):
    path = flight(tmp_path, [(0, 50, 30), (120, 100, 40), (300, 50, 50)])
    made, found, old, new = mended(path, scenario(terrain=ridge(50.0)), lift_only=True)
    assert found.is_proven, found.findings
    assert made.changes[0]
    assert len(old) == len(new)
    for was, now in zip(old, new, strict=True):
        assert was["params"][:6] == now["params"][:6]
        assert {**was, "params": 0} == {**now, "params": 0}


def test_a_corner_that_is_cut_too_widely_is_cut_less(tmp_path):
    corner = sky.Box(min=(100, 0, 0), max=(140, 92, 60), kind="building")
    path = flight(tmp_path, [(90, 30, 30), (90, 105, 30), (200, 105, 30)], radius=40)
    _, found, old, new = mended(path, scenario(corner), settings=sky.FlightSettings(return_altitude=90))
    assert found.is_proven, found.findings
    radii = [[one["params"][1] for one in items if one["command"] == 16] for items in (old, new)]
    assert radii[0] == [40, 40, 40]
    assert radii[1][1] < 40
    assert len(old) == len(new)


def crossing(tmp_path):
    first = flight(tmp_path, [(0, 0, 30), (200, 0, 30)], name="a.plan")
    second = flight(tmp_path, [(100, -100, 30), (100, 100, 30)], name="b.plan")
    items = json.loads(second.read_text())
    items["mission"]["plannedHomePosition"][:2] = items["mission"]["items"][0]["params"][4:6] = place(100, -100)
    second.write_text(json.dumps(items))
    return [sky.read_waypoints(one) for one in (first, second)]


def test_of_two_that_come_too_close_one_starts_later(tmp_path):
    world, read = scenario(), crossing(tmp_path)
    before = sky.check_waypoints(read, world)
    assert [[one.subject.value for one in mission.findings] for mission in before.missions] == [["separation"]] * 2
    made = sky.repair_waypoints(read, world)
    assert made.checked.is_proven, [one.findings for one in made.checked.missions]
    assert made.missions[1].orders[0].name == "NAV_DELAY"
    assert made.changes[0] == ()


def test_where_only_heights_may_change_the_later_of_two_flies_higher(tmp_path):
    world, read = scenario(), crossing(tmp_path)
    made = sky.repair_waypoints(read, world, lift_only=True)
    assert made.checked.is_proven, [one.findings for one in made.checked.missions]
    assert made.changes[0] == ()
    old, new = ([one for one in mission.orders if one.place] for mission in (read[1], made.missions[1]))
    assert [one.place[:2] for one in new[1:]] == [one.place[:2] for one in old[1:]]
    assert all(b.place[2].metres > a.place[2].metres for a, b in zip(old, new, strict=True))


def without_takeoff(tmp_path, points, firmware=12):
    path = flight(tmp_path, points, firmware=firmware)
    told = json.loads(path.read_text())
    told["mission"]["items"] = [one for one in told["mission"]["items"] if one["command"] != 22]
    path.write_text(json.dumps(told))
    return path


@pytest.mark.parametrize("firmware", [3, 12])
@pytest.mark.parametrize("low", [-20.0, 1.0, 30.0], ids=["in the ground", "near it", "in a tower"])
def test_without_a_takeoff_each_place_is_moved_the_first_as_well(tmp_path, firmware, low):
    world = scenario(TOWER) if low == 30 else scenario()
    path = without_takeoff(tmp_path, [(150, 10, low), (250, 60, 30)], firmware)
    made, found, *_ = mended(path, world)
    assert found.is_proven, found.findings
    assert len([one for one in made.changes[0] if "moved" in one.said]) == 1


def test_a_place_that_is_moved_says_from_where_to_where_and_off_what(tmp_path):
    fence = sky.Box(min=(-50, 100, 0), max=(100, 120, 200), kind="fence", name="fence")
    world = scenario(fence, max_height=120.0)
    made, *_ = mended(flight(tmp_path, [(0, 50, 30), (150, 160, 180), (300, 50, 30)]), world)
    said = [one.said for one in made.changes[0] if "moved" in one.said]
    assert len(said) == 1
    assert said[0].endswith("off the ceiling")
    made, *_ = mended(flight(tmp_path, [(0, 50, 30), (150, 15, 30), (300, 50, 30)]), scenario(TOWER))
    (said,) = (one.said for one in made.changes[0] if "moved" in one.said)
    (new,) = (one.place for one in made.missions[0].orders if one.item == 4)
    for latitude, longitude in (place(150, 15), new[:2]):
        assert f"{latitude:.6f}, {longitude:.6f}" in said


def test_what_cannot_be_mended_is_told_and_nothing_is_lost(tmp_path):
    closed = scenario(sky.Box(min=(140, -300, 0), max=(160, 300, 200), kind="building"))
    made, found, old, new = mended(flight(tmp_path, [(0, 50, 30), (300, 0, 30)]), closed)
    assert not found.is_proven
    assert made.checked.missions[0].findings[0].items == (3, 5)
    assert old == new


@pytest.mark.parametrize("seed", range(40))
def test_the_taut_line_is_the_shortest_in_its_corridor(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 30))
    along, middle = np.cumsum(rng.uniform(0.5, 2, count)), np.cumsum(rng.normal(0, 2, count))
    low, high = middle - rng.uniform(0.05, 4, count), middle + rng.uniform(0.05, 4, count)
    begin, end = rng.uniform(low[[0, -1]], high[[0, -1]]).tolist()
    line = taut_line(along, low, high, begin, end)
    heights = np.interp(along, *np.transpose(line))
    assert (heights >= low - 1e-9).all()
    assert (heights <= high + 1e-9).all()

    def length(inner):
        return float(np.hypot(np.diff(along), np.diff(np.r_[begin, inner, end])).sum())

    best = minimize(
        length, middle[1:-1], bounds=list(zip(low[1:-1], high[1:-1], strict=True)), method="L-BFGS-B",
        options={"maxiter": 5000, "ftol": 1e-14},
    )  # fmt: skip
    flown = sum(math.dist(a, b) for a, b in pairwise(line))
    assert flown <= best.fun + 1e-5
    fewer = with_fewer_bends(line, along, high, 0.01 * flown)
    assert len(fewer) <= len(line)
    assert sum(math.dist(a, b) for a, b in pairwise(fewer)) <= 1.01 * flown + 1e-9
    heights = np.interp(along, *np.transpose(fewer))
    assert (heights >= low - 1e-9).all()
    assert (heights <= high + 1e-9).all()
