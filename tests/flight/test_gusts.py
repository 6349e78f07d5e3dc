"""Gusts against the closed forms of MIL-F-8785C."""

import numpy as np
import pytest
from scipy.signal import welch

from skyverse.flight import FOOT, gust_scales, gusts

COUNT, PERIOD, AIRSPEED = 2_000_000, 0.1, 10.0


@pytest.fixture(scope="module")
def blown():
    """Gusts of a west wind of 8 m/s at 30 m, for 55 hours: along it, across it (towards north) and upwards."""
    normals = np.random.default_rng(1).standard_normal((COUNT, 5))
    return gusts(np.full(COUNT, 30.0), np.full(COUNT, AIRSPEED), (8.0, 0.0, 0.0), PERIOD, normals)


def test_intensities_and_lengths_are_those_of_the_specification():
    scales = gust_scales(np.array([1.0, 100 * FOOT, 1000 * FOOT, 5000.0]), 10.0)
    assert scales.vertical_intensity == 1.0
    # by hand, for 10, 100, 1000 and again 1000 feet
    assert scales.horizontal_intensity == pytest.approx([1.9629, 1.7158, 1.0, 1.0], rel=1e-3)
    assert scales.vertical_length / FOOT == pytest.approx([10, 100, 1000, 1000])
    assert scales.horizontal_length / FOOT == pytest.approx([75.64, 505.2, 1000, 1000], rel=1e-3)


def test_variances_are_the_squared_intensities(blown):
    scales = gust_scales(np.array([30.0]), 8.0)
    level = scales.horizontal_intensity[0]
    assert blown.std(axis=0) == pytest.approx([level, level, scales.vertical_intensity], rel=0.02)
    assert np.abs(np.corrcoef(blown.T) - np.eye(3)).max() < 0.01


@pytest.mark.parametrize("lag", [1, 5, 20, 60])
def test_autocorrelations_are_the_closed_forms(blown, lag):
    scales = gust_scales(np.array([30.0]), 8.0)
    for axis, length in enumerate((scales.horizontal_length[0],) * 2 + (scales.vertical_length[0],)):
        series = blown[:, axis] / blown[:, axis].std()
        t = AIRSPEED * PERIOD * lag / length
        expected = np.exp(-t) * (1.0 if axis == 0 else 1.0 - t / 2)
        assert np.mean(series[:-lag] * series[lag:]) == pytest.approx(expected, abs=0.015)


def test_spectra_are_the_closed_forms(blown):
    scales = gust_scales(np.array([30.0]), 8.0)
    hertz, density = welch(blown, 1.0 / PERIOD, nperseg=8192, axis=0)
    some = (hertz > 0.01) & (hertz < 0.5)  # below what the sampling folds back
    omega = 2 * np.pi * hertz[some]
    level, upright = scales.horizontal_length[0], scales.vertical_length[0]
    expected = [
        scales.horizontal_intensity[0] ** 2 * 2 * level / (np.pi * AIRSPEED) / (1 + (level * omega / AIRSPEED) ** 2)
    ]
    for sigma, length in ((scales.horizontal_intensity[0], level), (scales.vertical_intensity, upright)):
        share = (length * omega / AIRSPEED) ** 2
        expected.append(sigma**2 * length / (np.pi * AIRSPEED) * (1 + 3 * share) / (1 + share) ** 2)
    for axis in range(3):
        ratio = density[some, axis] / (2 * np.pi * expected[axis])  # of densities in Hz and in rad/s
        assert np.median(ratio) == pytest.approx(1.0, abs=0.05)
        assert ratio.min() > 0.6
        assert ratio.max() < 1.5


def test_gusts_follow_the_direction_of_the_wind():
    rng = np.random.default_rng(2)
    height, airspeed, normals = np.full(500, 3.0), np.full(500, 8.0), rng.standard_normal((500, 5))
    east = gusts(height, airspeed, (8.0, 0.0, 0.0), 0.01, normals)
    north = gusts(height, airspeed, (0.0, 8.0, 0.0), 0.01, normals)
    assert north == pytest.approx(np.column_stack([-east[:, 1], east[:, 0], east[:, 2]]))


def test_intensities_change_with_the_height_on_the_way():
    rng = np.random.default_rng(3)
    height = np.where(np.arange(200_000) < 100_000, 3.0, 300.0)
    blown = gusts(height, np.full(200_000, 10.0), (8.0, 0.0, 0.0), 1.0, rng.standard_normal((200_000, 5)))
    low, high = gust_scales(np.array([3.0, 300.0]), 8.0).horizontal_intensity
    assert blown[:100_000, 0].std() == pytest.approx(low, rel=0.05)
    assert blown[100_000:, 0].std() == pytest.approx(high, rel=0.1)
