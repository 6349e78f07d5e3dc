"""Small problems that make skyverse call every kernel: random worlds of all shapes, fleets, aeroplanes, maps, pages."""

import tempfile
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
import shapely

import skyverse as sky
from handmade import mission, straight
from skyverse.draw import triangles
from skyverse.flight import commands_to, simulate, vehicle_of
from skyverse.maps.assembly.surface_excess import raise_cells
from skyverse.maps.readers.mesh import touched
from skyverse.maps.readers.octomap import read_octomap
from skyverse.maps.readers.pcd import unpack
from skyverse.mission.routing import TourVehicle, Work
from skyverse.mission.strip_routing import route_strips
from skyverse.space.timed_shapes import first_too_near, mover_gaps, moving_shapes, timed_parts
from skyverse.survey.leg_time import LegTime
from skyverse.survey.set_cover import few_sets
from skyverse.survey.strip_order import order_strips
from skyverse.survey.sweep import sweep

FEW = sky.MaxIterations(3)
SIZE = np.array([24.0, 20.0, 12.0])

SEARCHES = (
    sky.AStar(),
    sky.MVO(universes=4),
    sky.MVO(universes=4, as_run=True),
    sky.MVO(universes=4, generator="uniform"),
    sky.HybridMVO(universes=6),
    sky.GSO(glowworms=4),
    sky.GSO(glowworms=4, as_run=True),
    sky.BBO(habitats=4),
    sky.BBO(habitats=4, as_run=True),
    sky.RandomRestart(samples=4),
    sky.WOA(waypoints=2, candidates=6),
)
ANY_ANGLE = (
    sky.Taut(),
    sky.ThetaStar(),
    sky.WOA(waypoints=2, candidates=6, legs="straight"),
)


def ring(rng, middle, least, most, corners):
    """The corners of a random star-shaped polygon, (n, 2)."""
    angles = np.linspace(0, 2 * np.pi, corners, endpoint=False) + rng.uniform(0, 1)
    places = np.array(middle[:2]) + rng.uniform(least, most, (corners, 1)) * np.c_[np.cos(angles), np.sin(angles)]
    return tuple(map(tuple, places.tolist()))


def shape(rng, kind, **more):
    """A random obstacle of a kind, or a zone of it."""
    middle, high = rng.uniform(0.2, 0.8, 3) * SIZE, float(rng.uniform(5, 11))
    if kind == "box":
        half = rng.uniform(0.5, 2.5, 3)
        return sky.Box(min=tuple(middle - half), max=tuple(middle + half), **more)
    if kind == "cylinder":
        return sky.Cylinder(centre=tuple(middle[:2]), radius=float(rng.uniform(0.7, 2.5)), low=0, high=high, **more)
    if kind == "sphere":
        return sky.Sphere(centre=tuple(middle), radius=float(rng.uniform(0.7, 2.5)), **more)
    if kind == "prism":
        return sky.Prism(vertices=ring(rng, middle, 1.0, 3.0, int(rng.integers(4, 8))), low=0, high=high, **more)
    occupied = rng.random((4, 3, 4)) < 0.4
    occupied[0, 0, 0] = True
    return sky.Voxels(origin=tuple(middle - 1.5), step=(0.8, 0.9, 1.0), occupied=occupied, **more)


