"""Checks a mission by dense sampling, at 10 kHz and at random instants, without any code of the referee."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder

import skyverse as sky
from skyverse.model.shapes import Sphere, Terrain, Voxels

RATE = 1e4  # Hz
G = 9.81
WEIGHT = np.array([0, 0, G])


class Motion(NamedTuple):
    """(m, 3) each."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray


def moving(trajectory: sky.Trajectory, piece: int, local: np.ndarray) -> Motion:
    """Evaluate one piece at seconds since its knot."""
    rows, motion = trajectory.coefficients[piece], []
    for _ in range(4):
        motion.append(np.vander(local, len(rows), increasing=True) @ rows)
        rows = polyder(rows, axis=0) if len(rows) > 1 else np.zeros((1, 3))
    return Motion(*motion)


def sampled(trajectory: sky.Trajectory, seed: int = 0) -> tuple[np.ndarray, Motion]:
    """Return instants and the motion then: every 0.1 ms, both ends of each piece, and random ones."""
    rng = np.random.default_rng(seed)
    times, motions = [], []
    for piece, (begin, end) in enumerate(zip(trajectory.knots[:-1], trajectory.knots[1:], strict=True)):
        grid = np.arange(0, end - begin, 1 / RATE)
        local = np.concatenate([grid, [end - begin], rng.uniform(0, end - begin, 50 + len(grid) // 20)])
        times.append(begin + local)
        motions.append(moving(trajectory, piece, local))
    return np.concatenate(times), Motion(*(np.concatenate(column) for column in zip(*motions, strict=True)))


def peaks(uav: sky.UAV, motion: Motion) -> dict[str, float]:
    """Return the largest norms, the largest tilt (degrees), and thrust (in weights)."""
    f = motion.acceleration + WEIGHT
    return {
        "speed": float(norm(motion.velocity).max()),
        "acceleration": float(norm(motion.acceleration).max()),
        "jerk": float(norm(motion.jerk).max()),
        "tilt": float(np.degrees(np.arctan2(np.hypot(f[:, 0], f[:, 1]), f[:, 2])).max()),
        "thrust": float(norm(f).max()) / G,
    }


def norm(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths."""
    return np.sqrt((vectors**2).sum(axis=1))


def excess(scenario: sky.Scenario, uav: sky.UAV, motion: Motion) -> dict[sky.Fault, np.ndarray]:
    """Return by how much each instant is worse than what is let pass: metres, or shares of the limit."""
    p, v, a, j = motion
    found = {
        sky.Fault.TRAJECTORY_BOUNDS: np.maximum(scenario.bounds.min - p, p - scenario.bounds.max).max(axis=1) - 1e-6,
        sky.Fault.TRAJECTORY_CLEARANCE: depth(scenario, p) - 1e-6,
        sky.Fault.SPEED: norm(v) / uav.max_speed - 1 - 1e-6,
        sky.Fault.ACCELERATION: norm(a) / uav.max_acceleration - 1 - 1e-6,
    }
    if uav.max_climb is not None:
        found[sky.Fault.CLIMB_RATE] = v[:, 2] / uav.max_climb - 1 - 1e-6
    if uav.max_descent is not None:
        found[sky.Fault.DESCENT_RATE] = -v[:, 2] / uav.max_descent - 1 - 1e-6
    wing = uav.fixed_wing
    if wing is None:
        f = a + WEIGHT
        found[sky.Fault.JERK] = norm(j) / uav.max_jerk - 1 - 1e-6
        found[sky.Fault.THRUST] = norm(f) / (uav.thrust_to_weight * G) - 1 - 1e-6
        tilt = np.degrees(np.arctan2(np.hypot(f[:, 0], f[:, 1]), f[:, 2]))
        found[sky.Fault.TILT] = tilt / uav.max_tilt - 1 - 1e-6
        return found
    level = np.hypot(v[:, 0], v[:, 1])
    share = level / wing.speed
    found[sky.Fault.AIRSPEED] = np.maximum(share / 1.01, 0.99 / np.maximum(share, 1e-9)) - 1 - 1e-6
    bend = np.abs(v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]) * wing.turn_radius
    found[sky.Fault.TURN] = bend / np.maximum(level, 1e-9) ** 3 - 1 - 1e-6
    found[sky.Fault.CLIMB] = np.degrees(np.arctan2(np.abs(v[:, 2]), level)) / wing.climb - 1 - 1e-6
    return found


def depth(scenario: sky.Scenario, p: np.ndarray) -> np.ndarray:
    """Return how deep positions are inside the deepest grown obstacle, too near to the ground or too high, metres."""
    deepest = np.full(len(p), -np.inf)
    lowest, highest = p.min(axis=0), p.max(axis=0)
    for shape in scenario.obstacles:
        if isinstance(shape, sky.Box):
            low, high = np.array(shape.min) - scenario.clearance, np.array(shape.max) + scenario.clearance
            high[2] = np.inf if shape.closed_above else high[2]
            if np.all(low < highest) and np.all(high > lowest):
                deepest = np.maximum(deepest, np.minimum(p - low, high - p).min(axis=1))
        elif isinstance(shape, Voxels):
            step = np.array(shape.step)
            for cell in np.argwhere(shape.occupied):
                low = np.array(shape.origin) + cell * step - scenario.clearance
                high = low + step + 2 * scenario.clearance
                high[2] = np.inf if shape.closed_above else high[2]
                deepest = np.maximum(deepest, np.minimum(p - low, high - p).min(axis=1))
        elif isinstance(shape, Sphere):
            deepest = np.maximum(deepest, shape.radius + scenario.clearance - norm(p - np.array(shape.centre)))
        else:
            away = beside(shape, p[:, :2]) if isinstance(shape, sky.Prism) else about(shape, p[:, :2])
            high = np.inf if shape.closed_above else shape.high
            away = np.maximum(away, np.maximum(shape.low - p[:, 2], p[:, 2] - high))
            deepest = np.maximum(deepest, scenario.clearance - away)
    if scenario.terrain is not None:
        own = scenario.terrain.clearance
        keep = scenario.clearance if own is None else own
        heights = ground(scenario.terrain, p[:, :2])
        deepest = np.maximum(deepest, heights + keep - p[:, 2])
        if scenario.max_height is not None:
            lowest = ground(scenario.terrain.lowest_ground, p[:, :2])
            deepest = np.maximum(deepest, p[:, 2] - lowest - scenario.max_height)
    return deepest


def about(cylinder: sky.Cylinder, xy: np.ndarray) -> np.ndarray:
    """Return the distances from a circle, negative inside."""
    return norm(xy - np.array(cylinder.centre)) - cylinder.radius


def beside(prism: sky.Prism, xy: np.ndarray) -> np.ndarray:
    """Return the distances from a polygon with holes, negative inside: what is inside is turned round by more edges."""
    away, turned = np.full(len(xy), np.inf), np.zeros(len(xy))
    for ring in (prism.vertices, *prism.holes):
        total = np.zeros(len(xy))
        for a, b in zip(np.array(ring), np.roll(ring, -1, axis=0), strict=True):
            share = np.clip((xy - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            away = np.minimum(away, norm(a + share[:, None] * (b - a) - xy))
            one, two = a - xy, b - xy
            total += np.arctan2(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1))
        turned += np.abs(total) > np.pi
    return np.where(turned == 1, -away, away)


def ground(terrain: Terrain, xy: np.ndarray) -> np.ndarray:
    """Return the heights of the ground, bilinear: first along x, then along y."""
    index = (xy - np.array(terrain.origin)) / np.array(terrain.step)
    i, j = np.clip(np.floor(index), 0, np.array(terrain.heights.shape) - 2).astype(int).T
    u, v = (index - np.column_stack([i, j])).T
    south = terrain.heights[i, j] * (1 - u) + terrain.heights[i + 1, j] * u
    north = terrain.heights[i, j + 1] * (1 - u) + terrain.heights[i + 1, j + 1] * u
    return south * (1 - v) + north * v


def where(trajectory: sky.Trajectory | None, start: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return where a UAV is, (m, 3): at its start before it flies, and where it ended afterwards."""
    if trajectory is None:
        return np.tile(start, (len(t), 1))
    inside = np.clip(t, trajectory.knots[0], trajectory.knots[-1])
    places = np.empty((len(t), 3))
    pieces = np.clip(np.searchsorted(trajectory.knots, inside, side="right") - 1, 0, len(trajectory.coefficients) - 1)
    for piece in np.unique(pieces):
        these = pieces == piece
        rows = trajectory.coefficients[piece]
        places[these] = np.vander(inside[these] - trajectory.knots[piece], len(rows), increasing=True) @ rows
    places[t < trajectory.knots[0]] = start
    return places


def nearness(a: sky.Trajectory, b: sky.Trajectory, axes: tuple[float, float, float]) -> float:
    """Return how near two UAVs ever come, as a share of an ellipsoid's semi-axes."""
    t = np.arange(0, max(a.end, b.end) + 1 / RATE, 1 / RATE)
    one, other = where(a, a.coefficients[0, 0], t), where(b, b.coefficients[0, 0], t)
    return float(norm((one - other) / axes).min())
