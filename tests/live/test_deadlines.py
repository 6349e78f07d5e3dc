"""A deadline bounds the effort of an answer, however far ahead motions are proven: by an injected clock."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

import skyverse as sky
from replanned import field, hall
from skyverse.live import search, surroundings

KINDS = {"multirotor": (hall, 0.3), "aeroplane": (field, 8.0)}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("readings", [0, 3])
def test_the_effort_after_a_deadline_does_not_grow_with_the_horizon(kind, readings, monkeypatch):
    made, radius = KINDS[kind]
    mission = sky.plan_mission(made())
    efforts = []
    for horizon in (30.0, 600.0):
        flight = sky.Replanner(mission, horizon=horizon)
        ball = sky.Sphere(centre=(0, 0, 0), radius=radius)
        at = flight.motion(0).at([2.0]).position[0]
        balls = [
            sky.Sighting(name=str(k), shape=ball, position=tuple(at + np.array((k * radius, 0, 0))), top_speed=1.0)
            for k in range(5)
        ]
        flight.observe(0.0, movers=balls, deadline_ms=0.0)
        looked, found = itertools.count(), surroundings.first_contact
        clock = itertools.chain(itertools.repeat(float("-inf"), readings), itertools.repeat(float("inf")))
        with monkeypatch.context() as patched:
            patched.setattr(search, "time", SimpleNamespace(perf_counter=lambda clock=clock: next(clock)))
            patched.setattr(surroundings, "first_contact", lambda *a, n=looked, f=found: (next(n), f(*a))[1])
            (answer,) = flight.observe(0.1, movers=balls, deadline_ms=1.0)
        efforts.append((answer.tried, next(looked)))
    assert max(tried for tried, _ in efforts) <= readings
    assert max(looks for _, looks in efforts) <= 6 + 6 * readings
