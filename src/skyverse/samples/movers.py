"""Random movers in a scenario: on circles, back and forth, on trefoil knots, and across from side to side."""

import math
from collections.abc import Callable
from typing import Literal, get_args

import numpy as np

from skyverse._typing import Floats
from skyverse.errors import InputError, require_number, require_whole
from skyverse.model.mover import Mover
from skyverse.model.mover_motions import CircularMotion, MoverMotion, PeriodicMotion, WaypointMotion
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Sphere

MoverKind = Literal["spinners", "patrols", "knots", "traffic"]

TRIES = 1000
"""How many random motions are tried for one mover."""
SAMPLES = 400
"""Instants at which a motion's distance from starts and targets is looked at."""
LEAST_SHARE, MOST_SHARE = 0.05, 0.2
"""Shares of the bounds' shorter level side that the sizes of motions lie between."""
KNOT_SIZE = (1 / 6, 1 / 5, 1 / 2)
"""How large a trefoil knot is along each axis, for the sizes given (J. Tordesillas, J. How, MADER, 2022)."""


def random_movers(
    scenario: Scenario,
    count: int = 10,
    *,
    kind: MoverKind = "spinners",
    speed: float = 1.0,
    radius: float | None = None,
    seed: int = 0,
) -> Scenario:
    """Return a scenario with random movers besides those that it has: spheres that keep away from starts and targets.

    Parameters
    ----------
    scenario
        What the movers are added to.
    count
        How many.
    kind
        ``"spinners"`` go round horizontal circles, ``"patrols"`` back and forth on a line, ``"knots"`` round trefoil
        knots, and ``"traffic"`` from side to side of the bounds and back.
    speed
        Their mean speed, m/s.
    radius
        Theirs, metres; a hundredth of the bounds' shorter level side if it is left out.
    seed
        The same seed makes the same movers.

    Returns
    -------
    Scenario
        The movers may pass through obstacles.

    Raises
    ------
    InputError
        If an argument is out of range, or starts and targets leave no space for a mover.
    """
    if kind not in get_args(MoverKind):
        raise InputError(f"expected {' or '.join(map(repr, get_args(MoverKind)))}, found {kind!r}", field="kind")
    for name, number in (("count", count), ("seed", seed)):
        require_whole(number, name, 0)
    require_number(speed, "speed", "m/s", 1e-3, 1e3)
    if radius is not None:
        require_number(radius, "radius", "metres", 1e-6, 1e6)
    rng = np.random.default_rng(seed)
    low, high = np.array(scenario.bounds.min), np.array(scenario.bounds.max)
    radius = round(float((high - low)[:2].min()) / 100, 6) if radius is None else float(radius)
    ends = np.array([*(uav.start for uav in scenario.uavs), *(target.position for target in scenario.targets)])
    away = 2.0 * (radius + scenario.clearance)
    movers = [
        Mover(
            name=f"{kind[:-1] if kind.endswith('s') else kind}-{number}",
            shape=Sphere(centre=(0, 0, 0), radius=radius),
            motion=_clear_motion(MOTIONS[kind], rng, low, high, speed, ends.reshape(-1, 3), away),
        )
        for number in range(1, count + 1)
    ]
    return Scenario.model_validate({**dict(scenario), "movers": (*scenario.movers, *movers)})


Draw = Callable[[np.random.Generator, Floats, Floats, float], MoverMotion]


def _clear_motion(
    draw: Draw, rng: np.random.Generator, low: Floats, high: Floats, speed: float, ends: Floats, away: float
) -> MoverMotion:
    """Return a motion that keeps away from starts and targets (n, 3), metres."""
    for _ in range(TRIES):
        motion = draw(rng, low, high, speed)
        cycle = motion.period if isinstance(motion, CircularMotion | PeriodicMotion) else 2.0 * np.ptp(_times(motion))
        places = motion.at(np.linspace(0.0, cycle, SAMPLES))
        gaps = np.linalg.norm(places[:, None] - ends, axis=2)
        if gaps.min(initial=np.inf) >= away:
            return motion
    raise InputError(f"random_movers found no motion that keeps {away:g} m away from all starts and targets")


