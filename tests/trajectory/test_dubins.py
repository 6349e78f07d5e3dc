"""Dubins paths against integration, against anything else that is flown, and against OMPL."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyverse.trajectory.dubins import WORDS, all_words, curvature, pose

PLACE = st.one_of(st.floats(-6, 6), st.integers(-4, 4).map(float))
HEADING = st.one_of(st.floats(-7, 7), st.integers(-8, 8).map(lambda k: k * math.pi / 4))
POSES = st.tuples(PLACE, PLACE, HEADING).map(np.array)
RADII = st.sampled_from([0.3, 1.0, 2.5])


def integrated(start, bends, lengths, steps=2000):
    """Where a plane ends that flies each length at its bend: midpoint rule on x' = cos h, y' = sin h, h' = bend."""
    x, y, heading = start
    for bend, length in zip(bends, lengths, strict=True):
        ds = length / steps
        headings = heading + bend * ds * (np.arange(steps) + 0.5)
        x, y, heading = x + ds * np.cos(headings).sum(), y + ds * np.sin(headings).sum(), heading + bend * length
    return np.array([x, y, heading])


def apart(a, b):
    turn = (a[2] - b[2] + math.pi) % (2 * math.pi) - math.pi
    return max(abs(a[0] - b[0]), abs(a[1] - b[1]), abs(turn))


def shortest_path(a, b, radius):
    """The number of the shortest word, and the metres of its letters."""
    every = all_words(*map(float, a), *map(float, b), radius)
    word = int(np.argmin(every.sum(axis=1)))
    return word, every[word]


def distance(a, b, radius):
    return shortest_path(a, b, radius)[1].sum()


@given(POSES, POSES, RADII)
def test_every_word_that_has_a_way_arrives(start, end, radius):
    every = all_words(*start, *end, radius)
    assert np.isfinite(every[:2]).all()  # LSL and RSR always have one
    for word, lengths in enumerate(every):
        if np.isfinite(lengths).all():
            assert (lengths >= 0).all()
            bends = [{"L": 1, "R": -1, "S": 0}[letter] / radius for letter in WORDS[word]]
            assert bends == [curvature(word, letter, radius) for letter in range(3)]
            assert apart(integrated(start, bends, lengths), end) < 1e-4
            assert apart(pose(*start, word, *lengths[:2], radius, lengths.sum()), end) < 1e-9


@given(POSES, POSES, RADII)
def test_samples_are_as_far_apart_as_they_say_and_keep_the_radius(start, end, radius):
    word, lengths = shortest_path(start, end, radius)
    s = np.linspace(0, lengths.sum(), 400)
    poses = np.array([pose(*start, word, *lengths[:2], radius, along) for along in s])
    x, y, heading = poses.T
    assert apart(poses[0], start) < 1e-12
    assert apart(poses[-1], end) < 1e-9
    step = s[1]
    assert np.hypot(np.diff(x), np.diff(y)).max() <= step + 1e-12
    assert np.abs(np.diff(heading)).max() <= step / radius + 1e-12
    ahead = np.arctan2(np.diff(y), np.diff(x)) - 0.5 * (heading[1:] + heading[:-1])
    if step > 1e-6:
        assert np.abs((ahead + math.pi) % (2 * math.pi) - math.pi).max() <= step / radius + 1e-6


LETTERS = st.tuples(st.sampled_from([-1.0, -0.7, 0.0, 0.5, 1.0]), st.floats(0, 5))


@given(POSES, st.lists(LETTERS, min_size=1, max_size=4), RADII)
def test_nothing_that_keeps_the_radius_is_shorter(start, flown, radius):
    """Also not what has other letters, more of them, or wider turns."""
    lengths = [length * radius for _, length in flown]
    end = integrated(start, [bend / radius for bend, _ in flown], lengths, 20_000)
    # the end is known to 1e-7 or so; where the shortest length jumps, what is near the end may be much farther away
    near = [end + shift for shift in np.array([(0, 0, 0), *1e-6 * np.array([*np.eye(3), *-np.eye(3)])])]
    assert min(distance(start, e, radius) for e in near) <= sum(lengths) + 1e-5


@given(POSES, POSES, POSES, RADII)
def test_a_detour_is_never_shorter_and_euclid_never_longer(a, b, c, radius):
    assert distance(a, c, radius) <= distance(a, b, radius) + distance(b, c, radius) + 1e-7
    assert distance(a, b, radius) >= math.hypot(*(b - a)[:2]) - 1e-9


@pytest.mark.parametrize(
    ("start", "end", "length", "word"),
    [
        ((0, 0, 0), (0, 0, 0), 0, "LSL"),
        ((1, 2, 3), (1, 2, 3 - 2 * math.pi), 0, "LSL"),
        ((0, 0, 0), (10, 0, 0), 10, "LSL"),
        ((0, 0, 0), (0, 2, math.pi), math.pi, "LSL"),
        ((0, 0, 0), (0, -2, math.pi), math.pi, "RSR"),
        ((0, 0, 0), (7, 3, 0), math.sqrt(46) + 2 * (math.atan2(1, 7) + math.atan2(2, math.sqrt(46))), "LSR"),
        ((0, 0, 0), (2, 2, 0), math.pi, "LSR"),
        ((0, 0, 0), (2, -2, 0), math.pi, "RSL"),
        ((0, 0, 0), (0, 0, math.pi), 7 * math.pi / 3, "LRL"),  # turning round in place
        ((0, 0, 0), (-1e-6, 0, 0), 2 * math.pi, None),  # a step back is a full turn
    ],
)
def test_known_cases(start, end, length, word):
    found, lengths = shortest_path(start, end, 1.0)
    if word is not None:
        assert WORDS[found] == word
    assert lengths.sum() == pytest.approx(length, abs=1e-5)


def test_a_straight_way_takes_no_full_turn_through_rounding():
    rng = np.random.default_rng(0)
    for _ in range(300):
        heading, length = rng.uniform(-7, 7), 10 ** rng.uniform(-2, 4)
        start = rng.uniform(-1000, 1000, 2)
        end = start + length * np.array([math.cos(heading), math.sin(heading)])
        assert distance([*start, heading], [*end, heading], 1.0) == pytest.approx(length, abs=1e-6)


def test_lengths_are_ompl_s():
    base = pytest.importorskip("ompl.base", reason="needs the extra: pip install 'skyverse[ompl]'")
    rng = np.random.default_rng(1)
    for _ in range(500):
        radius = rng.uniform(0.3, 3)
        space = base.DubinsStateSpace(radius)
        poses = np.column_stack([rng.uniform(-4, 4, (2, 2)), rng.uniform(-math.pi, math.pi, 2)])
        states = [space.allocState(), space.allocState()]
        for state, (x, y, heading) in zip(states, poses, strict=True):
            state.setX(x), state.setY(y), state.setYaw(heading)
        assert distance(*poses, radius) == pytest.approx(space.distance(*states), abs=1e-6)
