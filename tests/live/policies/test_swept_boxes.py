"""Boxes hold movers wherever they may be."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.live import swept_boxes
from skyverse.model.temporary_zones import TimedShape

BALL = sky.Sphere(centre=(0, 0, 0), radius=0.4)
BRICK = sky.Box(min=(-0.5, -0.1, 0), max=(0.5, 0.1, 1))
TUBE = sky.Cylinder(centre=(0.2, 0), radius=0.3, low=-1, high=2)
DISC = sky.Ellipsoid(centre=(0, 0, 0), semi_axis_xy=1.0, semi_axis_z=0.5)


def mover(shape, doubt, keep=0.2):
    motion = sky.WaypointMotion(points=[(0, 0, 0), (4, 2, 1)], times=[0, 4])
    return TimedShape(shape, motion, doubt, keep)


def inside(boxes, point, keep):
    return any(
        np.all((np.array(b.min) - keep <= point + 1e-9) & (point <= np.array(b.max) + keep + 1e-9)) for b in boxes
    )


@pytest.mark.parametrize("shape", [BALL, BRICK, TUBE, DISC])
@pytest.mark.parametrize(
    "doubt", [sky.Doubt(radius=0.1), sky.Doubt(growth=0.5), sky.Doubt(growth=0.5, since=1.0, top_speed=0.6)]
)
def test_a_mover_is_in_them_wherever_it_may_be(shape, doubt):
    one, rng = mover(shape, doubt), np.random.default_rng(3)
    boxes = swept_boxes([one], 1.0, 3.0, 0.2, ())
    for t in np.linspace(1.0, 3.0, 41):
        at, off = one.motion.at([t])[0], float(doubt.at(t)[0])
        for _ in range(20):
            way = rng.normal(size=3)
            moved = at + off * way / np.linalg.norm(way)
            if doubt.top_speed is not None:
                seen = one.motion.at([doubt.since])[0]
                if np.linalg.norm(moved - seen) > doubt.radius + doubt.top_speed * (t - doubt.since):
                    continue
            for corner in rng.uniform(-1, 1, (20, 3)) * 2.5:
                if contains(shape, corner):
                    assert inside(boxes, moved + corner, 0.0)


def contains(shape, at):
    """Whether a point is in a shape, by its definition."""
    if isinstance(shape, sky.Box):
        return np.all((np.array(shape.min) <= at) & (at <= np.array(shape.max)))
    if isinstance(shape, sky.Sphere):
        return np.linalg.norm(at - np.array(shape.centre)) <= shape.radius
    if isinstance(shape, sky.Cylinder):
        return np.hypot(*(at[:2] - np.array(shape.centre))) <= shape.radius and shape.low <= at[2] <= shape.high
    level, up = np.hypot(at[0], at[1]) / shape.semi_axis_xy, at[2] / shape.semi_axis_z
    return level**2 + up**2 <= 1


def test_boxes_around_the_ends_of_a_path_are_left_out():
    one = mover(BALL, sky.Doubt())
    whole = swept_boxes([one], 0.0, 4.0, 0.2, ())
    assert len(whole) == 4
    assert len(swept_boxes([one], 0.0, 4.0, 0.2, [np.array([-0.5, 0.0, 0.0])])) == 3
    assert len(swept_boxes([one], 0.0, 4.0, 0.2, [np.array([-0.7, 0.0, 0.0])])) == 4
