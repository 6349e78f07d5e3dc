"""Adversarial flights for `certificates.py`: through, along and over walls with slits and exact corridors."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from oracle import sampled
from wild import assembled, generous, hermite, judged_by

import skyverse as sky
from skyverse.model.quantities import derived
from skyverse.model.shapes import Obstacle, Sphere, Terrain, Voxels

GAPS = (0.0, 1e-9, 5e-7, -1e-9, -5e-7, -1.9e-6, -2.1e-6, -3e-6)
"""Metres between grown neighbours; negative where they overlap, which leaves no way beyond two micrometres."""
SLITS = (1e-4, 1e-3, 1e-2)
KINDS = ("box", "prism", "diamond", "cylinder", "sphere", "voxels", "slot")


class Wall(NamedTuple):
    """The obstacles and ground of a wall, where its shapes meet along x, and the place of its middle."""

    shapes: list[Obstacle]
    terrain: Terrain | None
    joints: list[float]
    middle: np.ndarray


def walled(seed: int) -> sky.Mission:
    """Return one seed's mission."""
    rng = np.random.default_rng([seed, 1])
    scale = float(rng.choice([1e-2, 1.0, 1.0, 100.0]))
    clearance = max(scale * float(rng.choice([1e-3, 1e-3, 0.1, 0.5])), 1e-3)
    corner = rng.choice([0.0, 0.0, 1e3, -1e5, 3e5]) * np.array([1.0, -1.0, 0.0])
    wall = random_wall(rng, scale, clearance, corner)
    scenario = sky.Scenario(
        name="wall",
        bounds=sky.Bounds(min=corner, max=corner + scale * np.array([10, 10, 5])),
        obstacles=wall.shapes,
        terrain=wall.terrain,
        clearance=clearance,
        lattice=sky.Lattice(step=(scale,) * 3),
        objective=sky.Objective(unit="metres"),
    )
    kind = rng.choice(["through", "planned", "aeroplane", "skewed"])
    x = float(rng.choice(wall.joints)) if wall.joints else wall.middle[0]
    begin, end = (np.array([x, wall.middle[1] + by * scale, wall.middle[2]]) for by in (-3.5, 3.5))
    if kind == "skewed":
        begin[0], end[0] = rng.uniform(0.1, 9.9, 2) * scale + corner[0]
        through = (begin[1] - wall.middle[1]) / (begin[1] - end[1])
        end[0] = min(max(begin[0] + (x - begin[0]) / through, corner[0]), corner[0] + 10 * scale)
    if kind == "planned":
        uavs, targets = (sky.UAV(start=begin, max_speed=5 * scale),), (sky.Target(position=end),)
        mission = sky.plan_mission(
            derived(scenario, uavs=uavs, targets=targets), sky.Taut(), rng=0, assignment="identity"
        )
        if mission.trajectories[0] is not None:
            return mission
    seconds = float(rng.choice([0.2, 1.0, 5.0]))
    flown = at_constant_speed(begin, end, seconds) if kind == "aeroplane" else from_rest_to_rest(begin, end, seconds)
    _, motion = sampled(flown)
    speed = float(np.linalg.norm(end - begin)) / seconds
    wing = sky.FixedWing(speed=speed, turn_radius=scale, climb=10.0)
    uav = generous(motion)
    if kind == "aeroplane":
        hardest = max(uav.max_acceleration, 2 * speed**2 / scale)
        uav = derived(uav, fixed_wing=wing, max_acceleration=hardest)
    mission = assembled([flown], [uav], 10 * scale)
    ends = {"uavs": mission.scenario.uavs, "targets": mission.scenario.targets}
    return judged_by(replace(mission, scenario=derived(scenario, **ends)), {0: uav})


