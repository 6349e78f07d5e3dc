"""What is said to be proven holds from now on, however the motion begins: dense samples of random encounters.

Nothing of skyverse but its data and the motions is used here: distances are written out.
"""

import functools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import skyverse as sky
from replanned import field, hall

CLOSE = 1e-6
"""Metres, m/s and the like by which samples may be off."""
SEEDS = st.integers(0, 100_000)


@functools.cache
def mission(kind):
    """A mission of one multirotor or one aeroplane, planned once."""
    return sky.plan_mission(hall() if kind == "multirotor" else field())


def ahead(rng, flight, scale):
    """A place near where the UAV will be soon, metres: often before the next motion can begin."""
    later = flight.now + rng.choice([1.0, 5.0]) * rng.uniform(0.1, 1.0) * flight.lead
    return flight.motion(0).at([later]).position[0] + scale * rng.normal(size=3) * (0.2, 0.2, 0.1)


def box(rng, at, scale, **more):
    half = scale * rng.uniform(0.02, 0.6, size=3) * (rng.choice([0.02, 1.0]), 1.0, 1.0)
    return sky.Box(min=tuple(at - half), max=tuple(at + half), **more)


def encounter(rng, flight, kind, scale, fastest):
    """What is observed: each of several things or nothing of it."""
    seen = {}
    if rng.uniform() < 0.4:
        seen["obstacles"] = [box(rng, ahead(rng, flight, scale), scale) for _ in range(rng.integers(1, 3))]
    if rng.uniform() < 0.3:
        limit = float(fastest * rng.uniform(0.2, 0.9))
        seen["zones"] = [box(rng, ahead(rng, flight, scale), scale, max_speed=limit)]
    if rng.uniform() < 0.2:
        shut = [(flight.now + rng.uniform(-1, 2), flight.now + rng.uniform(2.5, 9))]
        seen.setdefault("zones", []).append(box(rng, ahead(rng, flight, scale), scale, active=shut))
    if rng.uniform() < 0.3:
        ball = sky.Sphere(centre=(0, 0, 0), radius=float(0.1 * scale))
        at = tuple(ahead(rng, flight, scale))
        top = float(fastest * rng.uniform(0.01, 0.5))
        seen["movers"] = [sky.Sighting(name=f"ball at {flight.now}", shape=ball, position=at, top_speed=top)]
    if rng.uniform() < 0.3:
        place, velocity, _ = (rows[0] for rows in flight.motion(0).at([flight.now]))
        turn = rng.uniform(-0.5, 0.5)
        x, y, z = velocity if kind == "aeroplane" else velocity + rng.normal(size=3) * 0.1 * fastest
        x, y = x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)
        if kind == "multirotor" or np.hypot(x, y) > 1.0:
            seen["states"] = {0: (place + rng.normal(size=3) * 0.1 * scale, (x, y, z))}
    if rng.uniform() < 0.2:
        high = np.array(flight.scenario.bounds.max)
        seen["targets"] = {0: tuple(high * rng.uniform(0.1, 0.9, size=3))}
    return seen


def to_box(places, shape):
    """How far places (n, 3) are from a box, metres, below 0 inside."""
    off = np.maximum(np.array(shape.min) - places, places - np.array(shape.max))
    return np.where((off > 0).any(axis=1), np.linalg.norm(np.maximum(off, 0.0), axis=1), off.max(axis=1))


def wrong(flight, answer, seen, speeds):
    """What dense samples of the motion from now on show to be untrue of an answer, up to when it says it is clear.

    What stands still is kept clear of beyond that, too, if the answer is proven.
    """
    scenario, now, motion = flight.scenario, flight.now, flight.motion(0)
    if answer.clear_until <= now:
        return []
    until = max(answer.clear_until, motion.end) if answer.proven else answer.clear_until - 1e-4
    t = np.unique(np.r_[np.linspace(now, min(now + 1.5, until), 1500), np.linspace(now, until, 4000)])
    places, velocities, _ = motion.at(t)
    fast = np.linalg.norm(velocities, axis=1)
    found = [("obstacle", one) for one in seen["obstacles"] if to_box(places, one).min() < scenario.clearance - CLOSE]
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    if (places < low - CLOSE).any() or (places > high + CLOSE).any():
        found.append(("bounds",))
    soon = t <= answer.clear_until
    for one in seen["zones"]:
        inside = to_box(places, one) < -CLOSE
        if one.active is None and (fast[inside] > one.max_speed + CLOSE).any():
            found.append(("zone", one, fast[inside].max()))
        if one.active is not None:
            during = soon & (t >= one.active[0][0]) & (t <= one.active[0][1])
            if to_box(places, one)[during].min(initial=np.inf) < scenario.clearance - CLOSE:
                found.append(("closed zone", one))
    for since, one in seen["movers"]:
        may_be = one.shape.radius + one.top_speed * (t - since)
        if (np.linalg.norm(places - one.position, axis=1) - may_be)[soon].min() < scenario.clearance - CLOSE:
            found.append(("mover", one))
    if not speeds[0] - CLOSE <= fast.min() or not fast.max() <= speeds[1] * (1 + CLOSE):
        found.append(("speed", fast.min(), fast.max()))
    return found


def speeds_of(flight):
    """The least and the greatest speed that a UAV may fly at; one that was found too fast brakes."""
    uav, motion = flight.scenario.uavs[0], flight.motion(0)
    if uav.fixed_wing is None:
        return 0.0, max(uav.max_speed, np.linalg.norm(motion.at([flight.now]).velocity[0]))
    return (0.0 if motion.start >= flight.now else uav.fixed_wing.speed), uav.max_speed


@pytest.mark.parametrize(("kind", "scale", "rate"), [("multirotor", 2.0, 10.0), ("aeroplane", 40.0, 5.0)])
@given(seed=SEEDS)
@example(seed=7)
@example(seed=18)
def test_what_is_said_holds_from_now_on_however_the_motion_begins(kind, scale, rate, seed):
    rng = np.random.default_rng(seed)
    flight = sky.Replanner(mission(kind), lead=float(rng.choice([0.05, 0.1, 0.5, 1.0])))
    wing = flight.scenario.uavs[0].fixed_wing
    fastest = flight.scenario.uavs[0].max_speed if wing is None else wing.speed
    begin = int(rng.integers(0, 60 if wing else 25)) / rate
    for early in np.arange(0.0, begin, 4.0):
        flight.observe(early)
    known = {"obstacles": [], "zones": [], "movers": []}
    for step in range(3):
        now = begin + step / rate
        seen = {} if step else encounter(rng, flight, kind, scale, fastest)
        try:
            (answer,) = flight.observe(now, **seen)
        except sky.InputError:
            continue  # a target that no path leads to
        known["obstacles"] += seen.get("obstacles", ())
        known["zones"] += seen.get("zones", ())
        known["movers"] += [(now, one) for one in seen.get("movers", ())]
        assert wrong(flight, answer, known, speeds_of(flight)) == []
