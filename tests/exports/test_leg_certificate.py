"""What is exported is proven by the referee, whatever the search for waypoints took for clear."""

import re
from dataclasses import replace

import handmade_exports as handmade
import numpy as np
import pytest

import skyverse as sky
from skyverse import Origin, Terrain, World
from skyverse.exports import LegChecker, LegSpace, refused
from skyverse.exports.leg_space import Segments

ORIGIN = Origin(latitude=52.0, longitude=4.37, altitude=10.0, geoid=43.0)
BOX = ((-10, -10, 0), (10, 10, 40))


def around_a_tower(clearance=1.0):
    """A flight that touches two corners of a tower grown by the clearance."""
    (x0, y0), (x1, y1) = (-10 - clearance, -10 - clearance), (10 + clearance, 10 + clearance)
    path = [(x0 - 20, 0, 15), (x0, y1, 15), (x1, y1, 15), (x1 + 20, 0, 15)]
    return handmade.mission([handmade.along(path, 10)], boxes=[BOX], clearance=clearance, origin=ORIGIN), (y0, y1)


def certificate(mission, reference="amsl"):
    return LegChecker(LegSpace(mission.scenario, reference))


def test_every_part_of_a_found_route_is_proven():
    mission, _ = around_a_tower()
    (route,) = sky.routes(mission)
    proof = certificate(mission)
    assert refused([proof], [route.polyline]) == set()
    segments = [s for _, checked, _ in proof.parts(*route.polyline) for s in checked.clear]
    assert len(segments) >= len(route.points) - 1


def test_a_search_that_sees_nothing_exports_nothing_that_is_not_proven(monkeypatch):
    mission, _ = around_a_tower()
    seeing = World.first_crossing
    monkeypatch.setattr(World, "first_crossing", lambda *args: None)
    try:
        (route,) = sky.routes(mission)
    except sky.InputError as error:
        assert "could not be proven" in str(error)  # noqa: PT017
        return
    monkeypatch.setattr(World, "first_crossing", seeing)
    proof = certificate(mission)
    assert proof.trouble(*route.polyline) is None
    assert refused([proof], [route.polyline]) == set()


def test_what_the_referee_refuses_counts_as_faulty_from_then_on(monkeypatch):
    mission, (_, far) = around_a_tower()
    proof = certificate(mission)
    through, beside = ([(-40, y, 15), (40, y, 15)] for y in (0, far + 5))
    lines = [(np.array(points, dtype=float), 0.0, np.zeros(2)) for points in (beside, through)]
    monkeypatch.setattr(World, "first_crossing", lambda *args: None)
    assert all(proof.trouble(*line) is None for line in lines)
    assert refused([proof] * len(lines), lines) == {1}
    assert proof.trouble(*lines[0]) is None
    where, fault = proof.trouble(*lines[1])
    assert where == 0
    assert "inside obstacle 0" in proof.space.sentence(fault)
    assert refused([proof] * len(lines), lines) == set()  # only what counts as clear is asked


@pytest.mark.parametrize("seed", range(6))
def test_search_and_referee_agree_on_legs_among_shapes_of_all_kinds(seed):
    rng = np.random.default_rng(seed)
    places = [(-40, -40), (-40, 40), (40, -40), (40, 40)]
    turn = rng.uniform(0, np.pi)
    ring = [(40 + 9 * np.cos(turn + k * np.pi / 2), 40 + 9 * np.sin(turn + k * np.pi / 2)) for k in range(4)]
    shapes = (
        sky.Box(min=(-50, -50, 0), max=(-30, -30, 30)),
        sky.Cylinder(centre=places[1], radius=9, low=0, high=30),
        sky.Sphere(centre=(*places[2], 15), radius=9),
        sky.Prism(vertices=tuple(ring), low=0, high=30),
    )
    mission = handmade.mission([handmade.along([(-90, 0, 50), (90, 0, 50)], 10)], clearance=2.0, origin=ORIGIN)
    given = mission.scenario.model_copy(update={"obstacles": shapes})
    proof = certificate(replace(mission, scenario=given))
    lines = []
    for _ in range(60):
        points = np.column_stack([rng.uniform(-70, 70, (4, 2)), rng.uniform(5, 45, 4)])
        lines.append((points, 2.0, np.zeros(4)))
    found = [proof.trouble(*line) for line in lines]
    assert 5 < sum(fault is None for fault in found) < 55
    assert refused([proof] * len(lines), lines) == set()  # what the search took for clear
    faults = [fault[1] for fault in found if fault is not None and isinstance(fault[1], Segments)]
    assert all("obstacle" in proof.space.sentence(fault) for fault in faults)  # and what it took for blocked


