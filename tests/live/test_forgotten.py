"""What was seen is kept in mind until it tells nothing, or its place was seen empty; and who was forgotten is said."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import skyverse as sky
from replanned import BALL, field, hall
from skyverse.live import Tracks
from skyverse.live import tracks as live_tracks

CART = sky.Box(min=(-0.5, -2, -2), max=(0.5, 2, 2))


@pytest.fixture(scope="module")
def mission():
    """A mission through a corridor that a cart fills."""
    uavs, targets = [sky.UAV(start=(1, 2, 2), max_speed=2.0)], [sky.Target(position=(29, 2, 2))]
    return sky.plan_mission(hall(size=(30, 4, 4), uavs=uavs, targets=targets))


def cart(x, **more):
    return sky.Sighting(**{"name": "cart", "shape": CART, "position": (x, 2, 2), "top_speed": 0.05, **more})


def blinded(mission, seconds):
    """A flight that sees the cart for a second, and nothing after that; with each answer, how far it had come."""
    flight, answers = sky.Replanner(mission), []
    for k in range(round(10 * seconds)):
        (answer,) = flight.observe(k / 10, movers=[cart(12.0)] if 20 <= k < 30 else [])
        answers.append((flight.motion(0).at([k / 10]).position[0, 0], answer))
    return flight, answers


def test_a_mover_that_is_not_seen_any_more_stays_where_it_can_be(mission):
    flight, answers = blinded(mission, 30.0)
    assert max(x for x, _ in answers) < 11.5 - 0.2
    assert len(flight.predicted()) == 1
    assert all(answer.forgotten == () for _, answer in answers)


def test_a_mover_whose_place_was_seen_empty_is_gone(mission):
    flight, _ = blinded(mission, 8.0)
    (answer,) = flight.observe(8.0, gone=["cart"])
    assert flight.predicted() == ()
    assert answer.forgotten == ()
    for k in range(81, 200):
        flight.observe(k / 10)
    assert flight.arrival(0) is not None


def test_only_who_was_seen_can_be_gone_and_may_be_said_to_be_so_again(mission, refuses):
    flight = sky.Replanner(mission)
    flight.observe(0.0, movers=[cart(20.0), cart(22.0, name="van", top_speed=8.0)])
    with refuses():
        flight.observe(0.1, gone=["cart", "kart"])
    assert {one.name for one in flight.predicted()} == {"cart", "van"}
    for k in range(1, 60):  # by then the van is forgotten
        flight.observe(k / 10, gone=["cart"], movers=[cart(5.0, name=f"ball-{k}")] if k < 3 else [])
    assert {one.name for one in flight.predicted()} == {"ball-1", "ball-2"}
    flight.observe(6.0, gone=["van", "bus"], movers=[cart(20.0, name="bus")])


def test_a_mover_that_may_be_anywhere_is_forgotten_and_named(mission):
    flight = sky.Replanner(mission)
    flight.observe(0.0, movers=[cart(20.0, top_speed=8.0)])
    names = [flight.observe(k / 10)[0].forgotten for k in range(1, 60)]
    assert names.count(("cart",)) == 1
    assert names.count(()) == 58
    assert 0.1 * (1 + names.index(("cart",))) > 3.0


def test_the_memory_is_at_least_the_horizon(mission, refuses):
    assert sky.Replanner(mission).memory == 3.0
    plane = sky.Replanner(sky.plan_mission(field()))
    assert plane.memory == plane.horizon > 10.0
    with refuses():
        sky.Replanner(mission, horizon=4.0, memory=3.9)


@given(st.integers(0, 10_000))
def test_who_is_forgotten_may_be_anywhere_where_uavs_can_be(seed):
    rng = np.random.default_rng(seed)
    tracks = Tracks(1.0)
    at, top, error = rng.uniform(0, 10, 3), rng.uniform(0.01, 8), rng.uniform(0, 1)
    more = {"max_acceleration": rng.uniform(0, 4), "velocity": (0, 0, top / 2)} if rng.uniform() < 0.5 else {}
    tracks.add(0.0, [sky.Sighting(name="a", shape=BALL, position=tuple(at), error=error, top_speed=top, **more)])
    low = rng.uniform(0, 5, 3)
    high = low + rng.uniform(0, 5, 3)
    farthest = np.linalg.norm(np.maximum(np.abs(at - low), np.abs(high - at)))
    for now in np.arange(0.0, 8.0, 0.25):
        if tracks.forget(now, [(low, high)]):
            assert now > 1.0
            assert farthest <= error + top * now + 1e-9
            return
    assert more or farthest > error + 7.0 * top


def test_movers_that_are_kept_in_mind_are_bounded(monkeypatch):
    monkeypatch.setattr(live_tracks, "MAX_TRACKS", 3)
    tracks, box = Tracks(1.0), (np.zeros(3), np.full(3, 100.0))
    forgotten = []
    for k in range(6):
        tracks.add(0.1 * k, [cart(1.0, name=f"cart {k}")])
        forgotten += tracks.forget(0.1 * k, [box])
    assert forgotten == ["cart 0", "cart 1", "cart 2"]
    assert [one.name for one in tracks.predicted(1.0)] == ["cart 3", "cart 4", "cart 5"]


def test_too_many_movers_at_once_are_refused(mission, refuses):
    with refuses():
        sky.Replanner(mission).observe(0.0, movers=[cart(1.0, name=str(k)) for k in range(1001)])
