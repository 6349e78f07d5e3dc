"""Random missions on the globe, made without planning, and local metres by somebody else's geodesy."""

import itertools
import re
import zipfile
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import skyverse as sky
from proj_map import proj_local
from skyverse import (
    UAV,
    Bounds,
    Box,
    FixedWing,
    Frame,
    Lattice,
    Mission,
    Origin,
    Provenance,
    Scenario,
    Target,
    Terrain,
    TrackingError,
    Trajectory,
)

LOW, HIGH = (-300.0, -300.0, -50.0), (300.0, 300.0, 150.0)
NAMES = ("uav-1", "Häuser & <Söhne>", "a/b\\c:d", "UAV-1 ", "***")


def along(corners, seconds, begin=0.0):
    """Straight from corner to corner, at rest at each: minimum jerk."""
    corners = np.asarray(corners, dtype=float)
    rows = np.zeros((len(corners) - 1, 6, 3))
    for k, (a, b) in enumerate(itertools.pairwise(corners)):
        rows[k, 0] = a
        for power, share in ((3, 10.0), (4, -15.0), (5, 6.0)):
            rows[k, power] = share * (b - a) / seconds**power
    return Trajectory(begin + seconds * np.arange(len(corners)), rows)


def bent(a, middle, b, seconds, begin=0.0):
    """A parabola: it begins at a, heads for the middle, ends at b."""
    a, middle, b = (np.asarray(p, dtype=float) for p in (a, middle, b))
    rows = np.zeros((1, 3, 3))
    rows[0] = a, 2 * (middle - a) / seconds, (a - 2 * middle + b) / seconds**2
    return Trajectory(np.array([begin, begin + seconds]), rows)


def mission(
    trajectories,
    *,
    origin=None,
    boxes=(),
    terrain=None,
    names=None,
    clearance=0.5,
    wing=None,
    low=LOW,
    high=HIGH,
    from_home=False,
    error=None,
):
    """A mission of these trajectories, proven or not, whose UAVs state their starts as homes where they begin there."""
    starts = [t.at(t.start).position[0].tolist() for t in trajectories]
    ends = [t.at(t.end).position[0].tolist() for t in trajectories]
    names = names or [f"uav-{k}" for k in range(1, len(starts) + 1)]
    scenario = Scenario(
        name="by hand",
        bounds=Bounds(min=low, max=high),
        obstacles=tuple(Box(min=low, max=high) for low, high in boxes),
        clearance=clearance,
        terrain=terrain,
        lattice=Lattice(step=tuple((b - a) / 20 for a, b in zip(low, high, strict=True))),
        uavs=tuple(
            UAV(
                name=name,
                start=start,
                max_speed=30,
                max_acceleration=30,
                fixed_wing=wing,
                home=start[2] if from_home else None,
                tracking_error=error or TrackingError(),
            )
            for name, start in zip(names, starts, strict=True)
        ),
        targets=tuple(Target(position=end) for end in ends),
        frame=Frame(origin=origin),
    )
    nothing = (None,) * len(starts)
    made = Provenance("", "by hand", "", 0, "")
    return Mission(scenario, tuple(range(len(starts))), nothing, tuple(trajectories), (), made)


def random_mission(seed, terrain=False, towers=False):
    """One to three UAVs anywhere on the globe but near the poles; straight or bent flights, some of which wait."""
    rng = np.random.default_rng(seed)
    longitude = float(rng.choice([rng.uniform(-180, 180), 180.0, -179.9999, 0.0]))
    origin = Origin(
        latitude=float(rng.uniform(-75, 75)), longitude=longitude, altitude=float(rng.uniform(-100, 3000)), geoid=0.0
    )
    flights = []
    for _ in range(int(rng.integers(1, 4))):
        points = rng.uniform([-250, -250, 60], [250, 250, 120], (int(rng.integers(2, 6)), 3))
        begin = float(rng.choice([0.0, rng.uniform(0, 20)]))
        if len(points) == 3 and rng.random() < 0.7:
            flights.append(bent(*points, rng.uniform(10, 60), begin))
        else:
            flights.append(along(points, rng.uniform(5, 30), begin))
    heights = rng.uniform(-20, 20, (14, 14))
    under = Terrain(origin=(-325.0, -325.0), step=(50.0, 50.0), heights=heights, clearance=10.0) if terrain else None
    names = list(map(str, rng.permutation(NAMES)[: len(flights)]))
    wing = FixedWing(speed=15, turn_radius=40, climb=20) if rng.random() < 0.2 else None
    boxes = beside(rng, flights, 0.5, 3.0 if wing else 0.05) if towers else ()
    return mission(flights, origin=origin, terrain=under, names=names, wing=wing, boxes=boxes)


