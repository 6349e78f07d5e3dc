"""Random flights for `certificates.py`: planned missions, and random ones that barely keep or barely break a limit."""

from dataclasses import replace
from math import cos, factorial, radians, tan

import numpy as np
from oracle import Motion, depth, nearness, peaks, sampled
from scipy.interpolate import make_interp_spline

import skyverse as sky
from skyverse.model.quantities import derived
from skyverse.model.shapes import Obstacle, Sphere, Terrain, Voxels

OFF = (-1e-3, -1e-5, -2e-6, -1e-6, -5e-7, 0.0, 1e-9, 1e-6, 1e-3)
"""By what share a limit is missed; that of -1e-6 is at the tolerance exactly."""
MADE_BY = sky.Provenance("", "wild", "", None, "")


def world(seed: int) -> sky.Mission:
    """Return one seed's mission."""
    rng = np.random.default_rng(seed)
    kind = rng.choice(["wild", "room", "city", "turns"], p=[0.72, 0.15, 0.02, 0.11])
    if seed % 3 == 2:
        return mapped(wild(rng), rng)
    if kind == "city":
        try:
            city = sky.random_city(int(rng.integers(5, 60)), side=200, uavs=int(rng.integers(1, 7)), seed=seed)
            return planned(city, rng)
        except sky.InputError:  # no place to start
            kind = "room"
    if kind == "room":
        return planned(sky.random_room(seed=seed), rng)
    return turning(rng) if kind == "turns" else wild(rng)


def planned(scenario: sky.Scenario, rng: np.random.Generator) -> sky.Mission:
    """Plan a mission, sometimes under a limit that it just keeps, or just breaks."""
    shape = str(rng.choice(["minimum-snap", "minimum-jerk", "stop-and-go"]))
    mission = sky.plan_mission(
        scenario, sky.Taut(), rng=0, assignment="identity", options=sky.MissionOptions(shape=shape)
    )
    flown = [uav for uav, trajectory in enumerate(mission.trajectories) if trajectory is not None]
    if not flown or rng.random() < 0.5:
        return mission
    uav = int(rng.choice(flown))
    _, motion = sampled(mission.trajectories[uav])
    return judged_by(mission, {uav: bordered(scenario.uavs[uav], motion, rng)})


def wild(rng: np.random.Generator) -> sky.Mission:
    """Let UAVs fly splines through random points."""
    count = int(rng.choice([1, 2, 3, 5, 8, 30], p=[0.4, 0.3, 0.15, 0.1, 0.04, 0.01]))
    side = float(rng.uniform(1, 4)) * count**0.33
    trajectories = [spline(rng, side) for _ in range(count)]
    motions = [sampled(trajectory)[1] for trajectory in trajectories]
    mission = assembled(trajectories, [sky.UAV(start=(0, 0, 0))] * count, side)
    clearance = float(rng.choice([0.001, 0.25]))
    boxes = [wall(rng, motions[rng.integers(count)].position, clearance) for _ in range(rng.integers(0, 3))]
    if rng.random() < 0.3:
        corners = rng.uniform(0, side, (rng.integers(1, 20), 3))
        boxes += [(corner, corner + rng.uniform(0.05, side / 4, 3)) for corner in corners]
    separation = 0.2
    if 1 < count < 6 and rng.random() < 0.6:  # the closest pair just touches, or almost
        near = min(nearness(a, b, (0.5, 0.5, 1)) for a, b in pairs(trajectories))
        separation = max(0.5 * near * (1 + float(rng.choice(OFF))), 0.01)
    uavs = {}
    for k, motion in enumerate(motions):
        easy = generous(motion)
        uav = bordered(easy, motion, rng) if rng.random() < 0.5 else easy
        uavs[k] = derived(uav, separation=separation)
    update = {"obstacles": tuple(sky.Box(min=tuple(a), max=tuple(b)) for a, b in boxes), "clearance": clearance}
    if rng.random() < 0.2:
        highest = max(float(motion.position[:, 2].max()) for motion in motions)
        top = (1e3, 1e3, highest + float(rng.choice(OFF)))
        update["bounds"] = sky.Bounds(min=(-1e3, -1e3, -1e3), max=top)
    scenario = derived(mission.scenario, **update)
    return judged_by(replace(mission, scenario=scenario), uavs)


