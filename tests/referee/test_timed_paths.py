"""Two UAVs on timed paths, compared with brute force over many instants."""

from fractions import Fraction

import numpy as np
import pytest

from skyverse.model.trajectory import TimedPath
from skyverse.referee.solids import nearest_points
from skyverse.referee.timed_paths import KeptDistance, _needed, paths_apart

EPS = float(np.finfo(float).eps)


def path(points, times, late=0.0, deviation=0.0):
    points, times = np.array(points, dtype=float), np.array(times, dtype=float)
    earliest = np.stack([times[:-1], times[1:]], axis=1)
    off = np.full((len(points) - 1, 2), deviation)
    return TimedPath(points[:-1], points[1:], earliest, earliest + late, off)


@pytest.mark.parametrize("seed", range(40))
def test_the_nearest_points_of_segments_are_those_of_a_fine_grid(seed):
    rng = np.random.default_rng(seed)
    p, q, r, s = rng.uniform(-3, 3, (4, 50, 3))
    if seed % 4 == 1:
        s = r + (q - p) * rng.uniform(-2, 2, (50, 1))  # parallel
    if seed % 4 == 2:
        q = p.copy()  # a point
    if seed % 4 == 3:
        s, q = r.copy(), p.copy()
    share, other, distance = nearest_points(p, q, r, s)
    grid = np.linspace(0, 1, 81)
    a = p[:, None] + grid[None, :, None] * (q - p)[:, None]
    b = r[:, None] + grid[None, :, None] * (s - r)[:, None]
    brute = np.linalg.norm(a[:, :, None] - b[:, None], axis=3).min(axis=(1, 2))
    assert (distance <= brute + 1e-9).all()
    assert (distance >= brute - 0.2).all()
    found = p + share[:, None] * (q - p) - r - other[:, None] * (s - r)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), distance, atol=1e-12)


def exact_distance(p, q, r, s):
    """The distance of two segments (3,), by fractions: the least over the corners, the edges and the inside."""
    p, q, r, s = ([Fraction(float(x)) for x in point] for point in (p, q, r, s))

    def dot(x, y):
        return sum(a * b for a, b in zip(x, y, strict=True))

    u, v, w = ([a - b for a, b in zip(x, y, strict=True)] for x, y in ((q, p), (s, r), (p, r)))
    uu, uv, vv, uw, vw = dot(u, u), dot(u, v), dot(v, v), dot(u, w), dot(v, w)
    shares = [(Fraction(a), Fraction(b)) for a in (0, 1) for b in (0, 1)]
    shares += [((b * uv - uw) / uu, Fraction(b)) for b in (0, 1) if uu]
    shares += [(Fraction(a), (vw + a * uv) / vv) for a in (0, 1) if vv]
    apart = uu * vv - uv * uv
    shares += [((uv * vw - vv * uw) / apart, (uu * vw - uv * uw) / apart)] if apart else []
    inside = [(a, b) for a, b in shares if 0 <= a <= 1 and 0 <= b <= 1]
    return (
        float(min(dot(d, d) for a, b in inside for d in [[x + a * y - b * z for x, y, z in zip(w, u, v, strict=True)]]))
        ** 0.5
    )


@pytest.mark.parametrize("size", [1.0, 1e3])
@pytest.mark.parametrize("slant", [0.0, 1e-12, 1e-8, 1e-4, 1.0])
def test_the_distance_of_segments_is_exact_however_parallel_they_are(size, slant):
    rng = np.random.default_rng(int(size) + round(slant * 1e4))
    p, q, r = rng.uniform(-size, size, (3, 60, 3))
    r = p + (q - p) * rng.uniform(-2, 2, (60, 1)) + rng.uniform(-1, 1, (60, 3))
    s = r + (q - p) * rng.uniform(-2, 2, (60, 1)) + slant * rng.uniform(-size, size, (60, 3))
    distance = nearest_points(p, q, r, s)[2]
    exact = np.array([exact_distance(*ends) for ends in zip(p, q, r, s, strict=True)])
    assert (distance >= exact - 1e-14 * size).all()
    assert (distance <= exact + 1e-13 * size).all()


def test_paths_that_cross_are_apart_only_at_different_times():
    keep = KeptDistance(1.0, 2.0)
    east, north = path([(-9, 0, 0), (9, 0, 0)], [0, 18]), path([(0, -9, 0), (0, 9, 0)], [0, 18])
    assert not paths_apart(east, north, keep, timed=False)
    assert not paths_apart(east, north, keep, timed=True)
    later = path([(0, -9, 0), (0, 9, 0)], [4, 22])
    assert not paths_apart(east, later, keep, timed=False)
    assert paths_apart(east, later, keep, timed=True)
    assert not paths_apart(path([(-9, 0, 0), (9, 0, 0)], [0, 18], late=3.0), later, keep, timed=True)
    above = path([(0, -9, 2.0), (0, 9, 2.0)], [0, 18])
    assert paths_apart(east, above, keep, timed=False)
    assert not paths_apart(east, path([(0, -9, 1.99), (0, 9, 1.99)], [0, 18]), keep, timed=False)


