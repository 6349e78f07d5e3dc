"""Every planner among every shape and over the ground, judged by the referee; Taut against closed forms."""

import importlib.util
import math

import numpy as np
import pytest

import skyverse as sky


def valley(clearance=1.0):
    """A ridge across, 12 m high, with a hill on it."""
    x, y = np.meshgrid(np.arange(0.0, 61.0, 4.0), np.arange(0.0, 41.0, 4.0), indexing="ij")
    heights = np.maximum(0.0, 12.0 - 1.2 * np.abs(x - 30.0)) + 4.0 * np.exp(-((x - 30.0) ** 2 + (y - 20.0) ** 2) / 60.0)
    return sky.Terrain(origin=(0, 0), step=(4, 4), heights=heights, clearance=clearance)


def everything(**changes):
    """A world with each of the shapes in the way."""
    occupied = np.zeros((3, 2, 6), bool)
    occupied[:, :, :4] = True
    obstacles = (
        sky.Prism(vertices=((12, 14), (18, 11), (21, 22), (15, 25)), low=0, high=16, kind="building"),
        sky.Cylinder(centre=(44, 22), radius=4, low=0, high=30),
        sky.Sphere(centre=(30, 12, 18), radius=3),
        sky.Box(min=(46, 30, 0), max=(50, 34, 20)),
        sky.Voxels(origin=(8, 28, 0), step=(2, 2, 2), occupied=occupied),
        sky.Prism(
            vertices=((22, 26), (28, 26), (28, 34), (22, 34)),
            holes=(((24, 28), (26, 28), (26, 32), (24, 32)),),
            low=0,
            high=18,
        ),
    )
    given = {
        "name": "everything",
        "bounds": sky.Bounds(min=(0, 0, 0), max=(60, 40, 30)),
        "obstacles": obstacles,
        "terrain": valley(),
        "clearance": 0.5,
        "lattice": sky.Lattice(step=(2, 2, 2), connectivity=26),
        "objective": sky.Objective(unit="metres"),
        "uavs": (sky.UAV(start=(4, 18, 3)),),
        "targets": (sky.Target(position=(56, 22, 3)),),
    }
    return sky.Scenario(**{**given, **changes})


METHODS = [
    sky.AStar(),
    sky.ThetaStar(),
    sky.Taut(),
    sky.Cheapest(legs=20_000),
    sky.MVO(universes=8),
    sky.GSO(glowworms=8),
    sky.BBO(habitats=8),
    sky.RandomRestart(samples=8),
    sky.HybridMVO(universes=8),
    *(
        method(waypoints=3, candidates=8, legs="straight")
        for method in (sky.CMAES, sky.LSHADE)
        if not method.library or importlib.util.find_spec(method.library)
    ),
]


@pytest.mark.parametrize("planner", METHODS, ids=repr)
def test_what_any_planner_finds_among_all_shapes_the_referee_finds_safe(planner):
    scenario = everything()
    problem = sky.Problem(scenario)
    result = planner.plan(problem, stop=sky.MaxIterations(6), rng=1)
    assert sky.check_result(scenario, 0, 0, result) == []
    assert len(result.path) > 2
    if isinstance(planner, sky.AStar | sky.ThetaStar | sky.Taut | sky.HybridMVO):
        assert result.status.reached
        assert result.cost >= result.bound
    assert result.cost >= 0.9995 * sky.Taut().plan(problem).cost


def alone(*obstacles, start, target, high=(20, 20, 10), clearance=0.001, step=1.0, terrain=None):
    return sky.Scenario(
        name="alone",
        bounds=sky.Bounds(min=(-20, -20, 0), max=high),
        obstacles=obstacles,
        terrain=terrain,
        clearance=clearance,
        lattice=sky.Lattice(step=(step, step, step), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=start),),
        targets=(sky.Target(position=target),),
    )


def taut(scenario):
    result = sky.Taut().plan(sky.Problem(scenario))
    assert sky.check_result(scenario, 0, 0, result) == []
    return result