def _times(motion: MoverMotion) -> tuple[float, ...]:
    return motion.times if isinstance(motion, WaypointMotion) else (0.0, 1.0)


def _size(rng: np.random.Generator, low: Floats, high: Floats) -> float:
    return float((high - low)[:2].min() * rng.uniform(LEAST_SHARE, MOST_SHARE))


def _rounded(point: Floats) -> tuple[float, float, float]:
    x, y, z = np.round(point, 6).tolist()
    return x, y, z


def _spinner(rng: np.random.Generator, low: Floats, high: Floats, speed: float) -> MoverMotion:
    radius = round(_size(rng, low, high), 6)
    return CircularMotion(
        centre=_rounded(rng.uniform(low, high)),
        radius=radius,
        period=round(2.0 * math.pi * radius / speed, 6),
        bearing=round(float(rng.uniform(0.0, 360.0)), 3),
        clockwise=bool(rng.random() < 0.5),
    )


def _patrol(rng: np.random.Generator, low: Floats, high: Floats, speed: float) -> MoverMotion:
    course, size = rng.uniform(0.0, 2.0 * math.pi), _size(rng, low, high)
    half = size * np.array([math.sin(course), math.cos(course), 0.0])
    centre = rng.uniform(low, high)
    return _to_and_fro(rng, centre - half, centre + half, speed)


def _traffic(rng: np.random.Generator, low: Floats, high: Floats, speed: float) -> MoverMotion:
    one, other = rng.uniform(low, high), rng.uniform(low, high)
    axis = int(rng.integers(2))
    one[axis], other[axis], other[2] = low[axis], high[axis], one[2]
    return _to_and_fro(rng, one, other, speed)


def _to_and_fro(rng: np.random.Generator, one: Floats, other: Floats, speed: float) -> WaypointMotion:
    """Return a motion between two places that is somewhere on its first way or its way back at 0 s."""
    seconds = math.dist(other, one) / speed
    begin = -float(rng.uniform(0.0, 2.0 * seconds))
    return WaypointMotion(
        points=(_rounded(one), _rounded(other)),
        times=(round(begin, 6), round(begin + seconds, 6)),
        then="returns",
    )


def _knot(rng: np.random.Generator, low: Floats, high: Floats, speed: float) -> MoverMotion:
    """Return x = sin a + 2 sin 2a, y = cos a - 2 cos 2a, z = -sin 3a, of a random size, from a random angle on."""
    size = 3.0 * _size(rng, low, high) * np.array(KNOT_SIZE)
    size[2] = min(size[2], (high - low)[2] / 4)
    phase = rng.uniform(0.0, 2.0 * math.pi)
    cosine, sine = np.zeros((3, 3)), np.zeros((3, 3))
    for axis, k, of_sine, of_cosine in ((0, 1, 1, 0), (0, 2, 2, 0), (1, 1, 0, 1), (1, 2, 0, -2), (2, 3, -1, 0)):
        c, s = math.cos(k * phase), math.sin(k * phase)
        cosine[k - 1, axis] += size[axis] * (of_sine * s + of_cosine * c)
        sine[k - 1, axis] += size[axis] * (of_sine * c - of_cosine * s)
    angle = np.linspace(0.0, 2.0 * math.pi, SAMPLES)
    terms = np.arange(1, 4)
    angles = angle[:, None] * terms
    slopes = np.einsum("ij,jk->ik", np.cos(angles) * terms, sine)
    slopes -= np.einsum("ij,jk->ik", np.sin(angles) * terms, cosine)
    length = float(np.linalg.norm(slopes, axis=1).mean()) * 2.0 * math.pi
    return PeriodicMotion(
        centre=_rounded(rng.uniform(low, high)),
        period=round(length / speed, 6),
        cosine=tuple(map(_rounded, cosine)),
        sine=tuple(map(_rounded, sine)),
    )


MOTIONS: dict[str, Draw] = {"spinners": _spinner, "patrols": _patrol, "knots": _knot, "traffic": _traffic}