@pytest.mark.parametrize(("errors", "apart"), [((0.0, 0.0), True), ((0.4, 0.0), False), ((0.0, 0.4), False)])
def test_tracking_errors_count_in_their_own_direction(errors, apart):
    keep = KeptDistance(1.0, 2.0, *errors)
    low = path([(-9, 0, 0), (9, 0, 0)], [0, 18])
    beside, above = path([(-9, 1.2, 0), (9, 1.2, 0)], [0, 18]), path([(-9, 0, 2.3), (9, 0, 2.3)], [0, 18])
    assert paths_apart(low, beside if errors[0] else above, keep, timed=False) is apart


def test_a_deviation_is_subtracted_from_the_distance():
    keep = KeptDistance(1.0, 1.0)
    a, b = path([(-9, 0, 0), (9, 0, 0)], [0, 18], deviation=0.3), path([(-9, 1.5, 0), (9, 1.5, 0)], [0, 18])
    assert paths_apart(a, b, keep, timed=False)
    assert not paths_apart(a, path([(-9, 1.2, 0), (9, 1.2, 0)], [0, 18]), keep, timed=False)


def test_a_stay_without_end_is_in_the_way_for_ever():
    stay = TimedPath(*np.zeros((2, 1, 3)), np.array([[0.0, 0.0]]), np.full((1, 2), np.inf), np.zeros((1, 2)))
    passing = path([(-9, 0.5, 0), (9, 0.5, 0)], [1000, 1018])
    assert not paths_apart(stay, passing, KeptDistance(1.0, 1.0), timed=True)
    assert paths_apart(stay, passing, KeptDistance(0.4, 0.4), timed=True)
    assert paths_apart(stay, passing, KeptDistance(0.0, 0.0), timed=False)


def delayed(clock, points, times, shift):
    return np.stack([np.interp(clock - shift, times, points[:, k]) for k in range(3)], axis=1)


@pytest.mark.parametrize("seed", range(30))
def test_what_is_proven_holds_at_every_time_that_the_paths_allow(seed):
    rng = np.random.default_rng(seed)
    keep = KeptDistance(float(rng.uniform(0.5, 2)), float(rng.uniform(0.5, 3)))
    made = []
    for _ in range(2):
        points = rng.uniform([-8, -8, -3], [8, 8, 3], (int(rng.integers(2, 5)), 3))
        times = np.cumsum(rng.uniform(1, 5, len(points)))
        made.append((points, times, float(rng.uniform(0, 3))))
    proven = paths_apart(*(path(points, times, late) for points, times, late in made), keep, timed=True)
    if not proven:
        return
    clock = np.arange(0, 25, 0.02)
    for _ in range(20):
        a, b = (delayed(clock, points, times, rng.uniform(0, late)) for points, times, late in made)
        begin = max(times[0] + late for _, times, late in made)
        end = min(times[-1] for _, times, _ in made)
        flying = (clock >= begin) & (clock <= end)
        if flying.any():
            assert (np.linalg.norm((a - b)[flying] / [keep.across, keep.across, keep.above], axis=1) >= 1 - 1e-9).all()


def test_paths_that_touch_for_long_are_given_up_and_not_proven():
    along = path([(0, 0, 0), (1e3, 0, 0)], [0, 1])
    bent = path([(0, 1 - 1e-6, 0), (1e3, 1 - 1e-6, 0)], [0, 1])
    assert not paths_apart(along, bent, KeptDistance(1.0, 1.0), timed=False)


def test_what_must_be_kept_grows_by_what_rounding_far_away_takes():
    def needed(*places):
        near, far = path([(0, 0, 0), (1, 0, 0)], [0, 1]), path(places, [0, 1])
        return [_needed(one, other, KeptDistance(10.0, 1.0))[2] for one, other in ((near, far), (far, near))]

    assert needed((0, 0, 0), (1, 0, 0)) == pytest.approx([10 - 1e-6] * 2, abs=1e-12)
    for one in needed((0, 0, 0), (0, 0, 1e7)):  # stretched tenfold along z
        assert 10 + 8 * EPS * 1e8 - 1e-6 <= one <= 10 + 200 * EPS * 1e8
