"""The fewest points between least and greatest heights, beside the best of all polylines on a fine grid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skyverse.survey.heights import fewest_points, gentle, linked

HEIGHTS = 31


def tube(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 11))
    at, ground = np.cumsum(rng.uniform(1, 5, n)), np.cumsum(rng.normal(0, 3, n))
    steepest = float(rng.choice([0.5, 1.0, 5.0]))
    high = gentle(at, ground + rng.uniform(0.2, 4, n), steepest, 1.0)
    low = gentle(at, np.minimum(ground - rng.uniform(0.2, 4, n), high), steepest, -1.0)
    return at, low, high, steepest


def fewest_on_a_grid(at: np.ndarray, low: np.ndarray, high: np.ndarray, steepest: float) -> int:
    """Return the fewest links of all polylines whose points lie on a grid of places and heights."""
    places = np.unique(np.r_[at, np.concatenate([at[:-1] + share * np.diff(at) for share in (0.25, 0.5, 0.75)])])
    least, most = np.interp(places, at, low), np.interp(places, at, high)
    z = np.linspace(least, most, HEIGHTS, axis=1)
    links = np.full(z.shape, 10**6)
    links[0] = 0
    for i, k in np.ndindex(z.shape):
        down, up = -steepest - 1e-9, steepest + 1e-9
        for j in range(i + 1, len(places)):
            run = places[j] - places[i]
            down, up = max(down, (least[j] - z[i, k] - 1e-6) / run), min(up, (most[j] - z[i, k] + 1e-6) / run)
            if down > up:
                break
            slope = (z[j] - z[i, k]) / run
            free = (slope >= down) & (slope <= up)
            links[j, free] = np.minimum(links[j, free], links[i, k] + 1)
    return int(links[-1].min())


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_no_polyline_between_the_limits_has_fewer_points(seed):
    at, low, high, steepest = tube(seed)
    points = fewest_points(at, low, high, steepest)
    assert points[0, 0] == at[0]
    assert points[-1, 0] == at[-1]
    assert (np.diff(points[:, 0]) >= 0).all()
    every = np.unique(np.r_[at, points[:, 0]])
    z = np.interp(every, *points.T)
    assert (np.interp(every, at, low) - 1e-5 <= z).all()
    assert (z <= np.interp(every, at, high) + 1e-5).all()
    rises, runs = np.abs(np.diff(points[:, 1])), np.diff(points[:, 0])
    assert (rises <= steepest * runs + 1e-5).all()
    assert len(points) - 1 <= fewest_on_a_grid(at, low, high, steepest)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([1.0, -1.0]))
def test_gentle_heights_are_the_nearest_that_are_nowhere_too_steep(seed, side):
    rng = np.random.default_rng(seed)
    at, z = np.cumsum(rng.uniform(0.5, 3, 12)), rng.normal(0, 5, 12)
    cones = z[None] + side * 0.7 * np.abs(at[:, None] - at[None])
    expected = cones.min(axis=1) if side > 0 else cones.max(axis=1)
    assert gentle(at, z, 0.7, side) == pytest.approx(expected)


def test_over_level_ground_two_points_are_enough():
    at = np.linspace(0.0, 500.0, 200)
    assert len(fewest_points(at, np.full(200, 60.0), np.full(200, 60.0), 1.0)) == 2


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.5, 30.0))
def test_links_are_long_enough_nowhere_too_steep_and_nowhere_above_the_limit(seed, least):
    at, low, high, steepest = tube(seed)
    points = fewest_points(at, low, high, steepest)
    kept = linked(points, at, high, steepest, least)
    runs, rises = np.diff(kept[:, 0]), np.abs(np.diff(kept[:, 1]))
    assert kept[0, 0] == at[0]
    assert kept[-1, 0] == at[-1]
    assert (runs >= least * (1 - 1e-9)).all() or len(kept) == 2
    assert (rises <= steepest * runs * np.minimum(runs / least, 1.0) + 1e-5).all()
    every = np.unique(np.r_[at, kept[:, 0]])
    z = np.interp(every, *kept.T)
    assert (z <= np.interp(every, at, high) + 1e-5).all()
    # no lower than what is lost between bends: by half a link's rise where they are set, and by as much again
    reach = max(runs.max(), least) if len(kept) == 2 else 2.0 * least
    assert (z >= np.interp(every, *points.T) - steepest * reach - 1e-5).all()
