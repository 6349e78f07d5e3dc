"""How deep places are inside grown obstacles and under what must be kept above ground, by brute force."""

import numpy as np
from matplotlib.path import Path as Outline
from scipy.interpolate import RegularGridInterpolator

from skyverse.model.shapes import Box, Cylinder, Prism, Sphere


def depth(scenario, p, margin=0.0):
    """(n, 3) places to (n,) metres inside whatever is deepest there; below zero outside all.

    A margin is kept beside the clearance.
    """
    deep = [np.full(len(p), -np.inf), *(inside(shape, scenario.clearance + margin, p) for shape in scenario.obstacles)]
    if scenario.terrain is not None:
        own = scenario.terrain.clearance
        deep.append(above(scenario.terrain, p[:, :2]) + (scenario.clearance if own is None else own) + margin - p[:, 2])
    if scenario.max_height is not None:
        deep.append(p[:, 2] - above(scenario.terrain.lowest_ground, p[:, :2]) - scenario.max_height + margin)
    return np.max(deep, axis=0)


def above(terrain, xy):
    """The bilinear ground."""
    axes = [o + d * np.arange(n) for o, d, n in zip(terrain.origin, terrain.step, terrain.heights.shape, strict=True)]
    return RegularGridInterpolator(axes, terrain.heights, bounds_error=False, fill_value=None)(xy)


def inside(shape, clearance, p):
    if isinstance(shape, Box):
        return boxed(np.array(shape.min), np.array(shape.max), clearance, p)
    if isinstance(shape, Sphere):
        return shape.radius + clearance - np.linalg.norm(p - shape.centre, axis=1)
    if isinstance(shape, Cylinder):
        level = shape.radius + clearance - np.linalg.norm(p[:, :2] - shape.centre, axis=1)
    elif isinstance(shape, Prism):
        level = clearance - outside(shape, p[:, :2])
    else:
        step = np.array(shape.step)
        corners = np.array(shape.origin) + np.argwhere(shape.occupied) * step
        each = [boxed(corner, corner + step, clearance, p) for corner in corners]
        return np.max([np.full(len(p), -np.inf), *each], axis=0)
    upright = np.minimum(p[:, 2] - shape.low + clearance, shape.high + clearance - p[:, 2])
    return np.minimum(level, upright)


def boxed(low, high, clearance, p):
    return np.minimum(p - low + clearance, high + clearance - p).min(axis=1)


def outside(prism, xy):
    """Distance to the polygon less its holes; negative inside."""
    nearest, within = np.full(len(xy), np.inf), np.zeros(len(xy), dtype=bool)
    for ring in (prism.vertices, *prism.holes):
        corners = np.array(ring)
        within ^= Outline(corners).contains_points(xy)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            share = np.clip((xy - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            nearest = np.minimum(nearest, np.linalg.norm(a + share[:, None] * (b - a) - xy, axis=1))
    return np.where(within, -nearest, nearest)
