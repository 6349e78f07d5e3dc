"""ArduPilot's files with altitudes above ground, read back and flown over random grounds that may be below."""

from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest
from test_terrain_following import ALLOWANCE, EXACT, GNSS, ORIGIN, rough

import skyverse as sky
import terrain_follower as follower

pytest.importorskip("pyproj", reason="an independent geodesy")
pytestmark = pytest.mark.usefixtures("unjudged")
STEPS, WAYS = 300, 6


def planned(seed, error):
    """A mission among houses over rough ground that keeps more above ground than its scenario asks for."""
    rng = np.random.default_rng(seed)
    terrain, boxes = rough(rng, float(rng.choice([0.0, 1.5]))), []
    while len(boxes) < 15:
        middle, half = rng.uniform(-120, 120, 2), rng.uniform(3, 15, 2)
        if np.abs(middle).min() > half.max():
            base = float(terrain.height(middle))
            boxes.append(sky.Box(min=(*(middle - half), base - 60), max=(*(middle + half), base + rng.uniform(10, 60))))
    ends = [(-150.0, rng.uniform(-60, 60)), (150.0, rng.uniform(-60, 60))]
    start, target = ((*place, float(terrain.height(np.array(place))) + 12.0) for place in ends)
    higher = terrain.model_copy(update={"clearance": 5.0})
    scenario = sky.Scenario(
        name="rough",
        bounds=sky.Bounds(min=(-200, -200, -200), max=(200, 200, 300)),
        clearance=1.0,
        terrain=higher,
        obstacles=boxes,
        max_height=45.0,
        lattice=sky.Lattice(step=(20, 20, 20)),
        uavs=[{"start": start, "tracking_error": error}],
        targets=[{"position": target}],
        frame=sky.Frame(origin=ORIGIN),
    )
    mission = sky.plan_mission(scenario, sky.Taut())
    return replace(mission, scenario=scenario.model_copy(update={"terrain": terrain, "max_height": 50.0})), rng


def read(scenario, file):
    """Places with heights above ground, (n, 3), the start first; the acceptance radius; and where the UAV stops."""
    rows = [line.split("\t") for line in file.read_text().splitlines()[1:]]
    orders = [row for row in rows[1:] if row[3] in ("16", "22")]
    assert {row[2] for row in orders} == {"10"}  # MAV_FRAME_GLOBAL_TERRAIN_ALT
    latitude, longitude, height = (np.array([float(row[k]) for row in orders]) for k in (8, 9, 10))
    sea = np.full(len(orders), ORIGIN.altitude + 20.0)
    points = np.column_stack([handmade.local(ORIGIN, latitude, longitude, sea)[:, :2], height])
    start = follower.heights_above(scenario.terrain, [scenario.uavs[0].start])
    (radius,) = {float(row[5]) for row in orders if row[3] == "16" and float(row[4]) == 0} or {0.0}
    stops = [0.0, *(float(row[3] == "16" and float(row[4]) > 0) for row in orders)]
    return np.concatenate([start, points]), radius, np.array(stops)


def assert_clear_as_replayed(tmp_path, seed, error):
    mission, rng = planned(seed, error)
    if mission.trajectories[0] is None:
        return "no path"
    try:
        (file,) = (
            f
            for f in sky.export(mission, tmp_path / "m.waypoints", sky.ExportOptions(altitude="agl"))
            if f.suffix == ".waypoints"
        )
    except sky.InputError as refused:
        assert "straight legs" in str(refused)  # noqa: PT017
        return "refused"
    above, radius, stops = read(mission.scenario, file)
    nominal = follower.ways(above, radius, stops, rng, STEPS, WAYS)[(WAYS + 1) * STEPS :]  # after the first climb
    if np.hypot(*(above[-1] - above[-2])[:2]) < 0.1:
        nominal = nominal[: -(WAYS + 1) * STEPS]  # it descends in a column
    for _ in range(6):
        points = follower.flown(mission.scenario, nominal, error, rng)
        obstacle, ground, ceiling = follower.rooms(mission.scenario, points)
        assert obstacle >= -ALLOWANCE
        assert ground >= -ALLOWANCE
        assert ceiling >= 0
    return "clear"


@pytest.mark.parametrize("error", [EXACT, GNSS], ids=["exact", "strays"])
def test_files_for_ardupilot_are_clear_as_replayed_over_every_ground(tmp_path, error):
    said = [assert_clear_as_replayed(tmp_path, seed, error) for seed in range(6)]
    assert said.count("clear") >= 3


@pytest.mark.parametrize("error", [EXACT, GNSS], ids=["exact", "strays"])
@pytest.mark.parametrize("first", [100])
def test_many_more_files_for_ardupilot_are_clear_as_replayed(tmp_path, first, error):
    said = [assert_clear_as_replayed(tmp_path, seed, error) for seed in range(first, first + 20)]
    assert said.count("clear") >= 8
