"""Random ground and photos of it, made without planners, and what rays find of the referee's claims about them."""

from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
import shapely

import skyverse as sky
from ray_caster import Cameras, Caster, seen
from skyverse.model.camera import CAMERAS
from skyverse.model.photos import Photos
from skyverse.model.scenario import Scenario
from skyverse.model.survey import Survey
from skyverse.model.uav import TrackingError
from skyverse.referee import coverage as judge
from skyverse.referee.blockers import blockers_of, bottoms_of, solids_of
from skyverse.referee.gaps import outlines_of
from skyverse.referee.ground_cells import grid_of
from skyverse.referee.photo_views import views_of
from skyverse.referee.relief import relief_of
from skyverse.referee.shown import Viewers

AROUND = 100.0
"""Metres of ground around what is to be seen."""
MARGIN = (0.1, 0.005, 0.02)
"""Degrees, share of the depth and metres by which what rays find must be certain to count as missed by the referee."""
WIDE_MARGIN = (1.0, 0.02, 0.1)
"""The same of cases that must be proven."""
CLEAR = 0.05
"""Metres by which the ground and solids must be beside the rays then."""


@dataclass(frozen=True)
class Case:
    """A scenario of one survey, photos of it, and the tracking error of the UAV that takes them."""

    scenario: Scenario
    photos: Photos
    error: TrackingError

    def judged(self):
        return judge.judge_coverage(self.scenario, 0, self.photos, [self.error])


def slopes(rng, extent, step, steepest):
    """Return heights of rough or gentle ground whose steepest slope is as said, degrees."""
    n = max(int(np.ceil(extent / step)), 3) + 1
    k = np.hypot(np.fft.fftfreq(n, step)[:, None], np.fft.rfftfreq(n, step)[None])
    sizes = np.where(k > 0, np.maximum(k, 1 / extent) ** -rng.uniform(1.8, 3.5), 0.0)
    h = np.fft.irfft2(sizes * np.exp(2j * np.pi * rng.random(sizes.shape)), s=(n, n))
    x, y = np.meshgrid(np.arange(n) * step, np.arange(n) * step, indexing="ij")
    h = (
        h / max(np.abs(h).max(), 1e-9) * rng.uniform(0, 1)
        + rng.uniform(-1, 1) * x / extent
        + rng.uniform(-1, 1) * y / extent
    )
    steep = max(float(np.abs(np.diff(h, axis=k)).max()) for k in (0, 1)) * np.sqrt(2) / step
    h = h * np.tan(np.radians(steepest)) / max(steep, 1e-9)
    return h - h.min()


def photo_lines(rng, ground, low, high, camera, height, overlap, heading, pitch, follow):
    """Return photos along parallel lines over a box, (n, 6): places, heading, pitch and line."""
    wide, tall = (2 * half * height for half in camera.half_widths)
    side, front = wide * (1 - overlap[1] / 100), tall * (1 - overlap[0] / 100)
    middle, reach = (low + high) / 2, float(np.hypot(*(high - low))) / 2
    course = np.array([np.sin(np.radians(heading)), np.cos(np.radians(heading))])
    across = np.array([course[1], -course[0]])
    back = height / np.tan(np.radians(-pitch)) if pitch > -89 else 0.0
    rows, level = [], float(np.max(ground(middle[None] + np.linspace(-1, 1, 9)[:, None] * (high - low) / 2)))
    for number, a in enumerate(np.arange(-reach - side / 2, reach + side, side)):
        for b in np.arange(-reach - front, reach + 1.5 * front, front):
            seen_at = middle + a * across + b * course
            if ((seen_at < low - 0.35 * wide) | (seen_at > high + 0.35 * wide)).any():
                continue
            at = seen_at - back * course
            z = float(ground(seen_at[None])[0]) if follow else level
            turn = heading if number % 2 == 0 or pitch > -89 else heading + 180.0
            rows.append((*at, z + height, turn % 360.0, pitch, number))
    return rows


