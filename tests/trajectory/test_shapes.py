"""Corridors, proofs and flights among all shapes and over the ground: against closed forms, judged by the referee."""

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

import skyverse as sky
from handmade import hall
from skyverse.numerics.tolerances import MIN_OVERLAP
from skyverse.trajectory import prove, rest_to_rest
from skyverse.trajectory.corridor import grow_corridor, inset_path

RIDGE = sky.Terrain(
    origin=(0, 0),
    step=(20, 60),
    heights=np.array([[0.0, 0], [0, 0], [16, 10], [2, 4], [0, 0], [0, 0]]),
    clearance=2.0,
)


def block(x, y, half, angle, high):
    """A square building, turned."""
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)]) @ turn + (x, y)
    return sky.Prism(vertices=tuple(map(tuple, corners.tolist())), low=0, high=high)


TURNED = (block(30, 28, 9, 0.4, 40), block(52, 38, 6, 1.1, 40), block(72, 24, 8, 0.2, 40))


def fly(*obstacles, ways=(((5, 30, 5), (95, 30, 5)),), terrain=None, size=(100, 60, 40), **more):
    vehicles = [sky.UAV(start=start, **more) for start, _ in ways]
    ends = [end for _, end in ways]
    return hall(size, vehicles, ends, step=5, obstacles=obstacles, terrain=terrain, clearance=1.0)


def planned(scenario):
    """Plan a mission; the referee must find nothing wrong, and prove everything."""
    mission = sky.plan_mission(scenario, sky.Taut(), rng=1, assignment="identity")
    assert mission.violations == ()
    assert all(c is None or c.verdict is sky.Verdict.PROVEN for c in mission.certificates)
    assert mission.complete
    return mission


