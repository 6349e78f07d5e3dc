"""How deep UAVs are in movers and active zones at dense instants, by formulas of its own, without code of the referee.

The last bits of speeds, which are taken from positions, are not to be trusted.
"""

import numpy as np
from oracle import where

import skyverse as sky

INSTANTS = 20_000
FINER, CLOSEST = 400, 3  # instants about each of the closest ones


def stated(motion: object, t: np.ndarray) -> np.ndarray:
    """Return where the point of a mover is by its stated motion, (m, 3) metres."""
    if isinstance(motion, sky.WaypointMotion):
        times, points = np.array(motion.times), np.array(motion.points)
        since, length = t - times[0], times[-1] - times[0]
        if motion.then == "repeats":
            since = np.where(since > 0, np.mod(since, length), since)
        if motion.then == "returns":
            phase = np.mod(since, 2 * length)
            since = np.where(since > 0, np.minimum(phase, 2 * length - phase), since)
        return np.stack([np.interp(times[0] + since, times, column) for column in points.T], axis=1)
    if isinstance(motion, sky.CircularMotion):
        angle = np.radians(motion.bearing) + (1 if motion.clockwise else -1) * 2 * np.pi * t / motion.period
        return motion.centre + motion.radius * np.stack([np.sin(angle), np.cos(angle), np.zeros(len(t))], axis=1)
    if isinstance(motion, sky.PeriodicMotion):
        total = np.tile(motion.centre, (len(t), 1)).astype(float)
        for k, (c, s) in enumerate(zip(motion.cosine, motion.sine, strict=True), 1):
            angle = 2 * np.pi * k * t / motion.period
            total += np.outer(np.cos(angle), c) + np.outer(np.sin(angle), s)
        return total
    knots = np.array(motion.knots)
    t = np.clip(t, knots[0], knots[-1])
    piece = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2)
    out = np.empty((len(t), 3))
    for k, rows in enumerate(motion.coefficients):
        own = piece == k
        out[own] = np.vander(t[own] - knots[k], len(rows), increasing=True) @ np.array(rows)
    return out


def inside(shape: object, p: np.ndarray) -> np.ndarray:
    """Return how deep places (m, 3) are inside a shape, metres; grown shapes are deeper by as much as they grow."""
    if isinstance(shape, sky.Box):
        return np.minimum(p - shape.min, shape.max - p).min(axis=1)
    if isinstance(shape, sky.Sphere):
        return shape.radius - np.linalg.norm(p - shape.centre, axis=1)
    if isinstance(shape, sky.Ellipsoid):
        axes = np.array([shape.semi_axis_xy, shape.semi_axis_xy, shape.semi_axis_z])
        return axes.min() * (1 - np.linalg.norm((p - shape.centre) / axes, axis=1))
    level = np.minimum(p[:, 2] - shape.low, shape.high - p[:, 2])
    if isinstance(shape, sky.Cylinder):
        return np.minimum(level, shape.radius - np.hypot(*(p[:, :2] - shape.centre).T))
    away, odd = np.full(len(p), np.inf), np.zeros(len(p), dtype=bool)
    for a, b in zip(shape.vertices, (*shape.vertices[1:], shape.vertices[0]), strict=True):
        along = np.subtract(b, a)
        share = np.clip((p[:, :2] - a) @ along / (along @ along), 0, 1)
        away = np.minimum(away, np.hypot(*(p[:, :2] - a - share[:, None] * along).T))
        if a[1] != b[1]:
            spans = (a[1] > p[:, 1]) != (b[1] > p[:, 1])
            odd ^= spans & (a[0] + (p[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > p[:, 0])
    return np.minimum(level, np.where(odd, away, -away))


def far(doubt: sky.Doubt, after: np.ndarray) -> np.ndarray:
    """Return how far a mover may be from its stated motion some seconds (m,) after it was last seen, (m,) metres."""
    steadily = doubt.radius + doubt.growth * after
    if not doubt.acceleration:
        return steadily
    late = np.maximum(after - 2 * doubt.top_speed / doubt.acceleration, 0)
    return steadily + doubt.acceleration / 2 * (after**2 - late**2)


def in_mover(mover: sky.Mover, t: np.ndarray, places: np.ndarray, kept: float) -> np.ndarray:
    """Return how deep places (m, 3) are, at instants (m,), in where a mover may be, metres."""
    doubt, after = mover.doubt, np.maximum(t - mover.doubt.since, 0)
    depth = inside(mover.shape, places - stated(mover.motion, t)) + kept + far(doubt, after)
    if doubt.top_speed is None:
        return depth
    seen = stated(mover.motion, np.array([doubt.since]))[0]
    reached = inside(mover.shape, places - seen) + kept + doubt.radius + doubt.top_speed * after
    return np.where(after > 0, np.minimum(depth, reached), depth)


def active(zone: object, t: np.ndarray) -> np.ndarray:
    """Return whether a zone is active at instants (m,)."""
    found = np.zeros(len(t), dtype=bool)
    for begin, end in zone.active:
        found |= (t >= (-np.inf if begin is None else begin)) & (t <= (np.inf if end is None else end))
    return found


def excess(scenario: sky.Scenario, flown: sky.Trajectory, t: np.ndarray, aside: np.ndarray) -> dict[object, np.ndarray]:
    """Return by how much a flight is wrong at instants (m,), (m,) metres for each mover and each zone.

    Of a zone with a speed limit it is the lesser of the depth inside and of the share by which the limit is exceeded.
    `aside` is how far the UAV strays, (3,) metres.
    """
    start = flown.coefficients[0, 0]
    places = where(flown, start, t) + aside
    wrong: dict[object, np.ndarray] = {}
    for number, mover in enumerate(scenario.movers):
        wrong["mover", number] = in_mover(mover, t, places, scenario.clearance)
    for number, zone in enumerate(scenario.zones):
        limited = zone.max_speed is not None
        depth = inside(zone, places) + (0 if limited else scenario.clearance)
        if limited:
            step = 1e-6  # seconds, on both sides
            speed = np.linalg.norm(where(flown, start, t + step) - where(flown, start, t - step), axis=1) / (2 * step)
            depth = np.minimum(depth, speed / zone.max_speed - 1)
        wrong["limit" if limited else "zone", number] = np.where(active(zone, t), depth, -np.inf)
    return wrong


def worst(
    scenario: sky.Scenario, flown: sky.Trajectory, end: float, aside: np.ndarray
) -> dict[object, tuple[float, float]]:
    """Return by how much a flight is wrong for each mover and zone at most, and when; finer about the worst."""
    edges = [t for zone in scenario.zones for span in zone.active for t in span if t is not None and 0 <= t <= end]
    t = np.union1d(np.linspace(0, end, INSTANTS), edges)
    found: dict[object, tuple[float, float]] = {}
    for which, depth in excess(scenario, flown, t, aside).items():
        k = int(np.argmax(depth))
        found[which] = float(depth[k]), float(t[k])
    width = end / INSTANTS
    near = sorted(found.values(), reverse=True)[:CLOSEST]
    finer = [np.linspace(max(at - width, 0), min(at + width, end), FINER) for _, at in near]
    t = np.unique(np.concatenate([[0.0], *finer]))
    for which, depth in excess(scenario, flown, t, aside).items():
        k = int(np.argmax(depth))
        found[which] = max(found[which], (float(depth[k]), float(t[k])))
    return found