def wrapped(start, target, centre, radius):
    """The length of tangent, arc and tangent around a circle, or a sphere."""
    a, b = np.subtract(start, centre), np.subtract(target, centre)
    u, v = np.linalg.norm(a), np.linalg.norm(b)
    arc = math.acos(np.clip(a @ b / (u * v), -1, 1)) - math.acos(radius / u) - math.acos(radius / v)
    return math.sqrt(u**2 - radius**2) + math.sqrt(v**2 - radius**2) + radius * arc


@pytest.mark.parametrize("clearance", [0.001, 0.7])
def test_around_a_cylinder_it_is_tangent_arc_and_tangent(clearance):
    pillar = sky.Cylinder(centre=(1, 0), radius=4, low=-1, high=11)
    result = taut(alone(pillar, start=(-9, -1, 3), target=(11, 2, 6), clearance=clearance))
    flat = wrapped((-9, -1), (11, 2), (1, 0), 4 + clearance)
    assert result.cost == pytest.approx(math.hypot(flat, 3), rel=3e-4)
    assert result.cost >= math.hypot(flat, 3)
    assert len(result.path) < 25


def test_over_or_beside_a_sphere_it_is_tangent_arc_and_tangent():
    ball = sky.Sphere(centre=(0, 0, 0), radius=5)
    scenario = alone(ball, start=(-12, 1, 2), target=(11, -2, 1), clearance=0.5, high=(20, 20, 15))
    length = wrapped((-12, 1, 2), (11, -2, 1), (0, 0, 0), 5.5)
    assert length <= taut(scenario).cost <= length * 1.0005


@pytest.mark.parametrize("across", [0.0, 9.0])
def test_over_a_ridge_it_bends_where_the_unfolded_slopes_are_straight(across):
    heights = np.array([[0.0, 0.0], [0.0, 0.0], [8.0, 8.0], [0.0, 0.0], [0.0, 0.0]])
    ridge = sky.Terrain(origin=(-20, -20), step=(10, 40), heights=heights, clearance=1.0)
    scenario = alone(
        start=(-15, -across / 2, 2), target=(18, across / 2, 4), terrain=ridge, high=(20, 20, 30), step=2.0
    )
    flat = math.hypot(15, 7) + math.hypot(18, 5)
    result = taut(scenario)
    assert result.cost == pytest.approx(math.hypot(flat, across), rel=1e-4)
    assert len(result.path) <= 4


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.9, 1.4, 2.6])
def test_around_a_turned_block_it_bends_at_two_of_its_corners(angle):
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    corners = np.array([(-3, -5), (3, -5), (3, 4), (-3, 4)]) @ turn.T
    start, target = turn @ (-9, 0.5), turn @ (10, -1)
    turned = sky.Prism(vertices=tuple(map(tuple, corners.tolist())), low=-1, high=8)
    result = taut(alone(turned, start=(*start, 2), target=(*target, 3)))
    flat = math.hypot(6, 3.5) + 6 + math.hypot(7, 5)
    assert result.cost == pytest.approx(math.hypot(flat, 1), rel=1e-4)
    assert len(result.path) < 7


def test_under_a_beam_it_goes_under_and_not_around():
    beam = sky.Prism(vertices=((-2, -18), (2, -19), (2, 18), (-2, 19)), low=3, high=9)
    result = taut(alone(beam, start=(-9, 0, 5), target=(9, 0, 5), step=2.0))
    assert result.cost == pytest.approx(2 * math.hypot(7, 2) + 4, rel=1e-4)


def test_where_a_wall_of_prisms_leaves_no_way_it_says_so():
    wall = sky.Prism(vertices=((-1, -21), (1, -21), (2, 21), (0, 21)), low=-1, high=11)
    assert taut(alone(wall, start=(-9, 0, 3), target=(9, 0, 3))).status is sky.Status.NO_PATH
    lower = wall.model_copy(update={"high": 6.0})
    assert taut(alone(lower, start=(-9, 0, 3), target=(9, 0, 3))).status.reached
