"""Fleets in the open, exported, and replayed by an autopilot that climbs and flies faster or slower than planned."""

import itertools

import numpy as np
import replayed_autopilot as autopilot

import skyverse as sky
from skyverse import UAV, Bounds, Frame, Lattice, Origin, Scenario, Target
from skyverse.exports import Apart

ORIGIN = Origin(latitude=40.70, longitude=-74.0, altitude=0.0, geoid=-33.0)


def fleet(starts, targets, homes=None, *, separation=2.0, speed=5.0, seed=0, **how):
    homes = homes or [None] * len(starts)
    every = np.array([*starts, *targets])
    low, high = every.min(axis=0) - 60, every.max(axis=0) + 60
    low[2] = min([low[2] + 60, 0.0, *(h for h in homes if h is not None)])
    scenario = Scenario(
        name="fleet",
        frame=Frame(origin=ORIGIN),
        bounds=Bounds(min=tuple(low.tolist()), max=tuple(high.tolist())),
        clearance=1.0,
        lattice=Lattice(step=(20, 20, 20)),
        uavs=tuple(
            UAV(start=tuple(s), home=h, separation=separation, max_speed=speed)
            for s, h in zip(starts, homes, strict=True)
        ),
        targets=tuple(Target(position=tuple(t)) for t in targets),
    )
    options = sky.MissionOptions(**how)
    return sky.plan_mission(scenario, sky.Taut(), assignment="identity", rng=seed, options=options)


def random_fleet(seed, **how):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    level = rng.choice([0.0, 40.0])

    def places():
        while True:
            found = rng.uniform([-150, -150, 20], [150, 150, 60], (count, 3))
            found[:, 2] = 40 if level else found[:, 2]
            gaps = [np.hypot(*(a - b)[:2]) for a, b in itertools.combinations(found, 2)]
            if min(gaps) > 12:
                return found.tolist()

    homes = [float(h) for h in rng.uniform(0, 10, count)] if rng.random() < 0.7 else None
    separation, speed = float(rng.uniform(1, 4)), float(rng.uniform(3, 12))
    return fleet(places(), places(), homes, separation=separation, speed=speed, **how)


def read_orders(scenario, files):
    """What the files of a fleet tell their autopilots."""
    if files[0].name.endswith(".wpml.kmz"):
        homes = [(*u.start[:2], u.start[2] if u.home is None else u.home) for u in scenario.uavs]
        return [autopilot.read_wpml(f, ORIGIN, h, -ORIGIN.geoid) for f, h in zip(files, homes, strict=True)]
    if files[0].suffix == ".waypoints":
        return [autopilot.read_waypoints(file.read_text(), ORIGIN) for file in files]
    made = [autopilot.read_plan(file.read_text(), ORIGIN) for file in files]
    for one, file in zip(made, files, strict=True):
        one.px4 = autopilot.read_parameters(file.with_suffix(".params").read_text())
    return made


def broken_promises(mission, orders, pairs, rng, runs=4):
    """Replay a fleet at climbs of 1 to 5 m/s, speeds 10 % off and take-offs from at once to 1.2 times as slow.

    Return the pairs that break what is said of them.
    """
    scenario, broken = mission.scenario, []
    for k in range(runs):
        count = len(orders)
        off = rng.uniform(1, 5, count), rng.uniform(0.9, 1.1, count), rng.uniform(0, 1.2, count)
        if k < 2:
            off = rng.choice([1.0, 5.0], count), rng.choice([0.9, 1.1], count), rng.choice([0.0, 1.2], count)
        tracks = [autopilot.fly(o, c, c, f, late) for o, c, f, late in zip(orders, *off, strict=True)]
        for (i, j), kind in pairs.items():
            across, above = (max(p) for p in zip(scenario.uavs[i].ellipsoid, scenario.uavs[j].ellipsoid, strict=True))
            near = 1.0
            if kind in (Apart.SPACE, Apart.TIMING):
                near = autopilot.nearness(tracks, i, j, across, above)
            if kind is Apart.SPACE:  # whatever the timing
                a, b = tracks[i][::10] / [across, across, above], tracks[j][::10] / [across, across, above]
                near = min(near, float(np.linalg.norm(a[:, None] - b[None], axis=2).min()))
            if near < 1 - 0.03 / across:  # files round to a centimetre or two
                broken.append((i, j, kind, near))
    return broken