def world(seed, kinds, terrain=False, soft=False, uavs=1, connectivity=26, unit="metres", altitude=8.0, **wing):
    """A random scenario with two obstacles of each kind."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(0, 27, 2.0), np.arange(0, 23, 2.0), indexing="ij")
    heights = 1.0 + rng.uniform(0.2, 1.0) * np.sin(x / rng.uniform(2, 6)) * np.cos(y / rng.uniform(2, 6))
    objective = {"fuel": 1.0, "divergence": float(rng.choice([0.0, 0.3])), "end": 10.0, "unit": unit}
    zones = ()
    if soft:
        band = sky.AltitudeBand(low=3, high=7, weight=0.2, above="ground" if terrain else "zero")
        objective |= {"altitude": band, "risk": 1.0, "climb": sky.ClimbLimit(angle=15, weight=0.5)}
        zones = tuple(shape(rng, kind, risk=2.0) for kind in ("box", "cylinder", "prism", "prism", "voxels"))
    ends = [(0.5 + 1.5 * k, 0.6 + 0.1 * k, altitude + 0.3 * k) for k in range(uavs)]
    return sky.Scenario(
        name="random",
        bounds=sky.Bounds(min=(0, 0, 0), max=tuple(SIZE)),
        obstacles=tuple(shape(rng, kind) for kind in kinds for _ in range(2)),
        zones=zones,
        terrain=sky.Terrain(origin=(0, 0), step=(2.0, 2.0), heights=heights) if terrain else None,
        max_height=10.2 if terrain else None,
        clearance=float(rng.choice([0.1, 0.25])),
        lattice=sky.Lattice(step=(1.5, 1.5, 1.5), connectivity=connectivity),
        objective=sky.Objective(**objective),
        uavs=tuple(sky.UAV(start=end, **wing) for end in ends),
        targets=tuple(sky.Target(position=(SIZE[0] - x, SIZE[1] - y, z + 0.5)) for x, y, z in ends),
    )


def searches_on_lattices():
    for seed, kinds, more in (
        (1, ("box",), {"unit": "nodes", "connectivity": 6}),
        (2, ("box", "cylinder", "sphere", "prism", "voxels"), {"terrain": True, "soft": True}),
    ):
        airspace = sky.Airspace(world(seed, kinds, **more))
        for planner in SEARCHES:
            planner.plan(sky.Problem(airspace), stop=FEW, rng=seed)


def searches_among_movers():
    scenario = world(17, ("box", "sphere"), unit="nodes", connectivity=6)
    moving = sky.random_movers(scenario, 6, kind="knots", speed=1.0, seed=1)
    for planner in (sky.MVO(universes=4), sky.WOA(waypoints=2, candidates=6)):
        planner.plan(sky.Problem(moving), stop=FEW, rng=1)
    sky.MVO(universes=4).evolve(sky.Problem(moving), [sky.Taut().plan(sky.Problem(scenario)).path], stop=FEW, rng=1)


def searches_of_any_angle():
    for seed, kinds, more in (
        (3, ("box", "box", "box"), {}),
        (4, ("box", "box"), {"soft": True}),
        (5, ("box", "cylinder", "sphere", "prism", "voxels"), {"terrain": True, "soft": True}),
        (6, ("cylinder", "prism"), {}),
    ):
        airspace = sky.Airspace(world(seed, kinds, **more))
        for planner in ANY_ANGLE:
            planner.plan(sky.Problem(airspace), stop=FEW, rng=seed)


def searches_for_other_ways_round():
    scenario = sky.Scenario(
        name="a pillar as high as the space, and walls",
        bounds=sky.Bounds(min=(0, 0, 0), max=(10, 10, 5)),
        obstacles=(
            sky.Box(min=(2, 2, 0), max=(3, 9, 5)),
            sky.Box(min=(4.2, 1, 0.5), max=(4.6, 8, 4.5)),
            sky.Box(min=(6.1, 3, 0.8), max=(6.6, 9.5, 4.2)),
        ),
        clearance=0.1,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=(sky.UAV(start=(1, 6.1, 2.6)),),
        targets=(sky.Target(position=(9, 5.2, 2.4)),),
    )
    sky.Taut(proof=5).plan(sky.Problem(scenario))


def searches_for_the_whole_objective():
    band = sky.AltitudeBand(low=3, high=7, weight=0.2)
    scenario = sky.Scenario(
        name="beside a box and through a zone",
        bounds=sky.Bounds(min=(0, 0, 0), max=(24, 20, 12)),
        obstacles=(sky.Box(min=(8, 4, 0), max=(12, 16, 12)),),
        zones=(sky.Cylinder(centre=(18, 10), radius=3, low=0, high=12, risk=2.0),),
        clearance=0.25,
        lattice=sky.Lattice(step=(3, 3, 3), connectivity=26),
        objective=sky.Objective(unit="metres", divergence=0.3, risk=1.0, altitude=band),
        uavs=(sky.UAV(start=(1, 10, 5)),),
        targets=(sky.Target(position=(23, 10, 5)),),
    )
    sky.Cheapest(legs=12_000, proof=60).plan(sky.Problem(scenario))


def trajectories_among_boxes():
    sky.plan_mission(world(7, ("box", "box")), sky.Taut(), rng=7, options=sky.MissionOptions(shape="minimum-jerk"))


def trajectories_over_hills():
    over_hills = world(8, ("cylinder", "prism", "voxels"), terrain=True, altitude=2.6)
    sky.plan_mission(over_hills, sky.Taut(), rng=7, options=sky.MissionOptions(shape="minimum-snap"))
    sky.plan_mission(over_hills, sky.AStar(), rng=7, options=sky.MissionOptions(shape="stop-and-go"))


def fleets():
    swap = sky.circle_swap(2, radius=4.0)
    sky.plan_mission(swap, sky.Taut(), rng=1, assignment="identity")
    early, late = (sky.Trajectory(np.array([at, at + 4.0]), line) for at, line in zip((0, 3), MEETING, strict=True))
    sky.find_conflicts(swap, (early, late))
    ends = [sky.UAV(start=(-4, side, 5), separation=1.0) for side in (-0.3, 0.3)]
    beside = [sky.Target(position=(4, side, 5)) for side in (0.3, -0.3)]
    close = swap.model_copy(update={"uavs": tuple(ends), "targets": tuple(beside)})
    sky.plan_mission(close, sky.Taut(), rng=1, assignment="identity")


def waits_on_the_way():
    walls = (((0, 0, 0), (6, 0.2, 1)), ((0, 0.9, 0), (2.6, 2, 1)), ((3.4, 0.9, 0), (6, 2, 1)))
    corridor = sky.Scenario(
        name="a corridor with a bay",
        bounds=sky.Bounds(min=(0, 0, 0), max=(6, 2, 1)),
        obstacles=tuple(sky.Box(min=low, max=high) for low, high in walls),
        clearance=0.1,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=tuple(sky.UAV(start=(x, 0.55, 0.5)) for x in (0.5, 5.5)),
        targets=tuple(sky.Target(position=(x, 0.55, 0.5)) for x in (5.0, 1.0)),
    )
    sky.plan_mission(corridor, sky.Taut(), rng=1, assignment="identity")
    passing = sky.WaypointMotion(points=[(8, 0.55, 0.5), (-2, 0.55, 0.5)], times=[0, 10])
    alone = {"uavs": corridor.uavs[:1], "targets": corridor.targets[:1]}
    alone["movers"] = (sky.Mover(shape=sky.Sphere(centre=(0, 0, 0), radius=0.4), motion=passing),)
    sky.plan_mission(sky.Scenario.model_validate({**dict(corridor), **alone}), sky.Taut(), rng=1)


def flights_among_movers():
    swap = sky.circle_swap(2, radius=4.0)
    coarse = sky.Lattice(step=(1, 1, 2), connectivity=26)
    shapes = (
        sky.Sphere(centre=(0, 0, 0), radius=0.4),
        sky.Cylinder(centre=(0.1, 0), radius=0.3, low=-1, high=1),
        sky.Box(min=(-0.3, -0.2, -0.5), max=(0.3, 0.2, 0.5)),
        sky.Ellipsoid(centre=(0, 0, 0), semi_axis_xy=0.3, semi_axis_z=0.5),
        sky.Sphere(centre=(0, 0, 0), radius=0.2),
    )
    motions = (
        sky.WaypointMotion(points=[(0, 0, 10)], times=[0.0]),
        sky.CircularMotion(centre=(0, 0, 10), radius=2, period=7),
        sky.PolynomialMotion(knots=(0, 4), coefficients=[[(3, 3, 10), (-1, -0.5, 0), (0.1, 0, 0)]]),
        sky.WaypointMotion(points=[(5, 5, 10), (4, 5, 10), (5, 5, 10)], times=[0, 3, 5], then="repeats"),
        sky.WaypointMotion(points=[(0, -6, 10), (0, 6, 10)], times=[0.0, 9.0], then="returns"),
    )
    doubt = sky.Doubt(radius=0.05, growth=0.01, since=1.0, top_speed=2.0)
    movers = [sky.Mover(shape=shape, motion=motion, doubt=doubt) for shape, motion in zip(shapes, motions, strict=True)]
    zones = [
        sky.Prism(vertices=[(-1, -1), (1, -1), (0, 1)], low=8, high=12, active=[[0, 3]]),
        sky.Box(min=(-3, -3, 8), max=(-2, 3, 12), max_speed=1.0, active=[[2, None]]),
    ]
    given = sky.Scenario(**{**dict(swap), "movers": movers, "zones": zones, "lattice": coarse})
    sky.plan_mission(given, sky.Taut(), rng=1, assignment="identity", options=sky.MissionOptions(shape="stop-and-go"))
    instants = np.linspace(0, 12, 40)
    shapes = moving_shapes(timed_parts(given), sky.TrackingError())
    mover_gaps(shapes, instants, np.zeros((40, 3)))
    for m in range(len(shapes.kind)):
        first_too_near(shapes, m, np.zeros(3), 0.0, 12.0)


def flights_replanned():
    scenario = sky.Scenario(
        name="a hall with a pillar",
        bounds=sky.Bounds(min=(0, 0, 0), max=(20, 10, 4)),
        obstacles=(sky.Box(min=(9, 3, 0), max=(10, 7, 4)),),
        clearance=0.2,
        lattice=sky.Lattice(step=(1, 1, 1), connectivity=26),
        uavs=(sky.UAV(start=(1, 5, 1)),),
        targets=(sky.Target(position=(19, 5, 1)),),
    )
    replanner = sky.Replanner(sky.plan_mission(scenario, sky.Taut()), candidates=12)
    ball = sky.Sphere(centre=(0, 0, 0), radius=0.4)
    for t in (0.0, 0.5, 1.0, 1.2):
        seen = sky.Sighting(name="ball", shape=ball, position=(5 - t, 4.5, 1), top_speed=2.0, max_acceleration=0.5)
        replanner.observe(t, movers=[seen])
    place = replanner.motion(0).at([1.4]).position[0]
    replanner.observe(1.4, movers=[sky.Sighting(name="on top", shape=ball, position=place, top_speed=1.0)])


def aeroplanes_replanned():
    wing = sky.FixedWing(speed=8.0, turn_radius=6.0, climb=12)
    scenario = sky.Scenario(
        name="a field with a tower",
        bounds=sky.Bounds(min=(0, 0, 0), max=(90, 60, 30)),
        obstacles=(sky.Box(min=(40, 20, 0), max=(50, 40, 30)),),
        clearance=1.0,
        lattice=sky.Lattice(step=(5, 5, 5), connectivity=26),
        uavs=(sky.UAV(start=(10, 30, 10), max_speed=12, max_acceleration=15, fixed_wing=wing),),
        targets=(sky.Target(position=(80, 30, 20)),),
    )
    replanner = sky.Replanner(sky.plan_mission(scenario, sky.Taut()), candidates=12)
    ball = sky.Sphere(centre=(0, 0, 0), radius=2.0)
    for t in (0.0, 0.5, 1.0, 4.0):
        seen = sky.Sighting(name="ball", shape=ball, position=(40 - t, 46, 12), top_speed=3.0, max_acceleration=0.5)
        replanner.observe(t, movers=[seen])
    place = replanner.motion(0).at([4.2]).position[0]
    replanner.observe(4.2, movers=[sky.Sighting(name="on top", shape=ball, position=place, top_speed=1.0)])


MEETING = (np.array([[[-4.0, 0, 5], [1, 0, 0]]]), np.array([[[4.0, 0, 5], [-1, 0, 0]]]))
"""Two straight flights, (1, 2, 3) each: the first ends at the origin, where the second arrives after it."""


def aeroplanes():
    wing = sky.FixedWing(speed=8.0, turn_radius=6.0, climb=12)
    for seed, kinds, terrain in ((10, ("box",), False), (11, ("cylinder", "prism", "voxels"), True)):
        scenario = world(seed, kinds, terrain, max_speed=12, max_acceleration=15, fixed_wing=wing)
        sky.plan_mission(scenario, sky.Taut(), rng=seed)


def surveys():
    """A field over hills with a house and a zone, for two UAVs; another for an aeroplane; a tower with a porch."""
    rng = np.random.default_rng(18)
    x, y = np.mgrid[:7, :7] * 20.0
    hills = 4.0 * np.sin(x / rng.uniform(15, 25)) + 3.0 * np.cos(y / rng.uniform(15, 25))
    field, home = [(30, 30), (100, 30), (60, 90), (30, 70)], {"start": (5, 5, 15), "end": "home"}
    fast = {"max_speed": 10, "max_acceleration": 3, "max_climb": 3, "separation": 2}
    scenario = sky.Scenario(
        name="hills",
        bounds=sky.Bounds(min=(0, 0, -10), max=(120, 120, 110)),
        obstacles=(
            sky.Box(min=(50, 55, -10), max=(58, 66, 12)),
            sky.Cylinder(centre=(80, 60), radius=7, low=-10, high=110, solid=False),
        ),
        terrain=sky.Terrain(origin=(0, 0), step=(20.0, 20.0), heights=hills),
        clearance=1.0,
        lattice=sky.Lattice(step=(10, 10, 10), connectivity=26),
        uavs=tuple(sky.UAV(**{**home, "start": (x, 5, 15)}, **fast) for x in (5, 15)),
        surveys=(sky.Survey(field, "mavic-3e", gsd=0.02, overlap=(40, 80)),),
    )
    tower = sky.Box(min=(50, 50, 0), max=(60, 62, 20), name="tower")
    porch = [[(50, 48, 0), (60, 48, 0), (55, 48, 9)], [(50, 46, 6), (60, 46, 6), (55, 48, 9)]]
    hull = sky.Box(min=(50, 46, 0), max=(60, 50, 9), solid=False)
    views = sky.Survey(
        structures=["tower"], facets=porch, camera="mavic-3e", gsd=0.008, overlap=(0, 0), pattern="facade"
    )
    wing = sky.UAV(**home, max_speed=12, max_acceleration=15, fixed_wing=sky.FixedWing(speed=8, turn_radius=6, climb=9))
    level = {**dict(scenario), "terrain": None, "obstacles": ()}
    with patch("skyverse.survey.viewpoints.few_sets", partial(few_sets, steps=200)):
        sky.plan_mission(scenario, rng=1, options=sky.MissionOptions(criterion="min-max"))
        sky.plan_mission(sky.Scenario.model_validate(level | {"uavs": (wing,)}), rng=1)
        sky.plan_mission(sky.Scenario.model_validate(level | {"obstacles": (tower, hull), "surveys": (views,)}), rng=1)


def strips_in_the_plane():
    """A comb, and its strips flown in one route and by two vehicles in several sorties."""
    teeth = [(4 * k + x, y + k / 9) for k in range(12) for x, y in ((0, 9), (2, 9), (2, 3), (4, 3))]
    comb = shapely.Polygon([(0, 0), *teeth, (48, 0)], [[(6, 1), (9, 1), (7, 2)]])
    ways = np.array([(0.0, 1.0), (1.0, 0.0)])
    strips = sweep(comb, comb, 3.0, cost=LegTime(3.0, 1.0), directions=ways).strips[:9]
    ends = np.r_[strips.reshape(-1, 2), [(9, 20), (0, -5), (0, -5)]]
    seconds = np.hypot(*(ends[:, None] - ends).T)
    order_strips(seconds, np.arange(18).reshape(-1, 2), 19, None, rounds=2)
    vehicle = TourVehicle(
        price=seconds, seconds=seconds, joules=seconds, visit_joules=np.zeros(19), usable=60.0, most_sorties=3,
        swap=10.0, capacity=np.inf, allowed=np.ones(19, dtype=bool), returns=True,
    )  # fmt: skip
    visits = [*np.arange(18).reshape(-1, 2), (18, 18)]
    with patch("skyverse.mission.fleet_search._KICKS", (50, 0)):
        for opens in (20.0, 60.0):
            window = np.array([(0.0, np.inf)] * 18 + [(opens, np.inf)])
            route_strips([vehicle] * 2, visits, Work(np.zeros(19), window, np.zeros(19)), "min-max")


def questions_about_space():
    rng = np.random.default_rng(12)
    for seed, kinds, terrain in ((13, ("box", "box"), False), (14, ("cylinder", "sphere", "prism", "voxels"), True)):
        scenario = world(seed, kinds, terrain)
        points = rng.uniform(-0.1, 1.1, (40, 3)) * SIZE
        for clearance in (0.001, 0.25):
            space = sky.World(scenario.model_copy(update={"clearance": clearance}))
            space.free(points)
            space.segments_free(points[:20], points[20:])
            space.first_crossing(points[:20], points[20:])
            space.distance(points)
        strayed = sky.World(scenario, sky.TrackingError(horizontal=2.5, vertical=0.1))
        strayed.without_support(points[0], float(points[0, 2]))
    rubble = sky.Voxels(origin=(0, 0, 0), step=(1, 1, 1), occupied=rng.random((12, 12, 8)) < 0.5)
    sky.World(world(16, ()).model_copy(update={"obstacles": (rubble,)}))


def maps_and_pages():
    rng = np.random.default_rng(15)
    for corners in (5, 9):
        rings = [np.array(ring(rng, (0, 0), 3, 5, corners)), np.array(ring(rng, (0, 0), 1, 2, 4))]
        triangles(rings[:1])
        triangles(rings)
    touched(rng.uniform(0, 6, (30, 3, 3)), np.zeros((6, 6, 6), dtype=bool))
    unpack(np.zeros(2, np.uint8), np.zeros(1, np.uint8))
    surfaces, patches = np.zeros((2, 3, 3)), rng.random((2, 3, 3))
    raise_cells(np.zeros((2, 2, 2)), surfaces, 0.7 * np.mgrid[:3, :3], patches, 1, 1e-9)
    with tempfile.TemporaryDirectory() as folder:
        read_octomap(octree(Path(folder) / "tree.bt", rng))


def flights_in_simulation():
    vehicle = vehicle_of("thesis")
    told = commands_to(mission(straight((0, 0, 2), (0.2, 0.1, 2.3), 0.4)), 0, vehicle)
    disturbed = sky.Conditions(wind=(8, 2, 0), noise=0.1, gusts=True, mismatch=0.2, position_noise=0.5, delay=0.02)
    for seed, conditions in enumerate((sky.Conditions(), disturbed)):
        simulate(told, vehicle, conditions, seed)


def octree(path, rng):
    """Write a binary OctoMap file with random leaves, some of them twice as large as the others."""
    leaves = rng.integers(0, 3, (3, 8))
    leaves[0, 0] = leaves[1, 0] = 3
    words = [[3] + [0] * 7] * 13 + leaves.tolist()
    body = b"".join(sum(int(state) << 2 * k for k, state in enumerate(word)).to_bytes(2, "little") for word in words)
    nodes = 1 + sum(state > 0 for word in words for state in word)
    path.write_bytes(b"# Octomap OcTree binary file\nid OcTree\nsize %d\nres 0.5\ndata\n" % nodes + body)
    return path


WORKLOADS = (
    searches_on_lattices,
    searches_among_movers,
    searches_of_any_angle,
    searches_for_other_ways_round,
    searches_for_the_whole_objective,
    trajectories_among_boxes,
    trajectories_over_hills,
    fleets,
    waits_on_the_way,
    flights_among_movers,
    flights_replanned,
    aeroplanes_replanned,
    aeroplanes,
    surveys,
    strips_in_the_plane,
    questions_about_space,
    maps_and_pages,
    flights_in_simulation,
)