def random_case(seed, most=40):
    """Return ground of random cells and slopes with buildings, and photos that look down, or aslant."""
    rng = np.random.default_rng(seed)
    camera = list(CAMERAS.values())[int(rng.integers(len(CAMERAS)))].model_copy(
        update={"attitude_error": float(rng.choice([0.0, 0.5, 1.0, 2.0, 3.0]))}
    )
    error = TrackingError(horizontal=float(rng.choice([0, 0.3, 1.0])), vertical=float(rng.choice([0, 0.3, 1.0])))
    size = float(rng.uniform(25, 90))
    step = float(np.exp(rng.uniform(0, np.log(90))))
    extent = size + 2 * AROUND
    terrain = None
    if rng.random() < 0.95:
        steps = (step, step if rng.random() < 0.7 else step * float(rng.uniform(0.6, 1.0)))
        heights = slopes(rng, extent + 2 * step, min(steps), float(rng.uniform(0, 45)))
        terrain = {
            "origin": (-AROUND - rng.uniform(1, 2) * steps[0], -AROUND - rng.uniform(1, 2) * steps[1]),
            "step": steps,
        }
        terrain["heights"] = np.pad(heights, 2, mode="edge")
        record = sky.Terrain(**terrain)
        ground = record.height
    else:

        def ground(places):
            return np.zeros(len(places))

    obstacles = [_building(rng, ground, size, number) for number in range(int(rng.integers(0, 5)))]
    area = _area(rng, size)
    low, high = (
        np.array(corner)
        for corner in np.split(
            np.array(
                shapely.bounds(
                    shapely.union_all([shapely.polygons(part["vertices"], part.get("holes")) for part in area])
                )
            ),
            2,
        )
    )
    overlap = float(rng.uniform(40, 80)), float(rng.uniform(30, 75))
    pitch = float(rng.choice([-90, -90, -90, -75, -60, -45]))
    for height in np.geomspace(0.45 * size, 3 * size, 12) * rng.uniform(0.8, 1.2):
        heading, follow = float(rng.uniform(0, 360)), bool(rng.random() < 0.6)
        rows = photo_lines(rng, ground, low, high, camera, height, overlap, heading, pitch, follow)
        if rng.random() < 0.4:
            rows += photo_lines(rng, ground, low, high, camera, height, overlap, heading + 90, pitch, follow)
        if len(rows) <= most:
            break
    table = np.array(rows)
    highest = float(ground(table[:, :2]).max())
    table = table[table[:, 2] > ground(table[:, :2]) + 3.0]
    n = len(table)
    roll = rng.uniform(-5, 5, n) if rng.random() < 0.3 else np.zeros(n)
    photos = Photos(
        table[:, :3],
        table[:, 3],
        table[:, 4],
        roll,
        np.full(n, np.nan),
        np.zeros(n, dtype=int),
        table[:, 5].astype(int),
    )
    asked = (
        {"height": height}
        if rng.random() < 0.3
        else {"gsd": min(max(camera.gsd(height * rng.uniform(1.0, 1.6)), 2e-4), 1.0)}
    )
    survey = Survey(
        area,
        camera,
        overlap=(0, 0),
        gsd_of=str(rng.choice(["photo", "place"])),
        margin=float(rng.choice([0, 0, 3.0])),
        **asked,
    )
    return Case(_scenario(survey, terrain, obstacles, size, highest + 4 * height), photos, error)


def _scenario(survey, terrain, obstacles, size, top):
    return Scenario(
        name="ground",
        bounds={"min": (-AROUND, -AROUND, 0.0), "max": (size + AROUND, size + AROUND, top + 300.0)},
        clearance=1.0,
        lattice={"step": (50, 50, 50)},
        surveys=(survey,),
        terrain=terrain,
        obstacles=obstacles,
        uavs=({"start": (0, 0, top + 100.0), "end": "home"},),
    )


