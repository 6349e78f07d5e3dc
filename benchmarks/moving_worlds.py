"""Random moving worlds: movers of every shape, motion and doubt, zones with active times, and flights among them."""

import numpy as np
from scipy.interpolate import CubicSpline

import skyverse as sky
from skyverse.model.mover_motions import MoverMotion, motion_bounds
from skyverse.model.result import Provenance

SIDE, HEIGHT, BEYOND = 30.0, 10.0, 30.0  # metres
MADE_BY = Provenance("", "at random", "", None, "")
AGILE = {"max_speed": 1e3, "max_acceleration": 1e4, "max_jerk": 1e6, "max_tilt": 89.0, "thrust_to_weight": 1e3}


def moving_world(seed: int) -> sky.Mission:
    """Return a mission among movers and zones: of every fourth seed a planned one, of others random flights."""
    rng = np.random.default_rng(seed)
    planned, beyond = seed % 4 == 0, 1.0 if seed % 4 == 0 else BEYOND
    count = int(rng.integers(1, 3))
    error = {"horizontal": rng.uniform(0.05, 0.5), "vertical": rng.uniform(0.05, 0.5)} if rng.random() < 0.25 else {}
    ends = [(place(rng), place(rng)) for _ in range(count)]
    scenario = sky.Scenario(
        name=f"moving-{seed}",
        bounds={"min": (-beyond, -beyond, -beyond), "max": (SIDE + beyond, SIDE + beyond, HEIGHT + beyond)},
        clearance=float(rng.choice([0.001, 0.3, 1.0])),
        lattice={"step": (2, 2, 2), "connectivity": 26},
        objective={"unit": "metres"},
        movers=[mover(rng) for _ in range(rng.integers(0, 6))],
        zones=[zone(rng) for _ in range(rng.integers(0, 3))],
        uavs=[{"start": a, "tracking_error": error, **({} if planned else AGILE)} for a, _ in ends],
        targets=[{"position": b} for _, b in ends],
    )
    if planned:
        return sky.plan_mission(scenario, assignment="identity")
    flown = tuple(wandering(rng, a, b) for a, b in ends)
    return sky.Mission(scenario, tuple(range(count)), (None,) * count, flown, (), MADE_BY)


def place(rng: np.random.Generator) -> tuple[float, ...]:
    """Return a place in the world, metres."""
    return tuple(rng.uniform(0, (SIDE, SIDE, HEIGHT)).round(3).tolist())


def wandering(rng: np.random.Generator, a: tuple[float, ...], b: tuple[float, ...]) -> sky.Trajectory:
    """Return a flight along a cubic spline through random places."""
    between = [place(rng) for _ in range(rng.integers(0, 4))]
    knots = rng.choice([0.0, rng.uniform(0, 5)]) + np.concatenate([[0], np.cumsum(rng.uniform(1, 8, len(between) + 1))])
    spline = CubicSpline(knots, np.array([a, *between, b]), bc_type="clamped")
    return sky.Trajectory(knots, np.swapaxes(spline.c[::-1], 0, 1))


def mover(rng: np.random.Generator) -> sky.Mover:
    """Return a mover."""
    doubt = {"radius": rng.uniform(0, 1), "growth": rng.uniform(0, 0.1), "since": rng.uniform(-2, 8)}
    if rng.random() < 0.5:
        doubt["top_speed"] = doubt["growth"] + rng.uniform(0.01, 2)
    own, moves = shape(rng), motion(rng)
    if "top_speed" in doubt:
        doubt["top_speed"] = max(doubt["top_speed"], motion_bounds(moves)[0])
        if rng.random() < 0.5:
            doubt["acceleration"] = rng.uniform(0, 0.1)
    return sky.Mover(shape=own, motion=moves, doubt=doubt if rng.random() < 0.5 else {})


def shape(rng: np.random.Generator) -> dict[str, object]:
    """Return the shape of a mover about the zero of its frame."""
    x, y, z = rng.uniform(-1, 1, 3)
    a, b, h = rng.uniform(0.3, 3, 3)
    shapes = (
        {"shape": "box", "min": (x - a, y - b, z - h), "max": (x + a, y + b, z + h)},
        {"shape": "cylinder", "centre": (x, y), "radius": a, "low": z - h, "high": z + h},
        {"shape": "sphere", "centre": (x, y, z), "radius": a},
        {"shape": "ellipsoid", "centre": (x, y, z), "semi_axis_xy": a, "semi_axis_z": h},
    )
    return shapes[rng.integers(4)]


def motion(rng: np.random.Generator) -> MoverMotion:
    """Return a motion of any kind."""
    kind = rng.integers(4)
    if kind == 0:
        points = [place(rng) for _ in range(rng.integers(1, 5))]
        then = str(rng.choice(["stays", "repeats", "returns"])) if len(points) > 1 else "stays"
        points += [points[0]] if then == "repeats" else []
        times = np.cumsum(rng.uniform(1, 8, len(points))) - rng.uniform(0, 10)
        return sky.WaypointMotion(points=points, times=times.tolist(), then=then)
    if kind == 1:
        given = {"radius": rng.uniform(1, 15), "period": rng.uniform(4, 60), "bearing": rng.uniform(0, 360)}
        return sky.CircularMotion(centre=place(rng), clockwise=bool(rng.random() < 0.5), **given)
    if kind == 2:
        rows = [tuple(row) for row in rng.uniform(-5, 5, (6, 3)).round(3).tolist()]
        return sky.PeriodicMotion(centre=place(rng), period=rng.uniform(5, 60), cosine=rows[:3], sine=rows[3:])
    knots = np.cumsum(rng.uniform(2, 8, rng.integers(2, 5))) - 2
    spline = CubicSpline(knots, np.array([place(rng) for _ in knots])) if len(knots) > 2 else None
    rows = np.swapaxes(spline.c[::-1], 0, 1) if spline else np.array([[place(rng), rng.uniform(-2, 2, 3)]])
    return sky.PolynomialMotion(knots=knots.tolist(), coefficients=rows.tolist())


def zone(rng: np.random.Generator) -> dict[str, object]:
    """Return a zone that must not be entered, or only slowly, at times."""
    (x, y, z), (a, b, h) = place(rng), rng.uniform(2, 8, 3)
    edges = np.cumsum(rng.uniform(0.5, 12, 4)).round(3).tolist()
    spans = [[edges[0], edges[1]], [edges[2], edges[3]]][: rng.integers(1, 3)]
    if rng.random() < 0.3:
        spans[0][0] = None
    more = {"active": spans} | ({"max_speed": rng.uniform(0.3, 3)} if rng.random() < 0.4 else {})
    bend = [(0, 0), (2 * a, 0), (2 * a, b), (a, b), (a, 2 * b), (0, 2 * b)]
    shapes = (
        {"min": (x - a, y - b, z - h), "max": (x + a, y + b, z + h)},
        {"shape": "cylinder", "centre": (x, y), "radius": a, "low": z - h, "high": z + h},
        {"shape": "sphere", "centre": (x, y, z), "radius": a},
        {"shape": "prism", "vertices": [(x + u, y + v) for u, v in bend], "low": z - h, "high": z + h},
    )
    return shapes[rng.integers(4)] | more
