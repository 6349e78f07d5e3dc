"""Pads for `certificates.py`: flights that rise and land among roofs, walls, airspace and steep ground.

On the pad at a start or target, a UAV need not keep its tracking error from what it stands on. This says by rules of
its own what that is, and shares them with no judge: solid obstacles that end low enough, and each single place of the
ground that the start or target sees at 45 degrees or flatter.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from oracle import Motion, depth, ground, norm, sampled
from wild import MADE_BY, generous, hermite

import skyverse as sky
from skyverse.model.pad import pad_at
from skyverse.model.quantities import derived
from skyverse.model.shapes import Obstacle, Sphere, Terrain, Voxels

BESIDE = 2e-6
"""Metres beside a pad within which a UAV counts as on it."""
OVER = 0.01
"""Metres by which a pad is higher than the vertical error and, over terrain, the horizontal one."""
UP = np.array([0.0, 0.0, 1.0])
CRUISE = 40.0
"""z at which it flies from the one pad to the other, metres."""


class Kept(NamedTuple):
    """What positions of a flight must keep clear of within the tracking error.

    Attributes
    ----------
    scenario
        Of which only what counts is left.
    positions
        (n, 3) metres.
    foot
        (3,) metres: the start or target on whose pad they are, ``None`` elsewhere.
    """

    scenario: sky.Scenario
    positions: np.ndarray
    foot: np.ndarray | None


def by_pads(mission: sky.Mission, uav: int, motion: Motion) -> Iterator[Kept]:
    """Yield what the positions on the pads at a UAV's start and target must keep clear of, then all others."""
    scenario, target = mission.scenario, mission.assignment[uav]
    error = scenario.uavs[uav].tracking_error
    highest = error.vertical + OVER + (0.0 if scenario.terrain is None else error.horizontal)
    radius = max(scenario.clearance, error.horizontal)
    feet = [scenario.uavs[uav].start] + ([] if target is None else [scenario.targets[target].position])
    p = motion.position
    left = np.ones(len(p), dtype=bool)
    for foot in map(np.array, feet if scenario.uavs[uav].fixed_wing is None else []):
        height = p[:, 2] - foot[2]
        held = norm(p[:, :2] - foot[:2]) <= radius + BESIDE
        held &= (height >= -BESIDE) & (height <= highest + BESIDE)
        yield Kept(without_below(scenario, foot[2] - scenario.clearance + BESIDE), p[held], foot)
        left &= ~held
    yield Kept(scenario, p[left], None)


def without_below(scenario: sky.Scenario, roof: float) -> sky.Scenario:
    """Return a scenario without the ground, the floor of its bounds, and what one may stand on below a z, metres."""
    kept = []
    for shape in scenario.obstacles:
        if not shape.solid or shape.closed_above:
            kept.append(shape)
        elif isinstance(shape, Voxels):
            tops = shape.origin[2] + shape.step[2] * (np.arange(shape.occupied.shape[2]) + 1)
            kept.append(derived(shape, occupied=shape.occupied & (tops > roof)))
        elif top_of(shape) > roof:
            kept.append(shape)
    x, y, _ = scenario.bounds.min
    bounds = derived(scenario.bounds, min=(x, y, -np.inf))
    terrain = scenario.terrain
    if terrain is not None:
        terrain = derived(terrain, clearance=-np.inf)
    return derived(scenario, obstacles=tuple(kept), bounds=bounds, terrain=terrain)


def too_near_steep_ground(mission: sky.Mission, foot: np.ndarray, strayed: np.ndarray) -> float:
    """Return how deep places (n, 3) are below what is kept above ground that rises too steeply from a foot, metres."""
    scenario = mission.scenario
    if scenario.terrain is None:
        return -np.inf
    keep = scenario.ground_clearance
    heights = ground(scenario.terrain, strayed[:, :2])
    beside = heights - (foot[2] - keep) > norm(strayed[:, :2] - foot[:2]) + 2 * BESIDE
    return float(np.max(heights + keep - strayed[:, 2] - 1e-6, where=beside, initial=-np.inf))


def top_of(shape: sky.Box | sky.Cylinder | sky.Prism | Sphere) -> float:
    """Return the z at which a shape ends, metres."""
    if isinstance(shape, Sphere):
        return shape.centre[2] + shape.radius
    return shape.max[2] if isinstance(shape, sky.Box) else shape.high