def random_wall(rng: np.random.Generator, scale: float, clearance: float, corner: np.ndarray) -> Wall:
    """Put up to four shapes side by side across the space, sometimes on a ridge of the ground."""
    count = int(rng.integers(1, 5))
    gaps = rng.choice(GAPS, count + 1)
    slits = rng.random(count + 1) < 0.3
    gaps[slits] = scale * rng.choice(SLITS, slits.sum())
    places = np.linspace(0.0, 10.0, count + 1) * scale
    y, z = corner[1] + 4.5 * scale, 2.5 * scale
    ridge = scale if rng.random() < 0.3 else None
    low = -scale if ridge is None else ridge + clearance + float(rng.choice(GAPS))
    shapes: list[Obstacle] = []
    for k in range(count):
        a, b = places[k] + gaps[k] / 2 + clearance + corner[0], places[k + 1] - gaps[k + 1] / 2 - clearance + corner[0]
        if b - a > 1e-6:
            shapes += pieces(str(rng.choice(KINDS)), (a, b), y, (low, 6 * scale), scale, clearance)
    joints = [float(np.clip(place + corner[0], corner[0], corner[0] + 10 * scale)) for place in places]
    slots = [
        float(np.mean([x for x, _ in one.vertices[1:3]] + [x for x, _ in one.vertices[3:5]]))
        for one in shapes
        if isinstance(one, sky.Prism) and len(one.vertices) == 8
    ]
    terrain = None
    if ridge is not None:
        heights = np.full((4, 12), -3.0 * scale)
        heights[:, 4:6] = ridge
        start = corner[:2] - scale * np.array([5.0, 0.5])
        terrain = Terrain(origin=start, step=(10 * scale, scale), heights=heights, clearance=clearance)
    height = ridge if ridge is not None and rng.random() < 0.3 else z
    return Wall(shapes, terrain, [*joints, *slots], np.array([corner[0] + 5 * scale, y, height]))


def pieces(
    kind: str, across: tuple[float, float], y: float, span: tuple[float, float], scale: float, clearance: float
) -> list[Obstacle]:
    """Return shapes that meet their neighbours at both ends along x, at least in the plane of the wall."""
    (a, b), (low, high) = across, span
    middle = (a + b) / 2
    if kind == "cylinder":
        return [sky.Cylinder(centre=(middle, y), radius=(b - a) / 2, low=low, high=high)]
    if kind == "sphere":
        return [Sphere(centre=(middle, y, 2.5 * scale), radius=(b - a) / 2)]
    if kind == "voxels":
        step = ((b - a) / 2, 0.25 * scale, high - low)
        return [Voxels(origin=(a, y - 0.25 * scale, low), step=step, occupied=np.ones((2, 2, 1)))]
    if kind == "box":
        return [sky.Box(min=(a, y - scale / 2, low), max=(b, y + scale / 2, high))]
    half = 0.3 * scale
    if kind == "diamond":
        corners = [(a, y), (middle, y - half), (b, y), (middle, y + half)]
    elif kind == "slot" and b - a > 8 * clearance:  # a corridor within one prism that fits exactly
        left, right = middle - clearance, middle + clearance
        corners = [(a, y - half), (left, y - half), (left, y + half / 2), (right, y + half / 2), (right, y - half)]
        corners += [(b, y - half), (b, y + half), (a, y + half)]
    else:
        corners = [(a, y - half), (b, y - half), (b, y + half), (a, y + half)]
    return [sky.Prism(vertices=corners, low=low, high=high)]


def from_rest_to_rest(begin: np.ndarray, end: np.ndarray, seconds: float) -> sky.Trajectory:
    """Return the flight of least jerk along a straight line."""
    rows = np.zeros((1, 6, 3))
    rows[0, 0] = begin
    for power, share in ((3, 10.0), (4, -15.0), (5, 6.0)):
        rows[0, power] = share * (end - begin) / seconds**power
    return sky.Trajectory(np.array([0.0, seconds]), rows)


def at_constant_speed(begin: np.ndarray, end: np.ndarray, seconds: float) -> sky.Trajectory:
    """Return an aeroplane's flight along a straight line, in a few pieces."""
    knots = np.linspace(0.0, seconds, 5)
    places = begin + (knots / seconds)[:, None] * (end - begin)
    speed = np.tile((end - begin) / seconds, (5, 1))
    return hermite(knots, places, speed, np.zeros((5, 3)))