def beside(rng, flights, clearance, least):
    """Towers beside the ways, some nearly as near as the clearance, none nearer to any."""
    ways = [flight.at(np.linspace(flight.start, flight.end, 2000)).position for flight in flights]
    below = [np.linspace(way[0] * [1, 1, 0] - [0, 0, 50], way[0], 100) for way in ways]
    every = np.concatenate([*ways, *below])
    boxes = []
    for _ in range(12):
        way = ways[int(rng.integers(len(ways)))]
        place, half = way[int(rng.integers(len(way)))], rng.uniform(2, 10, 2)
        middle = place[:2] + rng.choice([-1, 1], 2) * (half + clearance + rng.uniform(least, 5))
        away = np.maximum(np.abs(every[:, :2] - middle) - half, 0)
        if np.hypot(*away.T).min() > clearance + least and np.abs(middle).max() < 280:
            boxes.append(((*(middle - half), -50.0), (*(middle + half), 140.0)))
    return boxes


def walk_among(rng, boxes, room, count, low, high, ground=None):
    """Random corners; nothing is within some room of the ways between them, nor of the first way up from the ground."""
    lows, highs = (np.array([box[k] for box in boxes]) for k in (0, 1))
    corners = []
    while len(corners) < count:
        place = rng.uniform(low, high)
        below = place if ground is None else np.array([*place[:2], ground])
        legs = np.linspace(corners[-1] if corners else below, place, 300)
        if not ((legs[:, None] > lows - room) & (legs[:, None] < highs + room)).all(axis=2).any():
            corners.append(place)
    return corners


local = proj_local


def climb(scenario, route):
    """How many metres a UAV climbs to its first waypoint from the ground below, where nothing stands; 0 in flight."""
    vehicle = scenario.uavs[route.uav]
    if vehicle.fixed_wing is not None:
        return 0.0
    ground = under(scenario, np.array([vehicle.start]))[0] if scenario.terrain is not None else vehicle.start[2]
    return route.waypoints[0][2] - (ground if vehicle.home is None else vehicle.home)


def takeoff_seconds(height, name):
    """How long a take-off takes by default, from the command for it to its end.

    ArduPilot rises after 1.2 s, gains and loses 2.5 m/s at 1 m/s^2. PX4 has to lose 0.7 m/s downwards first, at the
    0.5 m/s^2 at which it then gains 1.5 m/s; from 10 m on it climbs at 3 m/s.
    """
    if name == "ardupilot":
        return 1.2 + (height / 2.5 + 2.5 if height > 6.25 else 2 * np.sqrt(height))
    low = min(height, 10)
    slow = 3 + (low - 2.25) / 1.5 if low > 2.25 else np.sqrt(2 * low / 0.5)
    return 1.4 + slow + max(height - 10, 0) / 3 if height > 1e-9 else 1.4


def under(scenario, points):
    """The height of the bilinear ground, by SciPy."""
    from scipy.interpolate import RegularGridInterpolator

    terrain = scenario.terrain
    axes = [terrain.origin[k] + terrain.step[k] * np.arange(terrain.heights.shape[k]) for k in (0, 1)]
    return RegularGridInterpolator(axes, terrain.heights)(points[:, :2])


def waylines(path):
    """The text of the waylines in an archive."""
    with zipfile.ZipFile(path) as archive:
        return archive.read("wpmz/waylines.wpml").decode()


class Told(NamedTuple):
    """What an export proves of waypoints, what it says, and the files."""

    certificate: object
    notes: list
    files: list

    @property
    def back(self):
        """The way home of the only UAV."""
        (back,) = self.certificate.returns
        return back

    @property
    def said(self):
        return " ".join(self.notes)


def exported(mission, folder, suffix="plan", *, page=None, **how):
    """Export waypoints with some options."""
    seen, notes = [], []
    files = sky.export(
        mission,
        folder / f"m.{suffix}",
        sky.ExportOptions(**how),
        page=page,
        on_certificate=seen.append,
        on_note=notes.append,
    )
    return Told(seen[0], notes, files)


def parameters(folder, suffix="plan"):
    """The values of the parameter file beside a mission."""
    text = (folder / {"plan": "m.params", "waypoints": "m.param"}[suffix]).read_text()
    rows = [re.split(r"[\t,]", row) for row in text.splitlines() if row[0] != "#"]
    first = 2 if suffix == "plan" else 0
    return {row[first]: float(row[first + 1]) for row in rows}


def changed(mission, **fields):
    """The mission in a scenario with other fields."""
    return replace(mission, scenario=mission.scenario.model_copy(update=fields))


def with_uavs(mission, **fields):
    """The mission, whose UAVs have other fields."""
    return changed(mission, uavs=tuple(uav.model_copy(update=fields) for uav in mission.scenario.uavs))
