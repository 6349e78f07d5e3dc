"""An autopilot that holds heights above ground, and an oracle of where it may be; no code of the exporter.

It knows some ground between the terrain's `lowest` and its `heights`, cuts corners within the acceptance radius, is
beside its legs by the rounding of files, and strays by its tracking error.
"""

import numpy as np

SIDEWAYS = 0.0157
"""Metres: 1e-7 degrees of latitude and of longitude, cut off."""


def height(terrain, surface, places):
    """Bilinear ground, (...), of `surface`, (nx, ny), at places (..., 2); metres."""
    at = (places - np.array(terrain.origin)) / np.array(terrain.step)
    at = np.clip(at, 0, np.array(surface.shape) - 1)
    i = np.minimum(at.astype(int), np.array(surface.shape) - 2)
    (u, v), (k, m) = np.moveaxis(at - i, -1, 0), np.moveaxis(i, -1, 0)
    west, east = (surface[k + d, m] * (1 - v) + surface[k + d, m + 1] * v for d in (0, 1))
    return west * (1 - u) + east * u


def heights_above(terrain, points):
    """Points (n, 3) with heights above `heights` instead of z."""
    above = np.array(points, dtype=float)
    above[:, 2] -= height(terrain, terrain.heights, above[:, :2])
    return above


def ways(above, radius, stops, rng, steps, count):
    """Places on legs and on what is flown where corners are cut, (n, 3), with heights above ground."""
    shares, found, begins = np.linspace(0, 1, steps)[:, None], [], [above[0]] * count
    for k in range(1, len(above)):
        found += [a + shares * (above[k] - a) for a in [above[k - 1], *begins]]
        cut = [0.0] * count if stops[k] or k == len(above) - 1 else [*rng.uniform(0, radius, count - 2), radius, radius]
        turned = []
        for j, (a, metres) in enumerate(zip(begins, cut, strict=True)):
            way = (a if j % 2 else above[k - 1]) - above[k]
            length = np.linalg.norm(way)
            turned.append(above[k] + (way * min(1.0, metres / length) if length else 0.0 * way))
        begins = turned
    return np.concatenate(found)


def flown(scenario, above, error, rng):
    """Local metres (n, 3) at which a UAV may be that ought to be at `above`, (n, 3), with heights above ground."""
    terrain, count = scenario.terrain, len(above)
    lowest = terrain.heights if terrain.lowest is None else terrain.lowest
    reference = above[:, :2] + SIDEWAYS * disc(count, rng, edge=0.5)
    strayed = reference + error.horizontal * disc(count, rng, edge=0.7)
    knows = reference if rng.random() < 0.5 else strayed  # GPS errs, or the controller does
    kind = rng.integers(4)
    share = [np.zeros(count), np.ones(count), rng.uniform(size=count), rng.integers(0, 2, count)][kind]
    low, high = (height(terrain, surface, knows) for surface in (lowest, terrain.heights))
    up = error.vertical * rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], count)
    return np.column_stack([strayed, low + share * (high - low) + above[:, 2] + up])


def disc(count, rng, edge):
    """Places in the unit disc, (count, 2), a share of them at its edge."""
    turn = rng.uniform(0, 2 * np.pi, count)
    radius = np.where(rng.random(count) < edge, 1.0, np.sqrt(rng.random(count)))
    return radius[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


def rooms(scenario, points):
    """Metres that are left to obstacles (boxes), to the ground and to the ceiling, the least of points (n, 3)."""
    terrain = scenario.terrain
    lowest = terrain.heights if terrain.lowest is None else terrain.lowest
    gaps = [np.inf]
    for box in scenario.obstacles:
        away = np.maximum(np.maximum(np.array(box.min) - points, points - np.array(box.max)), 0.0)
        gaps.append(float(np.linalg.norm(away, axis=1).min()))
    ground = float((points[:, 2] - height(terrain, terrain.heights, points[:, :2])).min())
    high = float((points[:, 2] - height(terrain, lowest, points[:, :2])).max())
    most = np.inf if scenario.max_height is None else scenario.max_height
    return min(gaps) - scenario.clearance, ground - scenario.ground_clearance, most - high
