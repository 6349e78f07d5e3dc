"""Pictures that the wind turns: the largest rectangle within each, beside all rectangles, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import skyverse as sky
from skyverse.survey import lines_of
from skyverse.survey.crab import inscribed

SLOPES = np.linspace(0.0, math.pi / 2.0, 2_001)
"""The angles of the diagonals of all rectangles that are tried."""


def half_diagonals(sides, angle):
    """The greatest halves (n,) of the diagonals of rectangles that fit into one with `sides` that is turned."""
    own, other = (
        np.maximum(np.abs(np.cos(SLOPES - turn)), np.abs(np.cos(SLOPES + turn)))
        for turn in (angle, math.pi / 2.0 - angle)
    )
    return np.minimum(sides[0] / 2.0 / own, sides[1] / 2.0 / other)


@given(share=st.floats(0.05, 20.0), degrees=st.floats(0.0, 90.0))
@example(share=0.6, degrees=18.4)
@example(share=0.6, degrees=31.0)
@example(share=1.0, degrees=45.0)
@example(share=0.6, degrees=90.0)
def test_no_rectangle_within_a_turned_one_is_larger(share, degrees):
    angle, sides = math.radians(degrees), (100.0, 100.0 * share)
    along, across = inscribed(sides, angle)
    c, s = math.cos(angle), math.sin(angle)
    assert along > 0.0
    assert across > 0.0
    assert along * c + across * s <= sides[0] * (1.0 + 1e-9)
    assert along * s + across * c <= sides[1] * (1.0 + 1e-9)
    largest = (2.0 * half_diagonals(sides, angle) ** 2 * np.sin(2.0 * SLOPES)).max()
    assert along * across >= largest * (1.0 - 1e-9)


def strips_in_wind(speed, overlap):
    wing = sky.FixedWing(speed=15.0, turn_radius=40.0, climb=7.5, max_wind=14.9)
    limits = {"max_speed": 40.0, "max_acceleration": 8.0, "max_climb": 7.5, "fixed_wing": wing}
    scenario = sky.Scenario.model_validate(
        {
            "name": "field",
            "clearance": 2.0,
            "bounds": {"min": (-1500, -1500, 0), "max": (2500, 2500, 300)},
            "uavs": [{"start": (0.0, -600.0, 120.0), "end": "home"} | limits],
            "surveys": [sky.Survey([(0, 0), (500, 0), (500, 400), (0, 400)], "mavic-3e", gsd="4 cm", overlap=overlap)],
            "wind": {"velocity": (speed, 0.0, 0.0)},
        }
    )
    return lines_of(scenario, 0).lines


def test_in_a_strong_wind_strips_are_more():
    assert len(strips_in_wind(0.0, (0, 0))) < len(strips_in_wind(11.0, (0, 0)))


def test_an_overlap_that_turned_photos_cannot_have_is_told_with_what_they_can():
    with pytest.raises(sky.InputError, match=r"^overlap: expected less than 75 %.* by up to 47 degrees, found 85 %"):
        strips_in_wind(11.0, (75, 85))
    assert strips_in_wind(11.0, (75, 74))
