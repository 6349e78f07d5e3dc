"""On the pads at start and target the tracking error does not count for what a UAV stands on, and for nothing else."""

from dataclasses import replace

import numpy as np
import pytest

import skyverse as sky
from handmade import hall
from skyverse.space.unsafe_points import unsafe_points

ERROR = sky.TrackingError(horizontal=1.6, vertical=3.0)
START, TARGET = (10, 10, 0.5), (30, 10, 20)


def scenario(*obstacles, start=START, target=TARGET, error=ERROR, **changes):
    uavs, given = [{"start": start, "tracking_error": error}], {"obstacles": obstacles, "clearance": 0.5}
    return hall((40, 20, 40), uavs, [target], **(given | changes))


def shaft(away, high=14.0, place=START):
    """Return four walls about a place."""
    x, y = place[:2]
    near, far = away, away + 1
    sides = ((near, -far, far, far), (-far, -far, -near, far), (-near, near, near, far), (-near, -far, near, -near))
    return [sky.Box(min=(x + a, y + b, 0), max=(x + c, y + d, high)) for a, b, c, d in sides]


def exact(given):
    """Return the same mission planned as if nobody strayed, for a scenario in which they do."""
    uavs = tuple(uav.model_copy(update={"tracking_error": sky.TrackingError()}) for uav in given.uavs)
    mission = sky.plan_mission(given.model_copy(update={"uavs": uavs}), sky.Taut())
    assert mission.violations == ()
    return replace(mission, scenario=given, certificates=())


def test_a_climb_in_a_shaft_narrower_than_the_error_is_neither_planned_nor_proven():
    given = scenario(*shaft(1.0))
    assert sky.plan_mission(given, sky.Taut()).results[0].status is sky.Status.START_UNSAFE
    found = sky.check(given, exact(given))
    said = next(one.message for one in found if one.fault is sky.Fault.TRAJECTORY_CLEARANCE)
    assert said.startswith("uav-1, with its tracking error, ")


def test_a_climb_in_a_shaft_wide_enough_for_the_error_is_planned_and_proven():
    given = scenario(*shaft(3.25))  # the pad of 1.6 m, and the error
    mission = sky.plan_mission(given, sky.Taut())
    assert mission.violations == ()
    assert mission.certificates[0].verdict is sky.Verdict.PROVEN
    assert mission.certificates[0].sentence.endswith(
        "; only on the pad at its start up to z = 3.51 m that error does not count for the ground and roofs below."
    )


ROOF = sky.Box(min=(6, 6, 0), max=(14, 14, 5))
ON_ROOF = (10, 10, 5.5)


@pytest.mark.parametrize(
    ("beside", "free", "end"),
    [
        (None, True, "target"),
        (sky.Box(min=(11, 6, 0), max=(12, 14, 5.001)), False, "start"),  # a parapet
        (sky.Box(min=(13.25, 6, 0), max=(13.9, 14, 30)), True, "start"),  # a wall far enough away
        (sky.Box(min=(13.15, 6, 0), max=(13.9, 14, 30)), False, "target"),
        (sky.Box(min=(9, 9, 12.05), max=(11, 11, 16)), True, "target"),  # a roof above
        (sky.Box(min=(9, 9, 11.95), max=(11, 11, 16)), False, "start"),
        (sky.Sphere(centre=(10, 10, 4), radius=1), False, "target"),  # it grows by the diagonal of the error
        (sky.Cylinder(centre=(11, 10), radius=0.4, low=0, high=5), True, "start"),
        (sky.Prism(vertices=[(11, 9), (12, 9), (12, 11)], low=0, high=8), False, "target"),
        (sky.Box(min=(11, 6, 0), max=(12, 14, 4), closed_above=True), False, "start"),
        (sky.Voxels(origin=(11, 9, 0), step=(1, 1, 1), occupied=np.ones((1, 1, 5), bool)), True, "target"),
        (sky.Box(min=(11, 6, 0), max=(12, 14, 5), solid=False), False, "target"),  # nothing stands on airspace
        (sky.Box(min=(11, 6, 0), max=(12, 14, 5), kind="no-fly zone office space"), True, "start"),  # mere words
    ],
)
def test_only_what_ends_below_a_start_or_target_is_exempt(beside, free, end):
    obstacles = [ROOF] + ([] if beside is None else [beside])
    places = {"start": ON_ROOF, "target": (30, 10, 20)}
    if end == "target":
        places = {"start": (30, 10, 20), "target": ON_ROOF}
    given = scenario(*obstacles, **places)
    assert (unsafe_points(given) == []) == free
    mission = sky.plan_mission(given, sky.Taut())
    assert mission.results[0].status.reached == free
    if free:
        assert mission.violations == ()
        assert f"at its {end} up to z = 8.51 m" in mission.certificates[0].sentence
    else:
        faults = {one.fault for one in sky.check(given, exact(given))}
        assert sky.Fault.TRAJECTORY_CLEARANCE in faults


