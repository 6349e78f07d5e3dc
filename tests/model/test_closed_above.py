"""What is closed above reaches beyond the bounds, from the shape itself on."""

import numpy as np
import pytest

from skyverse.model.shape_extent import ABOVE_BOUNDS, extruded
from skyverse.model.shapes import Box, Cylinder, Prism, Sphere, Voxels

SQUARE = ((4.0, 4.0), (6.0, 4.0), (6.0, 6.0), (4.0, 6.0))
OVER = {"closed_above": True}


def closed(shape, kind):
    """The shape of one kind that a shape in bounds that end at 10 m becomes when it is closed above."""
    (found,) = (one for one in extruded(shape, 10.0) if type(one) is kind)
    return found


@pytest.mark.parametrize(("top", "end"), [(2.0, 10.0), (12.0, 12.0)])
def test_upper_faces_are_raised_beyond_the_higher_of_shape_and_bounds(top, end):
    assert closed(Box(min=(4, 4, 0), max=(6, 6, top), **OVER), Box).max == (6, 6, end + ABOVE_BOUNDS)
    assert closed(Cylinder(centre=(5, 5), radius=1, low=0, high=top, **OVER), Cylinder).high == end + ABOVE_BOUNDS
    assert closed(Prism(vertices=SQUARE, low=0, high=top, **OVER), Prism).high == end + ABOVE_BOUNDS
    above = closed(Sphere(centre=(5, 5, top - 1), radius=1, **OVER), Cylinder)
    assert (above.centre, above.radius, above.low, above.high) == ((5, 5), 1, top - 1, end + ABOVE_BOUNDS)


@pytest.mark.parametrize("origin", [-8.0, 0.0, 7.0])
def test_each_column_of_voxels_is_filled_from_its_lowest_on(origin):
    occupied = np.zeros((1, 2, 3), dtype=bool)
    occupied[0, 1, 1] = True
    found = closed(Voxels(origin=(4, 4, origin), step=(1, 1, 2), occupied=occupied, **OVER), Voxels)
    end = origin + 2 * found.occupied.shape[2]
    assert 10 + ABOVE_BOUNDS <= end < 10 + ABOVE_BOUNDS + 2
    assert not found.occupied[0, 0].any()
    assert found.occupied[0, 1].tolist() == [False] + [True] * (found.occupied.shape[2] - 1)
