"""Reflights of random gaps beside the linear programme of strips: photos, and whether all is seen again."""

import math

import numpy as np
import scipy.sparse as sparse
import shapely
from machine import table
from scipy.optimize import linprog

import skyverse as sky
from skyverse.referee.flown_photos import SHARES_LESS

SIDE, GSD, OVERLAP, CELL = 200.0, 0.02, (80, 60), 3.0
ORIGIN = 150.0


def scenario(hilly: bool, seed: int) -> sky.Scenario:
    rng = np.random.default_rng(seed)
    axis = np.arange(-ORIGIN, SIDE + ORIGIN + 1, 10.0)
    a, b = rng.uniform(60, 100, 2)
    heights = 20 + 12 * np.sin(axis / a)[:, None] * np.cos(axis / b)[None]
    ground = {"origin": (-ORIGIN, -ORIGIN), "step": (10, 10), "heights": heights}
    corners = [(0.0, 0.0), (SIDE, 10.0), (SIDE - 20.0, SIDE), (10.0, SIDE - 10.0)]
    uav = sky.UAV(start=(-30.0, -30.0, 60.0), end="home", max_speed=12.0, max_acceleration=3.0)
    return sky.Scenario(
        name="reflight",
        bounds={"min": (-140, -140, 0), "max": (SIDE + 140, SIDE + 140, 250)},
        clearance=3.0,
        uavs=(uav,),
        terrain=ground if hilly else None,
        surveys=(sky.Survey(corners, "mavic-3e", gsd=GSD, overlap=OVERLAP),),
    )


def programme(given: sky.Scenario, gaps: tuple, direction: float, depth: float) -> float:
    """Return the least photos of strips that see the cells of gaps, of the linear programme, on level ground.

    Strips lie in the direction of the survey, at every twentieth of their spacing. Each is cut along to cells of the
    way from photo to photo; a variable says how much of a cell of it is flown, another how much of a strip begins
    there, which costs a photo more. Each cell of the gaps lies wholly beside flown cells, within half of the width of
    what photos are certain to show (the attitude error off), as a row of the programme asks; where photos share less
    than asked, within half of the spacing of strips.
    """
    survey = given.surveys[0]
    across, along = survey.camera.half_widths
    lost = math.radians(survey.camera.attitude_error) * (1 + across**2)
    half = depth * (across - lost)
    step, spacing = 2 * depth * along * (1 - OVERLAP[0] / 100), 2 * depth * across * (1 - OVERLAP[1] / 100)
    where = shapely.union_all([shapely.Polygon(gap.outline) for gap in gaps])
    short = shapely.union_all([shapely.Polygon(gap.outline) for gap in gaps if gap.why == SHARES_LESS])
    angle = math.radians(direction)
    ahead, right = np.array([math.sin(angle), math.cos(angle)]), np.array([math.cos(angle), -math.sin(angle)])
    x0, y0, x1, y1 = where.bounds
    x, y = (one.ravel() for one in np.meshgrid(np.arange(x0, x1, CELL) + CELL / 2, np.arange(y0, y1, CELL) + CELL / 2))
    inside = shapely.contains_xy(where, x, y)
    places = np.column_stack([x, y])[inside]
    u, v = places @ right, places @ ahead
    offsets = np.arange(u.min() - half, u.max() + half, spacing / 20)
    row = np.floor((v - v.min()) / step).astype(int)
    n, m = len(offsets), int(row.max()) + 1
    shared = shapely.contains_xy(short, *places.T) if not short.is_empty else np.zeros(len(places), dtype=bool)
    cells = np.unique(np.column_stack([row, np.round(u / CELL), shared]).astype(int), axis=0)
    reach = np.where(cells[:, 2:] > 0, (spacing + CELL) / 2, half)
    near = np.abs(cells[:, 1, None] * CELL - offsets) <= reach
    k, j = np.nonzero(near)
    cover = sparse.csr_matrix((-np.ones(len(k)), (k, j * m + cells[k, 0])), shape=(len(cells), 2 * n * m))
    flown = np.arange(n * m)
    first = flown % m == 0
    begins = sparse.csr_matrix(
        (
            np.r_[np.ones(n * m), -np.ones((~first).sum()), -np.ones(n * m)],
            (np.r_[flown, flown[~first], flown], np.r_[flown, flown[~first] - 1, n * m + flown]),
        ),
        shape=(n * m, 2 * n * m),
    )
    rows = sparse.vstack([cover, begins])
    limits = np.r_[-np.ones(len(cells)), np.zeros(n * m)]
    return float(linprog(np.ones(2 * n * m), rows, limits, bounds=(0, 1), method="highs").fun)


def reflight(runs: int = 20) -> None:
    """Take photos away at random: runs of them, single ones, whole strips; fly again what is missing."""
    rows, ratios, seen, proven = [], [], 0, 0
    number = 0
    for seed in range(10 * runs):
        if number == runs:
            break
        hilly, kind = bool(seed % 2), ("run", "single", "strip", "two runs")[seed // 2 % 4]
        given = scenario(hilly, seed)
        photos = sky.photos_of(sky.plan_mission(given, rng=1))
        rng = np.random.default_rng(seed)
        left = np.ones(len(photos), dtype=bool)
        if kind == "strip":
            left[photos.strip == rng.integers(photos.strip.max() + 1)] = False
        for _ in range({"single": 3, "two runs": 2, "run": 1, "strip": 0}[kind]):
            many = 1 if kind == "single" else int(rng.integers(5, 20))
            first = int(rng.integers(len(photos) - many))
            left[first : first + many] = False
        taken = photos.taken(left)
        (found,) = sky.check_photos(given, taken)
        if not found.gaps:
            continue
        number += 1
        missing = given.surveys[0].without(found, photos.direction)
        again = sky.photos_of(sky.plan_mission(given.model_copy(update={"surveys": missing}), rng=1))
        (whole,) = sky.check_photos(given, taken.joined(again))
        ground = 0.0 if given.terrain is None else given.terrain.height(again.position[:, :2])
        least = programme(given, found.gaps, photos.direction, float(np.median(again.position[:, 2] - ground)))
        ratios.append(len(again) / least)
        seen, proven = seen + (whole.seen[0] > 1 - 1e-9), proven + (whole.verdict is sky.Verdict.PROVEN)
        name = "hills" if hilly else "flat"
        taken_away = f"{kind}: {int((~left).sum())}"
        rows.append(
            [
                name,
                taken_away,
                str(len(found.gaps)),
                str(len(again)),
                f"{least:.1f}",
                f"{ratios[-1]:.2f}",
                whole.verdict.value,
            ]
        )
    table(["ground", "taken away", "gaps", "photos again", "programme", "ratio", "then"], rows)
    print(f"photos beside the programme: median {np.median(ratios):.2f}, worst {max(ratios):.2f}")
    print(f"with those that were taken before: {seen} of {number} see all, {proven} are proven")