def slope(rise):
    """Return a scenario whose ground rises evenly along x, with a start half a metre above it."""
    heights = np.array([[0.0, 0.0], [40.0 * rise, 40.0 * rise]])
    terrain = {"origin": (0, 0), "step": (40, 20), "heights": heights}
    start, target = (20, 10, 20 * rise + 0.5), (5, 10, 60)
    return scenario(start=start, target=target, terrain=terrain, bounds={"min": (0, 0, -5), "max": (40, 20, 120)})


@pytest.mark.parametrize(("rise", "free"), [(0.5, True), (1.0, True), (1.01, False), (1.2, False), (3.0, False)])
def test_ground_that_rises_too_steeply_beside_a_start_is_a_wall(rise, free):
    given = slope(rise)
    mission = sky.plan_mission(given, sky.Taut())
    assert mission.results[0].status.reached == free
    if free:
        assert mission.violations == ()
        top = given.uavs[0].start[2] + ERROR.vertical + rise * ERROR.horizontal + 0.01
        assert f"at its start up to z = {top:.6g} m" in mission.certificates[0].sentence
    else:
        assert sky.Fault.TRAJECTORY_CLEARANCE in {one.fault for one in sky.check(given, exact(given))}


def test_a_start_beside_the_bounds_or_below_the_ceiling_is_unsafe():
    beside = scenario(start=(1.5, 10, 0.5))
    assert sky.plan_mission(beside, sky.Taut()).results[0].status is sky.Status.START_UNSAFE
    terrain = {"origin": (0, 0), "step": (40, 20), "heights": np.zeros((2, 2))}
    low = scenario(target=(30, 10, 0.5), terrain=terrain, max_height=3.4)
    assert sky.plan_mission(low, sky.Taut()).results[0].status is sky.Status.START_UNSAFE


def wild(seed):
    """Return a scenario with walls, roofs, spheres and slopes about a start and a target, at random."""
    rng = np.random.default_rng(seed)
    error = sky.TrackingError(horizontal=rng.uniform(0, 2), vertical=rng.uniform(0, 3))
    rise = rng.choice([0.0, 0.0, 0.3, 1.0, 2.0])
    terrain = {"origin": (0, 0), "step": (20, 20), "heights": np.array([[0, 0], [0, 0], [20 * rise, 20 * rise]])}
    if rng.random() < 0.3:
        terrain = {"origin": (0, 0), "step": (2, 2), "heights": rng.uniform(-2, rng.choice([-0.5, 0.5, 1.5]), (21, 11))}
    shapes, places, ground = [], [], sky.Terrain.model_validate(terrain)
    for x in (10.0, 30.0):
        place = np.array([x + rng.uniform(-2, 2), 10.0, 0.0])
        place[2] = max(float(ground.height(place[:2])), 0.0)
        if rng.random() < 0.5:
            place[2] += 3
            shapes.append(sky.Box(min=(x - 3, 7, 0), max=(x + 3, 13, place[2])))
        for _ in range(rng.integers(0, 4)):
            (dx, dy), (wide, long) = rng.uniform(-4, 4, 2), rng.uniform(0.3, 2, 2)
            top = place[2] + rng.choice([0.0, -0.5, 0.2, 1.0, 6.0, 12.0])
            base = place[2] + 3 if rng.random() < 0.2 else -1.0
            low = (place[0] + dx - wide, 10 + dy - long, base)
            kind = rng.integers(4)
            if kind == 0:
                shapes.append(sky.Sphere(centre=(place[0] + dx, 10 + dy, top - wide), radius=wide))
            elif kind == 1 and top > base:
                shapes.append(sky.Cylinder(centre=(place[0] + dx, 10 + dy), radius=wide, low=base, high=top))
            elif top > base:
                shapes.append(sky.Box(min=low, max=(place[0] + dx + wide, 10 + dy + long, top)))
        places.append((*place[:2], place[2] + 0.5 + rng.choice([0.0, 0.1, 1.0])))
    bounds = {"min": (0, 0, 0), "max": (40, 20, 80)}
    shapes = [one.model_copy(update={"solid": rng.random() >= 0.1}) for one in shapes]
    return scenario(*shapes, start=places[0], target=places[1], error=error, terrain=terrain, bounds=bounds)


