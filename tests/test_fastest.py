"""The bound that trajectories are measured against, on curves whose least time is known; and that measurement."""

import itertools
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import skyverse as sky
from patience import PATIENCE_S
from skyverse.trajectory import rest_to_rest

pytest.importorskip("toppra", reason='toppra is not installed; pip install "skyverse[bench]"')


BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def least_time(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    from fastest import least_time

    yield least_time
    sys.modules.pop("fastest")


UAV = sky.UAV(start=(0, 0, 0), max_speed=5, max_acceleration=3.5, max_jerk=1e4)


@pytest.mark.parametrize(
    ("length", "seconds"),
    [
        (300.0, 300 / 5 + 5 / 3.5),
        (30.0, 30 / 5 + 5 / 3.5),
        (7.0, 2 * math.sqrt(7 / 3.5)),
        (1.0, 2 * math.sqrt(1 / 3.5)),
    ],
)
def test_a_straight_line_takes_a_trapezoid_of_speed(least_time, length, seconds):
    line = rest_to_rest(np.array([[0, 0, 0], [0.6 * length, 0, 0.8 * length]]), UAV)
    assert least_time(line, UAV) == pytest.approx(seconds, rel=1e-4)


def test_a_path_with_corners_is_at_rest_at_each(least_time):
    corners = np.array([[0, 0, 0], [7, 0, 0], [7, 1, 0], [7, 1, 30]], float)
    seconds = 2 * math.sqrt(7 / 3.5) + 2 * math.sqrt(1 / 3.5) + 30 / 5 + 5 / 3.5
    assert least_time(rest_to_rest(corners, UAV), UAV) == pytest.approx(seconds, rel=1e-4)


@pytest.mark.parametrize("radius", [0.5, 2.0, 7.0])
def test_a_circle_takes_all_the_acceleration_there_is(least_time, radius):
    # x = v^2 grows by dx/ds = 2 sqrt(A^2 - x^2 / R^2), so x = A R sin(2 s / R) until v = sqrt(A R), and back
    rounds = 3
    a = UAV.max_acceleration
    getting_fast = math.sqrt(radius / a) / 2 * math.sqrt(math.pi) / 2 * math.gamma(1 / 4) / math.gamma(3 / 4)
    seconds = 2 * getting_fast + (2 * math.pi * rounds - math.pi / 2) * math.sqrt(radius / a)
    least = least_time(circle(radius, rounds), UAV)
    assert least == pytest.approx(seconds, rel=1e-3)
    assert least <= seconds  # a bound


def test_a_circle_at_the_speed_limit(least_time):
    # at 5 m/s a circle of 100 m takes 0.25 m/s^2 of the 3.5; getting fast takes a little longer than straight ahead
    seconds = 2 * math.pi * 100 / 5 + 5 / 3.5
    assert least_time(circle(100.0, 1), UAV) == pytest.approx(seconds, rel=1e-3)


def circle(radius, rounds, count=16):
    """Rounds of a circle in sixteenths: quintics with the circle's value and two derivatives at their ends."""
    angles = np.linspace(0, 2 * math.pi * rounds, count * rounds + 1)
    step = angles[1]
    powers = [
        [math.perm(i, k) * t ** (i - k) if i >= k else 0.0 for i in range(6)] for t in (0.0, step) for k in range(3)
    ]
    quarter = np.array([0, math.pi / 2, math.pi])
    ends = [np.stack([np.cos(t + quarter), np.sin(t + quarter), 0 * quarter], axis=1) * radius for t in angles]
    rows = [np.linalg.solve(powers, np.concatenate(pair)) for pair in itertools.pairwise(ends)]
    return sky.Trajectory(angles, np.array(rows))


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="a benchmark of plain Python says nothing")
def test_smooth_trajectories_are_faster_than_stopping_but_not_than_the_bound():
    words = [sys.executable, str(BENCHMARKS / "trajectories.py"), "map1"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in done.stdout.splitlines() if "map1 " in line]
    assert [row[1] for row in rows] == ["Taut", "A*", "MVO"] * 4  # two tables of two shapes
    for row in (row for row in rows if row[4].endswith(" s")):
        stopping, smooth, least = (float(cell.removesuffix(" s")) for cell in row[4:7])
        assert least <= smooth < 0.9 * stopping
        assert row[3] == "1"  # proven