def mapped(mission: sky.Mission, rng: np.random.Generator) -> sky.Mission:
    """Put shapes of all kinds around the flights, and ground below, which some flight just misses, or just hits."""
    flown = np.concatenate([sampled(trajectory)[1].position for trajectory in mission.trajectories])
    low, high = flown.min(axis=0) - 1, flown.max(axis=0) + 1
    some = [shape_near(rng, low, high) for _ in range(rng.integers(0, 5))]
    terrain = None
    if rng.random() < 0.5:
        step = rng.uniform(0.5, 3, 2)
        count = np.ceil((high - low)[:2] / step).astype(int) + 2
        heights = low[2] + rng.choice([0.0, 0.3, 2.0]) * rng.random(count)
        terrain = Terrain(origin=low[:2], step=step, heights=heights, clearance=rng.choice([0.001, 0.2]))
        below = float(rng.choice(OFF)) - depth(derived(mission.scenario, terrain=terrain), flown).max()
        if rng.random() < 0.7 and below > 0:
            terrain = derived(terrain, clearance=terrain.clearance + below)
    clear = derived(mission.scenario, obstacles=tuple(some), clearance=0.0)
    gap = -depth(clear, flown).max() + float(rng.choice(OFF)) if some else -1.0
    clearance = gap if 0.001 < gap < np.inf and rng.random() < 0.7 else 0.25
    update = {"obstacles": (*mission.scenario.obstacles, *some), "clearance": clearance, "terrain": terrain}
    if terrain is not None:
        bounds, (first, last) = mission.scenario.bounds, terrain.extent
        update["bounds"] = sky.Bounds(min=(*first, bounds.min[2]), max=(*last, bounds.max[2]))
        update["lattice"] = sky.Lattice(step=(0.5, 0.5, 100.0))
    return replace(mission, scenario=derived(mission.scenario, **update))


def shape_near(rng: np.random.Generator, low: np.ndarray, high: np.ndarray) -> Obstacle:
    """Return some shape in a box."""
    middle, size = rng.uniform(low, high), rng.uniform(0.1, 0.5) * float((high - low).min())
    kind = rng.choice(["cylinder", "sphere", "prism", "voxels"])
    span = {"low": middle[2] - size, "high": middle[2] + size}
    if kind == "cylinder":
        return sky.Cylinder(centre=middle[:2], radius=size, **span)
    if kind == "sphere":
        return Sphere(centre=middle, radius=size)
    if kind == "voxels":
        return Voxels(origin=middle, step=rng.uniform(0.1, 0.5, 3), occupied=rng.random(rng.integers(1, 5, 3)) < 0.5)
    angles = np.linspace(0, 2 * np.pi, rng.integers(3, 9), endpoint=False)
    around = np.column_stack([np.cos(angles), np.sin(angles)])
    outline = middle[:2] + size * rng.uniform(0.4, 1, len(angles))[:, None] * around
    inner = middle[:2] + 0.2 * size * around[::-1]
    return sky.Prism(vertices=outline, holes=[inner] if len(angles) > 4 and rng.random() < 0.5 else [], **span)


