"""Boxes that are seen through are drawn as one solid: no wall inside it is darker than the others."""

import numpy as np
import pytest

import skyverse as sky
from skyverse.draw import touching, united


def enclosed(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.sum(a * np.cross(b, c)) / 6


def area(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def test_a_party_wall_is_not_drawn():
    made = united([sky.Box(min=(0, 0, 0), max=(2, 3, 4)), sky.Box(min=(2, 0, 0), max=(5, 3, 4))])
    assert enclosed(*made) == pytest.approx(60)
    assert area(*made) == pytest.approx(2 * (15 + 20 + 12))


def test_boxes_that_overlap_have_one_surface():
    boxes = [sky.Box(min=(0, 0, 0), max=(2, 2, 2)), sky.Box(min=(1, 1, 1), max=(3, 3, 3))]
    assert enclosed(*united(boxes)) == pytest.approx(15)
    assert area(*united(boxes)) == pytest.approx(48 - 6)
    assert enclosed(*united([*boxes, sky.Box(min=(10, 0, 0), max=(11, 1, 1))])) == pytest.approx(16)


def test_only_boxes_that_touch_are_taken_together():
    boxes = [sky.Box(min=(k, 0, 0), max=(k + 1, 1, 1)) for k in (0, 1, 3, 5.5)]
    assert touching([sky.Sphere(centre=(0, 0, 0), radius=1), *boxes]) == {1, 2}
    assert touching(boxes[1:]) == set()


def test_too_many_boxes_stay_apart():
    rng = np.random.default_rng(0)
    corners = rng.uniform(0, 100, (100, 3))
    assert united([sky.Box(min=tuple(low), max=tuple(low + 1)) for low in corners]) is None