SCENES = {
    "turned buildings": fly(*TURNED),
    "a ridge": fly(terrain=RIDGE),
    "a pillar": fly(sky.Cylinder(centre=(50, 30), radius=12, low=0, high=40)),
    "a dome on a slope": fly(sky.Sphere(centre=(60, 30, 8), radius=10), terrain=RIDGE),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("room", [0.5, 2.0])
def test_a_corridor_is_free_and_joined_along_the_path(name, room):
    scenario = SCENES[name]
    problem = sky.Problem(scenario)
    world = problem.airspace.world
    path = sky.Taut().plan(problem).path
    path = inset_path(world, path, room)
    boxes = grow_corridor(world.space, path, 10.0, math.inf)
    assert len(boxes)
    low, high = boxes[:, :3], boxes[:, 3:]
    assert (np.minimum(high[:-1], high[1:]) - np.maximum(low[:-1], low[1:]) >= MIN_OVERLAP).all()
    shares = np.random.default_rng(0).random((4000, 3))
    shares[:2000] = np.round(shares[:2000])  # corners
    for k in range(len(boxes)):
        points = low[k] + shares * (high - low)[k]
        for obstacle in scenario.obstacles:
            assert (distance(obstacle, points) >= scenario.clearance - 6e-7).all()
        if scenario.terrain is not None:
            assert (points[:, 2] >= ground(scenario.terrain, points[:, :2]) + 2.0 - 6e-7).all()
    for a, b in itertools.pairwise(path):
        for p in a + np.linspace(0, 1, 101)[:, None] * (b - a):
            assert np.any(np.all((p >= low - 1e-6) & (p <= high + 1e-6), axis=1))


def distance(obstacle, points):
    """Metres to a sphere, or on the map to what reaches as high as the bounds."""
    if isinstance(obstacle, sky.Sphere):
        return np.linalg.norm(points - obstacle.centre, axis=1) - obstacle.radius
    if isinstance(obstacle, sky.Cylinder):
        return np.linalg.norm(points[:, :2] - obstacle.centre, axis=1) - obstacle.radius
    nearest, inside = np.full(len(points), np.inf), np.ones(len(points), bool)
    vertices = np.array(obstacle.vertices)
    for a, b in zip(vertices, np.roll(vertices, -1, axis=0), strict=True):  # counter-clockwise, convex
        off, edge = points[:, :2] - a, b - a
        share = np.clip(off @ edge / (edge @ edge), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(off - share[:, None] * edge, axis=1))
        inside &= edge[0] * off[:, 1] - edge[1] * off[:, 0] > 0
    return np.where(inside, -nearest, nearest)


def ground(terrain, at):
    """The ground's height by scipy."""
    heights = np.asarray(terrain.heights)
    axes = [o + d * np.arange(n) for o, d, n in zip(terrain.origin, terrain.step, heights.shape, strict=True)]
    clipped = np.clip(at, [a[0] for a in axes], [a[-1] for a in axes])
    return RegularGridInterpolator(axes, heights)(clipped)


@pytest.mark.parametrize("name", SCENES)
def test_the_referee_finds_nothing_wrong_with_a_flight(name):
    (flown,) = planned(SCENES[name]).trajectories
    assert flown.form in ("blended", "smooth")
    assert flown.note == ""


# a flight along x at y = 30, z = 5 is as near as it may be: 1 m, or 2 m above ground; and which way they are
TOUCHED = {
    "a cylinder": (sky.Cylinder(centre=(50, 38), radius=7, low=0, high=40), (0, 1, 0)),
    "a cylinder's top": (sky.Cylinder(centre=(50, 30), radius=7, low=0, high=4), (0, 0, -1)),
    "a sphere": (sky.Sphere(centre=(50, 33, 9), radius=4), (0, 3 / 5, 4 / 5)),
    "a turned building": (
        sky.Prism(vertices=((50, 31), (58, 39), (50, 47), (42, 39)), low=0, high=40),
        (0, 1, 0),
    ),
    "a wall ahead": (
        sky.Prism(vertices=((100, 0), (100, 60), (98, 60), (98, 0)), low=0, high=40),
        (1, 0, 0),
    ),
    "the ground": (
        sky.Terrain(origin=(0, 0), step=(50, 60), heights=np.array([[0.0, 0], [3, 3], [0, 0]]), clearance=2.0),
        (0, 0, -1),
    ),
}


@pytest.mark.parametrize("name", TOUCHED)
def test_a_flight_that_touches_is_proven_and_one_a_micrometre_nearer_is_not(name):
    shape, towards = TOUCHED[name]
    terrain = shape if isinstance(shape, sky.Terrain) else None
    x = 97 if towards[0] else 95
    scenario = fly(*(() if terrain else (shape,)), terrain=terrain, ways=[((5, 30, 5), (x, 30, 5))], max_speed=8.0)
    world, uav = sky.World(scenario), scenario.uavs[0]
    along = rest_to_rest(np.array([(5.0, 30, 5), (x, 30, 5)]), uav)
    for metres, verdict in ((-1e-6, sky.Verdict.PROVEN), (0.0, sky.Verdict.PROVEN), (2e-6, sky.Verdict.REFUTED)):
        rows = along.coefficients.copy()
        rows[:, 0] += metres * np.array(towards)
        assert prove(world, uav, sky.Trajectory(along.knots, rows, along.form)).verdict is verdict


def test_an_aeroplane_flies_around_a_pillar_and_over_a_ridge():
    heights = np.array([[0.0, 0], [0, 0], [0, 0], [30, 30], [0, 0], [0, 0]])
    ridge = sky.Terrain(origin=(0, 0), step=(160, 400), heights=heights, clearance=10.0)
    wing = sky.FixedWing(speed=15.0, turn_radius=40.0, climb=15.0)
    scenario = fly(
        sky.Cylinder(centre=(200, 200), radius=50, low=0, high=120),
        terrain=ridge,
        ways=[((40, 200, 20), (760, 200, 20))],
        size=(800, 400, 120),
        fixed_wing=wing,
        max_speed=16.0,
        max_acceleration=8.0,
    ).model_copy(update={"lattice": sky.Lattice(step=(40, 40, 20), connectivity=26)})
    (flown,) = planned(scenario).trajectories
    assert flown.form == "dubins"
    assert flown.at(np.linspace(0, flown.end, 500)).position[:, 2].max() > 40 - 1e-6


def test_one_that_hovers_in_an_alley_between_turned_buildings_makes_way_or_is_flown_around():
    alley = (block(50, 8, 14, 0.3, 40), block(50, 52, 12, 0.5, 40))
    ways = [((5, 30, 10), (95, 30, 10)), ((50, 30, 10), (50, 30, 10))]
    mission = planned(fly(*alley, ways=ways))
    kinds = {action.kind for action in mission.deconfliction.actions}
    assert kinds
    assert kinds <= {"detour", "wait"}