@pytest.mark.parametrize("reference", ["amsl", "agl"])
def test_legs_keep_below_a_ceiling_that_follows_the_terrain(reference):
    ground = np.add.outer(np.linspace(0, 30, 7), np.zeros(7))
    terrain = Terrain(origin=(-300, -300), step=(100, 100), heights=ground, clearance=2.0)
    mission = handmade.mission([handmade.along([(-90, 0, 60), (90, 0, 60)], 10)], terrain=terrain, origin=ORIGIN)
    proof = certificate(replace(mission, scenario=mission.scenario.model_copy(update={"max_height": 50.0})), reference)
    west, east = 10.5 + 50, 19.5 + 50  # the ceiling at x = -90 and x = 90, metres
    for higher, clear in ((-0.1, True), (0.1, False)):
        line = np.array([(-90, 0, west + higher), (90, 0, east + higher)]), 0.0, np.zeros(2)
        fault = proof.trouble(*line)
        assert (fault is None) == clear
        assert refused([proof], [line]) == set()
        if fault is not None:
            assert "above the ceiling" in proof.space.sentence(fault[1])


def test_a_route_below_a_ceiling_says_how_high_above_ground_it_was_proven_to_stay():
    mission = handmade.random_mission(3, terrain=True)
    heights = [
        position[:, 2] - mission.scenario.terrain.height(position[:, :2])
        for flight in mission.trajectories
        for position in [flight.at(np.linspace(flight.start, flight.end, 2001)).position]
    ]
    most = float(np.concatenate(heights).max()) + 20.0
    below = replace(mission, scenario=mission.scenario.model_copy(update={"max_height": most}))
    for route in sky.routes(below):
        assert f" stays at most {most:.6g} m above ground" in route.sentence(below.scenario)
    low = replace(mission, scenario=mission.scenario.model_copy(update={"max_height": most - 25.0}))
    with pytest.raises(sky.InputError):
        sky.routes(low)


TOUCHING = {
    "boxes": (sky.Box(min=(-10, -20, 0), max=(10, -2, 40)), sky.Box(min=(-10, 2, 0), max=(10, 20, 40))),
    "prisms": tuple(
        sky.Prism(vertices=((-10, low), (10, low), (10, low + 18), (-10, low + 18)), low=0, high=40) for low in (-20, 2)
    ),
    "cylinders": tuple(sky.Cylinder(centre=(0, y), radius=8, low=0, high=40) for y in (-10, 10)),
    "spheres": tuple(sky.Sphere(centre=(0, y, 15), radius=8) for y in (-10, 10)),
}