def _area(rng, size):
    """Return a rectangle, one with a hole, a bent one, or some corners about a place."""
    kind = int(rng.integers(4))
    if kind == 0:
        angle = np.sort(rng.uniform(0, 2 * np.pi, 7)) if rng.random() < 0.5 else np.arange(7) * 2 * np.pi / 7
        reach = size / 2 * rng.uniform(0.6, 1.0, 7)
        ring = size / 2 + np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1)
        shape = shapely.Polygon(ring).buffer(0)
        if shape.geom_type == "Polygon" and shape.area > size**2 / 8:
            return ({"vertices": shapely.get_coordinates(shape.exterior)[:-1].tolist()},)
    square = [(0, 0), (size, 0), (size, 0.8 * size), (0, size)]
    if kind == 1:
        hole = (0.3 + 0.3 * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])) * size
        return ({"vertices": square, "holes": [hole.tolist()]},)
    if kind == 2:
        return ({"vertices": [(0, 0), (size, 0), (size, size / 2), (size / 2, size / 2), (size / 2, size), (0, size)]},)
    return ({"vertices": square},)


def _building(rng, ground, size, number):
    """Return an obstacle that stands on the ground, or hangs above it."""
    x, y = rng.uniform(0, size, 2)
    reach, tall = rng.uniform(2, 8), rng.uniform(2, 12)
    floor = float(ground(np.array([[x, y]]))[0])
    low = floor - 3.0 if rng.random() < 0.8 else floor + rng.uniform(1, 4)
    name = {"name": f"b{number}", "kind": "building"}
    kind = int(rng.integers(4))
    if kind == 0:
        return name | {
            "shape": "box",
            "min": (x - reach, y - reach / 2, low),
            "max": (x + reach, y + reach, floor + tall + 4),
        }
    if kind == 1:
        return name | {"shape": "cylinder", "centre": (x, y), "radius": reach, "low": low, "high": floor + tall + 4}
    if kind == 2:
        return name | {"shape": "sphere", "centre": (x, y, floor + tall), "radius": reach / 2}
    turn = rng.uniform(0, np.pi)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) * reach
    ring = np.array([(-1, -1), (1, -1), (1, 0), (0, 0), (0, 1), (-1, 1)]) @ axes + (x, y)
    return name | {"shape": "prism", "vertices": ring.tolist(), "low": low, "high": floor + tall + 4}


@dataclass
class Found:
    """What rays find of a case.

    Attributes
    ----------
    coverage
        What the referee says.
    places
        How many places were looked at.
    wrong
        In words, what the referee claims and rays deny.
    missed, certain
        Square metres that the referee does not count, and that rays find certain to be seen, with a margin.
    holds
        Whether all places are certain to be seen with the wide margin; those beside buildings without any.
    """

    coverage: object
    places: int
    wrong: list
    missed: float
    certain: float
    holds: bool


def asked_of(scenario):
    """Return what is to be seen of the ground: the area and its margin, without what solids stand on."""
    survey = scenario.surveys[0]
    parts = [shapely.Polygon(part.vertices, part.holes) for part in survey.area]
    return shapely.buffer(shapely.unary_union(parts), survey.margin) if survey.margin else shapely.unary_union(parts)


def sample(rng, shape, count):
    """Return places (n, 2) evenly spread in a shape."""
    if shape.is_empty or shape.area <= 0:
        return np.zeros((0, 2))
    low, high = np.split(np.array(shape.bounds), 2)
    share = shape.area / float(np.prod(high - low))
    shapely.prepare(shape)
    found = np.zeros((0, 2))
    for _ in range(60):
        tries = rng.uniform(low, high, (int(min(2 * count / max(share, 1e-3), 200_000)), 2))
        found = np.concatenate([found, tries[shapely.contains_xy(shape, *tries.T)]])
        if len(found) >= count:
            break
    return found[:count]