def too_near(given, places):
    """Tell which places (n, 3) are within the clearance of each obstacle, the ground last; (m + 1, n)."""
    found = []
    for shape in given.obstacles:
        if isinstance(shape, sky.Sphere):
            away = np.linalg.norm(places - np.array(shape.centre), axis=1) - shape.radius
        elif isinstance(shape, sky.Cylinder):
            level = np.hypot(*(places[:, :2] - np.array(shape.centre)).T) - shape.radius
            away = np.maximum(level, np.maximum(shape.low - places[:, 2], places[:, 2] - shape.high))
        else:
            away = np.maximum(np.array(shape.min) - places, places - np.array(shape.max)).max(axis=1)
        found.append(away < given.clearance - 1e-5)
    heights = given.terrain.height(places[:, :2])
    return np.stack([*found, places[:, 2] - heights < given.clearance - 1e-5])


def top_of(shape):
    """Return the z at which a shape ends."""
    match shape:
        case sky.Sphere():
            return shape.centre[2] + shape.radius
        case sky.Cylinder():
            return shape.high
    return shape.max[2]


def test_strayed_flights_come_near_nothing_but_what_they_stand_on():
    proven = on_pads = 0
    for seed in range(90):
        given = wild(seed)
        mission = sky.plan_mission(given, sky.Taut())
        assert mission.violations == (), seed
        flight, (certificate,) = mission.trajectories[0], mission.certificates
        if flight is None:
            continue
        assert certificate.verdict is sky.Verdict.PROVEN, seed
        proven, on_pads = proven + 1, on_pads + ("on the pad" in certificate.sentence)
        rng, error = np.random.default_rng(seed), given.uavs[0].tracking_error
        nominal = np.repeat(flight.at(np.linspace(flight.start, flight.end, 400)).position, 12, axis=0)
        turn, aside = (
            rng.uniform(0, 2 * np.pi, len(nominal)),
            error.horizontal * np.sqrt(rng.uniform(0, 1.5, len(nominal))),
        )
        aside, up = (
            np.minimum(aside, error.horizontal),
            error.vertical * np.clip(rng.uniform(-1.5, 1.5, len(nominal)), -1, 1),
        )
        strayed = nominal + np.column_stack([aside * np.cos(turn), aside * np.sin(turn), up])
        near = too_near(given, strayed)
        for foot in (given.uavs[0].start, given.targets[0].position):
            height = nominal[:, 2] - foot[2]
            held = (np.abs(nominal[:, :2] - foot[:2]).max(axis=1) < 1e-6) & (height > -1e-6)
            held &= height < error.horizontal + error.vertical + 0.02
            roofs = [
                shape.kind is None and top_of(shape) + given.clearance <= foot[2] + 1e-6 for shape in given.obstacles
            ]
            rise = given.terrain.height(strayed[:, :2]) + given.clearance - foot[2]
            seen_flatter = rise <= np.hypot(*(strayed[:, :2] - foot[:2]).T) + 1e-5  # than 45 degrees
            near[:-1] &= ~(np.array(roofs, dtype=bool)[:, None] & held[None])
            near[-1] &= ~(seen_flatter & held)
        assert not near.any(), seed
        assert not too_near(given, nominal).any(), seed
    assert proven >= 20
    assert on_pads >= 15
