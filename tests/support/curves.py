"""Random flights for tests of separation."""

import numpy as np

import skyverse as sky


def random_flight(rng):
    """A polynomial of any degree up to 7, continuous, in up to four pieces."""
    pieces = int(rng.integers(1, 5))
    durations = rng.uniform(0.3, 2.0, pieces)
    degree = int(rng.integers(1, 8))
    rows = rng.normal(0, 1, (pieces, degree + 1, 3)) * 1.5 / (1.0 + np.arange(degree + 1))[None, :, None] ** 2
    for k in range(1, pieces):
        rows[k, 0] = np.sum(rows[k - 1] * durations[k - 1] ** np.arange(degree + 1)[:, None], axis=0)
    return sky.Trajectory(rng.uniform(0, 2) + np.r_[0.0, np.cumsum(durations)], rows)
