"""What the referee knows of prisms before it judges: how thick they are, and whether they are convex."""

import numpy as np
import pytest

from judged_clearance import world
from skyverse.model.shapes import Prism
from skyverse.referee.closed_above import solid_shapes
from skyverse.referee.prisms import grown_prisms

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
COURT = ((0.5, 0.5), (1.5, 0.5), (1.5, 1.5), (0.5, 1.5))
OUTLINES = {
    "square": (SQUARE, (), 1.0, True),
    "clockwise": (SQUARE[::-1], (), 1.0, True),
    "courtyard": (SQUARE, (COURT,), 0.5, False),
    "two courtyards": (tuple((2 * x, y) for x, y in SQUARE), (COURT, tuple((x + 2, y) for x, y in COURT)), 0.6, False),
    "L": (((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)), (), 10 / 12, False),
    "triangle": (((0, 0), (4, 0), (0, 3)), (), 1.0, True),
    "with a straight corner": (((0, 0), (1, 0), (2, 0), (2, 2), (0, 2)), (), 1.0, True),
}


def grown(*names, clearance=0.0):
    prisms = [Prism(vertices=OUTLINES[name][0], holes=OUTLINES[name][1], low=1, high=3) for name in names]
    return grown_prisms(solid_shapes(world(*prisms, clearance=clearance)))


@pytest.mark.parametrize("clearance", [0.0, 0.25])
def test_the_mean_thickness_is_twice_the_area_by_the_length_of_all_edges(clearance):
    prisms = grown(*OUTLINES, clearance=clearance)
    expected = [thickness + 2 * clearance for _, _, thickness, _ in OUTLINES.values()]
    np.testing.assert_allclose(prisms.outlines.thickness + 2 * clearance, expected, rtol=1e-12)
    np.testing.assert_allclose(prisms.thicknesses(), np.minimum(expected, 2 + 2 * clearance), rtol=1e-5)
    assert not prisms.thin.any()


def test_prisms_without_holes_that_turn_one_way_are_convex():
    prisms = grown(*OUTLINES)
    assert [prisms.is_convex(k) for k in range(len(OUTLINES))] == [convex for *_, convex in OUTLINES.values()]


@pytest.mark.parametrize(("width", "thin"), [(9.9e-6, True), (1.1e-5, False)])
def test_a_slanted_sliver_is_thin_though_the_box_about_it_is_not(width, thin):
    sliver = Prism(
        vertices=((1, 1), (4, 5), (4 - width * 0.8, 5 + width * 0.6), (1 - width * 0.8, 1 + width * 0.6)), low=1, high=3
    )
    assert grown_prisms(solid_shapes(world(sliver, clearance=0.0))).thin.tolist() == [thin]
    assert not grown_prisms(solid_shapes(world(sliver, clearance=0.1))).thin.any()


def test_a_sliver_gives_way_by_a_quarter_of_its_thickness_at_most():
    sliver = Prism(vertices=((1, 1), (5, 1), (5, 1 + 1e-7), (1, 1 + 1e-7)), low=1, high=3)
    assert grown_prisms(solid_shapes(world(sliver, clearance=0.0))).grown_by == pytest.approx([-0.25e-7], rel=1e-3)
    assert grown_prisms(solid_shapes(world(sliver, clearance=0.5))).grown_by == pytest.approx([0.5 - 1e-6], rel=1e-12)


def test_of_no_prisms_there_are_no_boxes():
    assert [corners.shape for corners in grown().hulls()] == [(0, 3), (0, 3)]


@pytest.mark.parametrize("below", [5e-6, 0.5])
def test_a_place_beside_a_prism_is_outside_however_little_it_is_below_the_roof(below):
    assert grown("square").depth(np.array([[[5.0, 1.0, 3.0 - below]]]), np.array([0]))[0] == pytest.approx(-3, abs=1e-5)


def test_some_prisms_keep_their_own_outlines_and_altitudes():
    prisms = grown(*OUTLINES, clearance=0.25)
    some = prisms.of(np.array([4, 2]))
    for name, k in (("L", 0), ("courtyard", 1)):
        (alone,) = (grown(name, clearance=0.25),)
        for one, other in zip(some.outlines.of(np.array([k])), alone.outlines, strict=True):
            assert one.tolist() == other.tolist()
        assert [corners[k].tolist() for corners in some.hulls()] == [corners[0].tolist() for corners in alone.hulls()]