@pytest.mark.parametrize("shapes", TOUCHING.values(), ids=TOUCHING)
@pytest.mark.parametrize("wider", [-1e-4, 1e-4])
def test_no_leg_is_proven_through_a_gap_that_is_too_narrow(monkeypatch, shapes, wider):
    mission = handmade.mission([handmade.along([(-90, 0, 50), (90, 0, 50)], 10)], clearance=2.0, origin=ORIGIN)
    given = mission.scenario.model_copy(update={"obstacles": shapes, "clearance": 2.0 - wider})
    proof = certificate(replace(mission, scenario=given))
    line = np.array([(-40, 0, 15), (40, 0, 15)], dtype=float), 0.0, np.zeros(2)
    searched = proof.trouble(*line)
    assert (searched is None) == (wider > 0)
    monkeypatch.setattr(World, "first_crossing", lambda *args: None)
    blind = certificate(replace(mission, scenario=given))
    assert blind.trouble(*line) is None
    assert refused([blind], [line]) == (set() if wider > 0 else {0})


def test_a_start_that_touches_a_grown_obstacle_is_exported(refuses):
    mission = handmade.mission(
        [handmade.along([(0, 0, 30), (0, 50, 30)], 10)], boxes=[((1, -5, 0), (10, 5, 60))], clearance=1.0, origin=ORIGIN
    )
    (route,) = sky.routes(mission)
    assert len(route.points) == 2
    nearer = mission.scenario.model_copy(update={"clearance": 1.001})
    with refuses():
        sky.routes(replace(mission, scenario=nearer))


def test_no_leg_is_proven_between_a_grown_shape_and_bounds_that_are_too_near():
    shape = (sky.Box(min=(-10, -20, handmade.LOW[2] + 1.999), max=(10, 20, 140)),)
    mission = handmade.mission([handmade.along([(-90, 0, 50), (90, 0, 50)], 10)], clearance=2.0, origin=ORIGIN)
    proof = certificate(replace(mission, scenario=mission.scenario.model_copy(update={"obstacles": shape})))
    for z in (handmade.LOW[2], handmade.LOW[2] - 0.002):
        line = np.array([(-40, 0, z), (40, 0, z)]), 0.0, np.zeros(2)
        assert proof.trouble(*line) is not None


def test_what_cannot_be_exported_is_told_with_the_leg_and_the_place():
    wall = ((30, -200, -50), (31, 200, 150))
    flight = handmade.along([(0, 0, 50), (60, 0, 50)], 20)
    with pytest.raises(sky.InputError, match=r"leg \d from 52\.\d+, 4\.\d+ \(.*obstacle 0 at 52\.\d+, 4"):
        sky.routes(handmade.mission([flight], boxes=[wall], origin=ORIGIN), takeoff=0)
    hill = np.zeros((13, 13))
    hill[6, 6] = 47.0
    terrain = Terrain(origin=(-300, -300), step=(50, 50), heights=hill, clearance=10.0)
    over = handmade.mission([handmade.along([(-100, 0, 50), (100, 0, 50)], 20)], terrain=terrain, origin=ORIGIN)
    with pytest.raises(sky.InputError, match=r"it may be .* m above ground, .*, at 52\.000000, 4\.370000 \(0, 0, 50\)"):
        sky.routes(over, altitude="agl", takeoff=0)


def test_a_leg_that_is_too_low_only_over_a_lower_ground_says_so(refuses):
    level = np.zeros((13, 13))
    terrain = Terrain(origin=(-300, -300), step=(50, 50), heights=level, lowest=level - 4.0, clearance=10.0)
    over = handmade.mission([handmade.along([(-100, 0, 13), (100, 0, 13)], 20)], terrain=terrain, origin=ORIGIN)
    with refuses():
        sky.routes(over, altitude="agl", takeoff=0)
    assert sky.routes(over, altitude="amsl", takeoff=0)


def test_what_the_referee_cannot_decide_is_told_with_the_place(monkeypatch):
    mission, _ = around_a_tower()
    proof = certificate(mission)
    fault = Segments(np.array([[-40.0, 60, 15]]), np.array([[40.0, 60, 15.257]]), 0.02)
    said = proof.space.sentence(fault)
    assert re.search(r"be decided between 52\.\d+, 4\.\d+ \(-40, 60, 15\) and 52\.\d+, 4\.\d+ \(40, 60, 15\.3\)$", said)