def _box(shape):
    """Return the least and the greatest corner of an obstacle."""
    kind = type(shape).__name__
    if kind == "Box":
        return shape.min, shape.max
    if kind == "Sphere":
        return np.array(shape.centre) - shape.radius, np.array(shape.centre) + shape.radius
    if kind == "Cylinder":
        level = np.array(shape.centre) - shape.radius, np.array(shape.centre) + shape.radius
    else:
        level = np.min(shape.vertices, axis=0), np.max(shape.vertices, axis=0)
    return (*level[0], shape.low), (*level[1], shape.high)


def standing(caster):
    """Return the obstacles that touch the ground somewhere: below them there is none to be seen."""
    found = []
    for shape in caster.obstacles:
        low, high = (np.array(corner) for corner in _box(shape))
        x, y = (grid.ravel() for grid in np.meshgrid(*np.linspace(low[:2], high[:2], 150).T))
        feet = np.column_stack([x, y, np.full(len(x), low[2] - 1.0)])
        own, rim = replace(caster, terrain=None, obstacles=(shape,)), _rim(shape)
        bottom = shape.centre[2] if type(shape).__name__ == "Sphere" else low[2]
        touches = own.blocked(feet, np.column_stack([x, y, np.maximum(caster.ground(x, y), low[2] - 1.0)]))
        if touches.any() or (caster.ground(*rim.T) >= bottom).any():
            found.append(shape)
    return tuple(found)


def _rim(shape):
    """Return places (n, 2) on the outline of an obstacle, its corners among them."""
    kind = type(shape).__name__
    if kind in ("Cylinder", "Sphere"):
        angle = np.linspace(0, 2 * np.pi, 65)
        return np.array(shape.centre[:2]) + shape.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    ring = shapely.box(*shape.min[:2], *shape.max[:2]) if kind == "Box" else shapely.Polygon(shape.vertices)
    return shapely.get_coordinates(shapely.segmentize(ring, 0.05))


def below(caster, obstacles, places, around=0.0):
    """Return of places (n, 3) whether they lie above, in or below some obstacles, or so near to that.

    Round obstacles stand for polygons about them, which are a little larger.
    """
    found = np.zeros(len(places), dtype=bool)
    for shape in obstacles:
        wider = around + 0.005 * getattr(shape, "radius", 0.0)
        ends = [places * [1, 1, 0] + [0, 0, z] for z in (-1e4, 1e4)]
        found |= replace(caster, terrain=None, obstacles=(shape,), slack=-wider).blocked(*ends)
    return found


def judged_and_lost(case):
    """Return what the referee says of a case, and exactly what it does not count: outlines of gaps have no holes."""
    lost = [shapely.Polygon()]

    def kept(polygons, size):
        lost.extend(polygons)
        return outlines_of(polygons, size)

    with patch.object(judge, "outlines_of", kept):
        coverage = case.judged()
    return coverage, shapely.union_all(lost)


