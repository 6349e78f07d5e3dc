"""A ceiling above ground and obstacles that are closed above: kept by every planner, proven by the referee."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky

STEP, MAX_HEIGHT = 20.0, 30.0


def hills(**more):
    """A ridge of 60 m between start and target, under a ceiling of 30 m above ground."""
    x = np.linspace(-1.0, 1.0, 21)
    heights = 60.0 * np.exp(-8.0 * x[:, None] ** 2) * np.ones(11) + 4.0 * np.sin(5.0 * np.arange(11.0))
    given = {
        "name": "hills",
        "bounds": sky.Bounds(min=(0, 0, -10), max=(400, 200, 150)),
        "terrain": sky.Terrain(origin=(0, 0), step=(STEP, STEP), heights=heights, clearance=5.0),
        "clearance": 2.0,
        "max_height": MAX_HEIGHT,
        "lattice": sky.Lattice(step=(10, 10, 5), connectivity=26),
        "objective": sky.Objective(unit="metres"),
        "uavs": [sky.UAV(start=(20, 100, 18), max_speed=10)],
        "targets": [sky.Target(position=(380, 100, 18))],
    }
    return sky.Scenario(**(given | more))


def above_ground(scenario, positions):
    return positions[:, 2] - scenario.terrain.height(positions[:, :2])


PLANNERS = {
    "astar": (sky.AStar(), None),
    "theta-star": (sky.ThetaStar(), None),
    "taut": (sky.Taut(), None),
    "mvo": (sky.MVO(universes=6), sky.MaxIterations(5)),
    "hybrid-mvo": (sky.HybridMVO(), sky.MaxIterations(20)),
    "straight": (sky.MFO(legs="straight"), sky.MaxIterations(20)),
}


@pytest.mark.parametrize("name", PLANNERS)
def test_every_planner_and_the_trajectory_stay_below_the_ceiling(name):
    scenario, (planner, stop) = hills(), PLANNERS[name]
    mission = sky.plan_mission(scenario, planner, rng=1, **({} if stop is None else {"stop": stop}))
    found = mission.results[0]
    ways = np.linspace(found.path[:-1], found.path[1:], 200).reshape(-1, 3)
    if found.status.reached:
        assert above_ground(scenario, ways).max() <= MAX_HEIGHT + 1e-6
        flown = mission.trajectories[0]
        positions = flown.at(np.linspace(flown.start, flown.end, 20_001)).position
        assert above_ground(scenario, positions).max() <= MAX_HEIGHT + 1e-6
        assert above_ground(scenario, positions).min() >= 5 - 1e-6
        assert mission.certificates[0].verdict is sky.Verdict.PROVEN
        assert "5 to 30 m above ground" in mission.certificates[0].sentence
    else:
        assert name in ("straight", "mvo")
    assert mission.violations == ()


def test_a_flight_above_the_ceiling_is_refuted_with_the_height_and_the_place():
    free = hills(max_height=None, uavs=[sky.UAV(start=(20, 100, 100))], targets=[sky.Target(position=(380, 100, 100))])
    mission = sky.plan_mission(free, sky.Taut(), rng=1)
    limited = free.model_copy(update={"max_height": 120.0})
    assert sky.Fault.TRAJECTORY_CLEARANCE not in {
        one.fault for one in sky.check(limited, replace(mission, scenario=limited))
    }
    limited = free.model_copy(update={"max_height": 90.0})
    found = [one for one in sky.check(limited, replace(mission, scenario=limited)) if one.time is not None]
    (violation,) = [one for one in found if one.fault is sky.Fault.TRAJECTORY_CLEARANCE]
    height = above_ground(limited, np.array([violation.position]))[0]
    assert f"is {height - 90:.6g} m above the ceiling of 90 m above ground" in violation.message
    flown = mission.trajectories[0]
    heights = above_ground(limited, flown.at(np.linspace(0, flown.end, 20_001)).position)
    assert height >= heights.max() - 1e-6


def test_a_start_above_the_ceiling_is_unsafe_for_that_reason():
    scenario = hills(uavs=[sky.UAV(start=(20, 100, 40))])
    said = sky.World(scenario).why_unsafe((20, 100, 40))
    assert said.endswith("m above ground, above the ceiling of 30 m")
    assert sky.AStar().plan(sky.Problem(scenario)).status is not sky.Status.OPTIMAL


def test_where_the_ceiling_comes_down_to_the_clearance_planning_says_that_there_is_no_room():
    free = hills()
    lowest = free.terrain.heights.copy()
    lowest[10] -= 26.0  # across the whole ridge: 30 m above this is less than 5 m above the ground
    terrain = sky.Terrain.model_validate(free.terrain.model_dump() | {"lowest": lowest})
    cut = hills(terrain=terrain)
    said = sky.World(cut).why_unsafe((200, 100, float(terrain.height((200, 100))) + 4.5))
    assert said.endswith("no height keeps both: the ceiling is 4 m above the ground, and 5 m above it are required")
    assert sky.AStar().plan(sky.Problem(cut)).status is sky.Status.NO_PATH
    assert sky.AStar().plan(sky.Problem(free)).status is sky.Status.OPTIMAL


@pytest.mark.parametrize("seed", range(3))
def test_points_segments_and_lattice_moves_agree_with_samples_below_a_rough_ceiling(seed):
    rng = np.random.default_rng(seed)
    terrain = sky.Terrain(origin=(0, 0), step=(3.0, 4.0), heights=rng.uniform(0, 6, (8, 7)), clearance=1.0)
    scenario = hills(
        bounds=sky.Bounds(min=(0, 0, -1), max=(21, 24, 14)),
        terrain=terrain,
        max_height=5.0,
        clearance=0.25,
        lattice=sky.Lattice(step=(1.5, 1.5, 0.75), connectivity=26),
        uavs=[],
        targets=[],
    )
    world = sky.World(scenario)
    points = rng.uniform((0, 0, -1), (21, 24, 14), (4000, 3))
    heights = above_ground(scenario, points)
    assert (world.free(points) == ((heights >= 1) & (heights <= 5))).all()
    starts, ends = points[:2000], points[2000:]
    free = world.segments_free(starts, ends)
    shares = np.linspace(0, 1, 400)[:, None, None]
    along = starts + shares * (ends - starts)
    sampled = above_ground(scenario, along.reshape(-1, 3)).reshape(400, -1)
    clear = ((sampled >= 1) & (sampled <= 5)).all(axis=0)
    assert not (free & ~clear).any()
    assert (free != clear).sum() <= 2  # what is sampled may miss a graze
    grid = sky.Airspace(scenario).grid
    from skyverse.space.lattice import positions

    nodes = np.arange(len(grid.exits))
    heights = above_ground(scenario, positions(grid, nodes))
    open_nodes = grid.exits > 0
    assert (heights[open_nodes] <= 5 + 1e-9).all()
    assert (heights[open_nodes] >= 1 - 1e-9).all()
    alone = (heights > 1 + 1e-6) & (heights < 5 - 1e-6)
    assert open_nodes[alone].mean() > 0.5
    places = positions(grid, nodes)
    for number, move in enumerate(grid.moves):
        these = np.flatnonzero(grid.exits >> number & 1)
        assert world.segments_free(places[these], places[these] + move * grid.step).all()


CLOSED = {
    "box": sky.Box(min=(9, 0, 0), max=(11, 20, 4), closed_above=True),
    "cylinder": sky.Cylinder(centre=(10, 10), radius=7, low=0, high=4, closed_above=True),
    "sphere": sky.Sphere(centre=(10, 10, 4), radius=7, closed_above=True),
    "prism": sky.Prism(vertices=((9, 0), (11, 0), (11, 20), (9, 20)), low=0, high=4, closed_above=True),
    "voxels": sky.Voxels(origin=(9, 0, 0), step=(1, 1, 1), occupied=np.ones((2, 20, 4)), closed_above=True),
}


@pytest.mark.parametrize("name", CLOSED)
def test_what_is_closed_above_is_not_flown_over_by_players_and_referee_alike(name):
    shape = CLOSED[name]
    scenario = sky.Scenario(
        name="closed",
        bounds=sky.Bounds(min=(0, 0, 0), max=(20, 20, 30)),
        obstacles=[shape],
        clearance=0.25,
        lattice=sky.Lattice(step=(1, 1, 1)),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(start=(0, 10, 20))],
        targets=[sky.Target(position=(20, 10, 20))],
    )
    opened = scenario.model_copy(update={"obstacles": (shape.model_copy(update={"closed_above": False}),)})
    over = sky.plan_mission(opened, sky.Taut(), rng=1)
    assert over.complete
    found = sky.check(scenario, replace(over, scenario=scenario))
    assert sky.Fault.TRAJECTORY_CLEARANCE in {violation.fault for violation in found}
    assert sky.Fault.PATH_CLEARANCE in {violation.fault for violation in found}
    around = sky.plan_mission(scenario, sky.Taut(), rng=1)
    assert around.violations == ()
    positions = around.results[0].path
    if name in ("cylinder", "sphere"):
        assert around.complete
        assert np.hypot(*(positions[1:-1, :2] - 10).T).min() > 7
    else:
        proves = name in ("box", "voxels")
        assert around.results[0].status is (sky.Status.NO_PATH_EXISTS if proves else sky.Status.NO_PATH)
    world = sky.World(scenario)
    rng = np.random.default_rng(1)
    points = rng.uniform((0, 0, 5), (20, 20, 30), (500, 3))
    columns = world.free(points * (1, 1, 0) + (0, 0, 5)) if name != "sphere" else world.free(points)
    assert (world.free(points) == columns).all()
