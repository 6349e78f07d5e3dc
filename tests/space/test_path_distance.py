"""Distances of curves from a path are those that every pair of a curve and a leg gives."""

import numpy as np
import pytest

from skyverse.space.path_distance import farthest_ends


@pytest.mark.parametrize("seed", range(20))
def test_distances_from_a_path_are_those_of_every_leg(seed):
    rng = np.random.default_rng(seed)
    path = rng.uniform(-100, 100, (rng.integers(1, 100), 3))
    path[-1] = path[0]  # a leg without length, if there are two corners
    curves = rng.uniform(-100, 100, (rng.integers(1, 40), 1, 3)) + rng.normal(0, 5, (1, 8, 3))
    starts, ends = (path[:-1], path[1:]) if len(path) > 1 else (path, path)
    ways, some = ends - starts, curves[:, :, None] - starts
    with np.errstate(invalid="ignore"):
        shares = np.nan_to_num(np.clip(np.sum(some * ways, axis=3) / np.sum(ways**2, axis=1), 0.0, 1.0))
    away = np.linalg.norm(some - shares[..., None] * ways, axis=3)
    reached, bounds = farthest_ends(curves, path)
    assert reached == pytest.approx(away[:, [0, -1]].min(axis=2).max())
    assert bounds == pytest.approx(away.max(axis=1).min(axis=1))