def found_of(case, count=500, seed=0, random=8):
    """Return what rays find of a case on the ground."""
    rng, scenario = np.random.default_rng(seed), case.scenario
    survey, (coverage, lost) = scenario.surveys[0], judged_and_lost(case)
    caster = Caster(scenario.terrain, scenario.obstacles, np.zeros((0, 3, 3)), scenario.bounds.min[2])
    cameras = Cameras.of(survey, case.photos, [case.error])
    asked = asked_of(scenario)
    in_gaps, kept = asked.intersection(lost), asked.difference(lost)
    edge = kept.intersection(lost.buffer(0.02)) if coverage.gaps else shapely.Polygon()
    told, near, gap = sample(rng, kept, count), sample(rng, edge, count // 4), sample(rng, in_gaps, count // 2)
    level = np.concatenate([told, near, gap])
    places = np.column_stack([level, caster.ground(*level.T)])
    stand = standing(caster)
    under, beside = (below(caster, stand, places, around) for around in (0.0, 0.3))
    kind = np.repeat([0, 1, 2], [len(told), len(near), len(gap)])
    sure, depth = seen(caster, cameras, places, random=random, seed=seed)
    claimed = (kind < 2) & ~under
    wrong = [f"seen at {places[k].round(3).tolist()}" for k in np.flatnonzero(claimed & ~sure.any(axis=1))]
    best = np.where(sure, depth, np.inf).min(axis=1) * survey.camera.pixel
    coarser = np.flatnonzero(claimed & sure.any(axis=1) & (best > coverage.gsd * (1 + 1e-9)))
    wrong += [f"gsd {coverage.gsd} at {places[k].round(3).tolist()}, where it is {best[k]}" for k in coarser]
    if sure.any():
        any_ = float(depth[sure].max()) * survey.camera.pixel
        if survey.gsd is not None and any_ > coverage.gsd_any * (1 + 1e-9):
            wrong.append(f"gsd_any {coverage.gsd_any}, where a photo has {any_}")
    free = ~below(caster, caster.obstacles, places)
    wrong += _counts_wrong(case, places[free], sure[free], depth[free])
    # false alarms
    careful = replace(caster, slack=-CLEAR, lean=np.tan(np.radians(MARGIN[0])))
    sure2 = seen(careful, cameras.stricter(*MARGIN), places, random=random, seed=seed)[0].any(axis=1) & ~beside
    missed = in_gaps.area * float(sure2[kind == 2].mean()) if len(gap) else 0.0
    certain = kept.area * float(sure2[kind == 0].mean() if len(told) else 0) + missed
    coarse, fine, holds = False, True, False
    if survey.gsd is not None and survey.gsd_of == "photo":
        deep = np.where(*seen(caster, replace(cameras, most=np.inf), places, random=random, seed=seed), 0.0)
        coarse = bool(deep.max() > cameras.most)
        fine = bool(deep.max() <= cameras.most * (1 - WIDE_MARGIN[1]))
    beside &= sure.any(axis=1) | under
    if fine and bool((sure2 | beside).all()):
        broad = replace(careful, lean=np.tan(np.radians(WIDE_MARGIN[0])))
        sure3 = seen(broad, cameras.stricter(*WIDE_MARGIN), places, random=random, seed=seed)[0].any(axis=1)
        holds = bool((sure3 | beside).all())
    if coverage.verdict.value == "refuted" and not coarse and not (~sure.any(axis=1) & ~under & (kind == 2)).any():
        wrong.append(f"refuted, but all places in gaps are certain to be seen: {coverage.sentence}")
    return Found(coverage, len(places), wrong, missed, certain, holds)


def _counts_wrong(case, places, sure, depth):
    """Return what whole cells claim more than rays find: how often, and how finely."""
    scenario, survey = case.scenario, case.scenario.surveys[0]
    grid = grid_of(scenario, survey, asked_of(scenario))
    views = views_of(case.photos, survey.camera, [case.error] * len(case.photos), survey.camera.attitude_error)
    relief = None if scenario.terrain is None else relief_of(scenario.terrain)
    most = np.inf if survey.gsd is None else survey.gsd / survey.camera.pixel
    solids = solids_of(scenario.obstacles)
    shown = Viewers(views, relief, blockers_of(solids, bottoms_of(solids), ()), most).show_grid(grid)
    i, j = (np.searchsorted(line, places[:, k]) - 1 for k, line in enumerate((grid.x, grid.y)))
    on = (i >= 0) & (j >= 0) & (i < grid.whole.shape[0]) & (j < grid.whole.shape[1])
    wrong = []
    for k in np.flatnonzero(on).tolist():
        said = int(shown.count[i[k], j[k]])
        if said > sure[k].sum():
            wrong.append(f"{said} photos at {places[k].round(3).tolist()}, where there are {sure[k].sum()}")
        elif said and depth[k][sure[k]].min() > shown.depth[i[k], j[k]] + 1e-6:
            wrong.append(
                f"depth {shown.depth[i[k], j[k]]} at {places[k].round(3).tolist()}, not {depth[k][sure[k]].min()}"
            )
    return wrong
