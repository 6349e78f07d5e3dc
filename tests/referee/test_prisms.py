"""What the referee knows of prisms: where they are, and how deep a place is in them."""

import numpy as np
import pytest

from judged_clearance import world
from skyverse.model.shapes import Prism
from skyverse.referee.prisms import grown_prisms
from skyverse.referee.solid_shapes import solid_shapes

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
COURT = ((0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5))
OUTLINES = {
    "square": (SQUARE, ()),
    "courtyard": (SQUARE, (COURT,)),
    "two courtyards": (tuple((2 * x, y) for x, y in SQUARE), (COURT, tuple((x + 2, y) for x, y in COURT))),
    "L": (((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)), ()),
}


def grown(*names, clearance=0.001):
    prisms = [Prism(vertices=OUTLINES[name][0], holes=OUTLINES[name][1], low=1, high=3) for name in names]
    return grown_prisms(solid_shapes(world(*prisms, clearance=clearance)))


def test_of_no_prisms_there_are_no_boxes():
    assert [corners.shape for corners in grown().hulls()] == [(0, 3), (0, 3)]


@pytest.mark.parametrize("below", [5e-6, 0.5])
def test_a_place_beside_a_prism_is_outside_however_little_it_is_below_the_roof(below):
    place = np.array([[[5.0, 1.0, 3.001 - below]]])
    assert grown("square").depth(place, np.array([0]))[0] == pytest.approx(0.001 - 3, abs=1e-5)


def test_some_prisms_keep_their_own_outlines_and_altitudes():
    prisms = grown(*OUTLINES, clearance=0.25)
    some = prisms.of(np.array([3, 1]))
    for name, k in (("L", 0), ("courtyard", 1)):
        alone = grown(name, clearance=0.25)
        for one, other in zip(some.outlines.of(np.array([k])), alone.outlines, strict=True):
            assert one.tolist() == other.tolist()
        assert [corners[k].tolist() for corners in some.hulls()] == [corners[0].tolist() for corners in alone.hulls()]