def spline(rng: np.random.Generator, side: float) -> sky.Trajectory:
    """Fly from rest to rest through random points, smoothly or stopping at each."""
    steps = rng.normal(0, 1.2, (rng.integers(1, 5), 3))
    points = np.cumsum(np.vstack([rng.uniform(0, side, 3), steps]), axis=0)
    degree = int(rng.choice([5, 7]))
    t = np.cumsum(np.r_[rng.choice([0.0, 0.7]), rng.uniform(0.6, 1.6, len(points) - 1)])
    if rng.random() < 0.2:
        rest = np.zeros((len(t) - 1, 6, 3))
        step, T = np.diff(points, axis=0)[:, None], np.diff(t)[:, None, None]
        rest[:, 3:] = np.array([10, -15, 6])[:, None] * step / T ** np.arange(3, 6)[:, None]
        rest[:, 0] = points[:-1]
        return sky.Trajectory(t, rest)
    still = [(order, np.zeros(3)) for order in range(1, degree // 2 + 1)]
    curve = make_interp_spline(t, points, degree, bc_type=(still, still))
    knots = np.unique(curve.t)
    rows = [curve(knots[:-1], nu=order) / factorial(order) for order in range(degree + 1)]
    return sky.Trajectory(knots, np.stack(rows, axis=1))


def wall(rng: np.random.Generator, positions: np.ndarray, clearance: float) -> tuple[np.ndarray, np.ndarray]:
    """Put a box where a flight just touches it: across its highest point along some axis, or the lowest."""
    axis, sign = int(rng.integers(3)), float(rng.choice([-1, 1]))
    turn = positions[np.argmax(sign * positions[:, axis])]
    near, far = turn - rng.uniform(0.1, 2, 3), turn + rng.uniform(0.1, 2, 3)
    gap = clearance + float(rng.choice(OFF))
    face = turn[axis] + sign * gap
    near[axis], far[axis] = min(face, face + sign), max(face, face + sign)
    return near, far


def generous(motion: Motion) -> sky.UAV:
    """Return a UAV that can fly a motion with ease."""
    most = peaks(sky.UAV(start=(0, 0, 0)), motion)
    return sky.UAV(
        start=(0, 0, 0),
        max_speed=1.2 * most["speed"],
        max_acceleration=max(1.2 * most["acceleration"], 1.0),
        max_jerk=min(max(1.2 * most["jerk"], 1.0), 1e6),
        max_tilt=min(1.2 * most["tilt"] + 0.1, 89.0),
        thrust_to_weight=1.2 * max(most["thrust"], 1.0),
    )


def bordered(uav: sky.UAV, motion: Motion, rng: np.random.Generator) -> sky.UAV:
    """Return a UAV one of whose limits a motion just keeps, or just breaks."""
    most = peaks(uav, motion)
    fields = {"speed": "max_speed", "acceleration": "max_acceleration", "jerk": "max_jerk", "tilt": "max_tilt"}
    noun = str(rng.choice([*fields, "thrust"]))
    limit = max(most[noun] * (1 + float(rng.choice(OFF))), 1e-3)
    if noun == "thrust":
        return derived(uav, thrust_to_weight=max(limit, 1.000001))
    return derived(uav, **{fields[noun]: min(limit, 89.9) if noun == "tilt" else limit})


def turning(rng: np.random.Generator) -> sky.Mission:
    """Let one or two aeroplanes fly arcs of helices, at limits that they just keep, or just break."""
    count = int(rng.integers(1, 3))
    trajectories, uavs = [], []
    for _ in range(count):
        speed, radius, climb = rng.uniform(3, 20), rng.uniform(4, 40), rng.uniform(-12, 12)
        sense = rng.choice([-1, 0, 1])
        pieces, step = int(rng.integers(2, 9)), rng.uniform(0.05, 0.3)
        turn, heading, middle = sense * speed / radius, rng.uniform(0, 6.28), rng.uniform(-20, 20, 3)
        knots = np.arange(pieces + 1) * step * radius / speed
        angle = heading + turn * knots
        along = np.column_stack([np.cos(angle), np.sin(angle)])
        across = np.column_stack([-along[:, 1], along[:, 0]])
        place = middle[:2] + (-sense * radius * across if sense else speed * knots[:, None] * along)
        rise = speed * tan(radians(climb))
        position = np.column_stack([place, middle[2] + rise * knots])
        velocity = np.column_stack([speed * along, np.full(len(knots), rise)])
        acceleration = np.column_stack([speed * turn * across, np.zeros(len(knots))])
        trajectories.append(hermite(knots, position, velocity, acceleration))
        fastest = float(np.hypot(speed, rise))
        near = [float(rng.choice(OFF)) for _ in range(3)]
        named = speed * (1 + float(rng.choice([0, 0, 0.005, 0.00990099, 0.0101, 0.02])))
        wing = sky.FixedWing(
            speed=named, turn_radius=radius * (1 - near[0]), climb=min(max(abs(climb), 0.1) * (1 + near[1]), 80)
        )
        uav = sky.UAV(start=(0, 0, 0), max_speed=2 * fastest, max_acceleration=3 * speed**2 / radius, fixed_wing=wing)
        least = wing.speed / cos(radians(wing.climb)) * (1 + 1e-12)  # or else no aeroplane may have such limits
        uavs.append(derived(uav, max_speed=max(fastest * (1 + near[2]), least)) if rng.random() < 0.3 else uav)
    return assembled(trajectories, uavs, 1e3)


def hermite(t: np.ndarray, p: np.ndarray, v: np.ndarray, a: np.ndarray) -> sky.Trajectory:
    """Join places, velocities and accelerations by quintics."""
    T = np.diff(t)[:, None]
    d, v0, v1, a0, a1 = p[1:] - p[:-1], v[:-1], v[1:], a[:-1], a[1:]
    rows = [
        p[:-1],
        v0,
        a0 / 2,
        (20 * d - (8 * v1 + 12 * v0) * T - (3 * a0 - a1) * T**2) / (2 * T**3),
        (-30 * d + (14 * v1 + 16 * v0) * T + (3 * a0 - 2 * a1) * T**2) / (2 * T**4),
        (12 * d - 6 * (v1 + v0) * T - (a0 - a1) * T**2) / (2 * T**5),
    ]
    return sky.Trajectory(t, np.stack(rows, axis=1), form="dubins")


def pairs(things: list[sky.Trajectory]) -> list[tuple[sky.Trajectory, sky.Trajectory]]:
    """Return each two."""
    return [(a, b) for i, a in enumerate(things) for b in things[i + 1 :]]


def assembled(trajectories: list[sky.Trajectory], uavs: list[sky.UAV], side: float) -> sky.Mission:
    """Return a mission in which UAVs fly as told, wherever that is."""
    starts = [tuple(trajectory.at(trajectory.start).position[0].tolist()) for trajectory in trajectories]
    ends = [tuple(trajectory.at(trajectory.end).position[0].tolist()) for trajectory in trajectories]
    scenario = sky.Scenario(
        name="wild",
        bounds=sky.Bounds(min=(-1e3, -1e3, -1e3), max=(1e3, 1e3, 1e3)),
        clearance=0,
        lattice=sky.Lattice(step=(100, 100, 100)),
        uavs=[sky.UAV(start=start) for start in starts],
        targets=[sky.Target(position=end) for end in ends],
    )
    count = len(uavs)
    mission = sky.Mission(scenario, tuple(range(count)), (None,) * count, tuple(trajectories), (), MADE_BY)
    return judged_by(mission, dict(enumerate(uavs)))


def judged_by(mission: sky.Mission, uavs: dict[int, sky.UAV]) -> sky.Mission:
    """Return the mission for a scenario in which UAVs can do something else."""
    scenario = mission.scenario
    all_uavs = tuple(
        derived(uavs[k], start=uav.start, name=uav.name) if k in uavs else uav for k, uav in enumerate(scenario.uavs)
    )
    return replace(mission, scenario=derived(scenario, uavs=all_uavs))
