"""Obstacles that are reported anew, with noise, are one that holds all reports; and there are never too many."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from replanned import hall
from skyverse.live import around, observed


def shape(kind, at, size):
    x, y, z = at
    if kind == "box":
        return sky.Box(min=(x, y, z), max=(x + size, y + 2 * size, z + size), kind="wall")
    if kind == "cylinder":
        return sky.Cylinder(centre=(x, y), radius=size, low=z, high=z + size, kind="wall")
    return sky.Sphere(centre=at, radius=size, kind="wall")


def inside(one, p):
    """Tell which places (n, 3) a shape holds, or nearly."""
    if isinstance(one, sky.Box):
        return ((p >= np.array(one.min) - 1e-9) & (p <= np.array(one.max) + 1e-9)).all(axis=1)
    if isinstance(one, sky.Sphere):
        return np.linalg.norm(p - one.centre, axis=1) <= one.radius + 1e-9
    level = np.hypot(*(p[:, :2] - one.centre).T) <= one.radius + 1e-9
    return level & (p[:, 2] >= one.low - 1e-9) & (p[:, 2] <= one.high + 1e-9)


@given(st.sampled_from(["box", "cylinder", "sphere"]), st.integers(0, 10_000))
def test_what_takes_the_place_of_two_reports_holds_both(kind, seed):
    rng = np.random.default_rng(seed)
    at, size = rng.uniform(-5, 5, 3), rng.uniform(0.5, 2)
    noise = rng.choice([1e-3, 0.02])
    first, second = (shape(kind, tuple(at + rng.uniform(-noise, noise, 3)), size) for _ in range(2))
    both = around(first, second)
    assert both is not None
    places = at + size * rng.uniform(-1.1, 2.1, size=(3000, 3))
    held = inside(first, places) | inside(second, places)
    assert held.any()
    assert inside(both, places)[held].all()
    assert around(first, first) == first
    assert around(first, shape(kind, tuple(at + np.array((0.2, 0, 0))), size)) is None
    assert around(first, second.model_copy(update={"kind": "net"})) is None


@pytest.fixture(scope="module")
def mission():
    return sky.plan_mission(hall())


def reported(rng, noise=1e-3):
    low, high = rng.normal((8, 8, 0), noise), rng.normal((8.5, 8.5, 1), noise)
    return sky.Box(min=tuple(low), max=tuple(high))


def test_an_obstacle_that_is_reported_anew_is_one(mission):
    rng, flight = np.random.default_rng(1), sky.Replanner(mission)
    reports = [reported(rng) for _ in range(40)]
    for k, one in enumerate(reports):
        (answer,) = flight.observe(k / 10, obstacles=[one])
        assert answer.proven
    (wall,) = flight.scenario.obstacles
    assert (np.array(wall.min) == np.min([one.min for one in reports], axis=0)).all()
    assert (np.array(wall.max) == np.max([one.max for one in reports], axis=0)).all()


@pytest.mark.parametrize("field", ["obstacles", "zones"])
def test_obstacles_and_zones_are_bounded_and_one_too_many_changes_nothing(mission, monkeypatch, field, refuses):
    monkeypatch.setattr(observed, f"MAX_{field.upper()}", 3)
    flight = sky.Replanner(mission)
    more = {"max_speed": 3.0} if field == "zones" else {}
    boxes = [sky.Box(min=(x, 8, 0), max=(x + 0.5, 9, 1), **more) for x in range(2, 10)]
    flight.observe(0.0, **{field: boxes[:3]})
    before = flight.scenario
    with refuses():
        flight.observe(0.1, **{field: boxes[3:4]})
    flight.observe(0.1, **{field: boxes[:3]})
    assert flight.scenario == before