def rising(seed: int) -> sky.Mission:
    """Let a UAV with a tracking error rise straight up from one place, and descend straight to another."""
    rng = np.random.default_rng([seed, 3])
    error = sky.TrackingError(horizontal=float(rng.uniform(0.2, 2)), vertical=float(rng.uniform(0.2, 3)))
    clearance = float(rng.choice([0.001, 0.25, 0.5, 1.0]))
    terrain = relief(rng) if rng.random() < 0.7 else None
    feet, shapes = [], []
    for x in (10.0, 30.0):
        foot = np.array([x, 10.0, 0.0]) + np.append(rng.uniform(-2, 2, 2), 0)
        floor = 0.0 if terrain is None else float(ground(terrain, foot[None, :2])[0]) + clearance
        foot[2] = floor + rng.choice([0.0, 0.0, 0.2, error.horizontal, 4.0])
        feet.append(foot)
        shapes += [about(rng, foot, clearance, error) for _ in range(rng.integers(0, 3))]
    up = np.concatenate([foot + np.linspace(0, CRUISE - foot[2], 400)[:, None] * UP for foot in feet])
    given = {
        "name": "rising",
        "bounds": {"min": (0, 0, -30), "max": (40, 20, 80)},
        "clearance": clearance,
        "lattice": {"step": (1, 1, 1)},
        "uavs": [{"start": tuple(feet[0]), "tracking_error": error}],
        "targets": [{"position": tuple(feet[1])}],
    }
    plain = sky.Scenario.model_validate(given)
    clear = [one for one in shapes if depth(derived(plain, obstacles=(one,)), up).max() < 0]
    scenario = sky.Scenario.model_validate(given | {"obstacles": clear, "terrain": terrain})
    world = sky.World(scenario, error)
    pads = [pad_at(scenario, 0, tuple(foot), world.least_height(foot)) for foot in feet]
    cuts = [pad.top for pad in pads if pad is not None]
    a, b = ([*foot[:2]] for foot in feet)
    places = np.array([feet[0], [*a, cuts[0]], [*a, CRUISE], [*b, CRUISE], [*b, cuts[1]], feet[1]])
    still = np.zeros_like(places)
    trajectory = hermite(np.r_[0, np.cumsum(1.5 + norm(np.diff(places, axis=0)) / 8)], places, still, still)
    flown = sky.Trajectory(trajectory.knots, trajectory.coefficients)
    mission = sky.Mission(scenario, (0,), (None,), (flown,), (), MADE_BY)
    return flyable(mission)


def flyable(mission: sky.Mission) -> sky.Mission:
    """Return the mission with limits that its UAV keeps with ease."""
    (uav,), (flown,) = mission.scenario.uavs, mission.trajectories
    easy = generous(sampled(flown)[1])
    able = derived(easy, start=uav.start, name=uav.name, tracking_error=uav.tracking_error)
    return replace(mission, scenario=derived(mission.scenario, uavs=(able,)))


def relief(rng: np.random.Generator) -> Terrain:
    """Return ground that slopes, is rough, or has a cliff."""
    step = rng.uniform(0.5, 3, 2)
    count = np.ceil(np.array([40, 20]) / step).astype(int) + 1
    x, y = np.meshgrid(*(np.arange(n) * s for n, s in zip(count, step, strict=True)), indexing="ij")
    turn = rng.uniform(0, 2 * np.pi)
    along = (x - 20) * np.cos(turn) + (y - 10) * np.sin(turn)
    kind = rng.choice(["slope", "slope", "rough", "cliff"])
    if kind == "slope":
        heights = along * rng.choice([0.3, 1.0, 1.0 + 1e-6, 1.1, 1.2, 1.3])
    elif kind == "rough":
        heights = rng.uniform(0, 1, count) * rng.choice([0.1, 0.5, 2.0])
    else:
        edge = rng.uniform(-15, 15)
        heights = np.where(along > edge, rng.choice([0.3, 1.0, 3.0, 8.0]), 0.0)
    return Terrain(origin=(0, 0), step=step, heights=heights)


def about(rng: np.random.Generator, foot: np.ndarray, clearance: float, error: sky.TrackingError) -> Obstacle:
    """Return some shape below a foot, beside the line over it, or above."""
    size = rng.uniform(0.2, 2)
    away = rng.choice(
        [0.0, rng.uniform(0, 3), size + clearance + error.horizontal * (1 + rng.choice([-1e-3, 0, 1e-3]))]
    )
    turn = rng.uniform(0, 2 * np.pi)
    x, y = foot[:2] + away * np.array([np.cos(turn), np.sin(turn)])
    high = foot[2] - clearance + rng.choice([0.0, -1e-6, 1e-3, -0.5, -2.0, 0.3, 5.0, 15.0])
    low = high - rng.uniform(0.1, 4)
    named = {"solid": bool(rng.random() < 0.6)}
    match rng.integers(5):
        case 0:
            return sky.Box(min=(x - size, y - size, low), max=(x + size, y + size, high), **named)
        case 1:
            return sky.Cylinder(centre=(x, y), radius=size, low=low, high=high, **named)
        case 2:
            return Sphere(centre=(x, y, high - size), radius=size, **named)
        case 3:
            corners = [(x - size, y - size), (x + size, y - size), (x, y + size)]
            return sky.Prism(vertices=corners, low=low, high=high, **named)
    step = ((2 * size) / 3, (2 * size) / 3, (high - low) / 3)
    return Voxels(origin=(x - size, y - size, low), step=step, occupied=rng.random((3, 3, 3)) < 0.5, **named)
