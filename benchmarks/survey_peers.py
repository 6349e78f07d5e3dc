"""Strips beside those of other planners of surveys, on the same areas, at equal coverage, by one judge.

The judge knows strips in their order and nothing else of a planner. Photos are taken at both ends of a strip, and no
farther apart than the step between. What is *seen* lies within a photo; what is *kept* lies within half a step of a
photo along its strip and half a spacing across, so that the overlap that was asked for is kept there. Time is by legs
from rest to rest, straight ones from strip to strip, and those of ours round zones.
"""

import csv
import json
import re
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from machine import table
from survey_zones import blob
from sweep_routes import sweep_route

import skyverse as sky
from skyverse.survey.leg_time import LegTime
from skyverse.survey.sweep import sweep

CAMERA = sky.CAMERAS["mavic-3e"]
HEIGHT = 75.0
FRONT, SIDE = 0.8, 0.7
COST = LegTime(10.0, 2.0)
PHOTO = np.array(CAMERA.sensor[::-1]) * HEIGHT / CAMERA.focal
"""Metres along and across a strip that a photo shows."""

STEP, SPACING = PHOTO * (1.0 - np.array([FRONT, SIDE]))
EQUAL = (0.005, 0.001)
"""How much less of an area a peer may keep and still be compared: first a tip that is left out, then hardly any."""

SAME = 1e-6
AREAS = 50
RUNNER = Path(__file__).parent / "peers" / "survey_routes.py"
PLANNERS = ("opencoverage", "uav-coverage-path-planner", "covplan", "coverage-path-planner", "drone-flightplan")


class Judged(NamedTuple):
    """What a plan is worth: shares of the area, photos, seconds, metres of legs within holes, and how it was made."""

    kept: float
    seen: float
    photos: int
    seconds: float
    within: float
    how: str


def photos_of(strips: np.ndarray, size: np.ndarray) -> Any:
    """Return the union of rectangles round the photos of strips, `size` metres along and across."""
    length = np.hypot(*(strips[:, 1] - strips[:, 0]).T)
    way = (strips[:, 1] - strips[:, 0]) / np.maximum(length, SAME)[:, None]
    # rectangles along one strip are no farther apart than they are long: together they are one
    begin, end = strips[:, 0] - 0.5 * size[0] * way, strips[:, 1] + 0.5 * size[0] * way
    side = 0.5 * size[1] * np.column_stack([way[:, 1], -way[:, 0]])
    return shapely.union_all(
        shapely.polygons(np.stack([begin + side, end + side, end - side, begin - side], 1)), grid_size=SAME
    )


def judge(area: Any, strips: np.ndarray, legs: np.ndarray, how: str) -> Judged:
    """Judge the strips (m, 2, 2) of a plan, and the legs (k, 2, 2) that are flown from its first end to its last."""
    length = np.hypot(*(strips[:, 1] - strips[:, 0]).T)
    holes = shapely.union_all([shapely.Polygon(hole) for hole in area.interiors]).buffer(-1e-3)
    return Judged(
        photos_of(strips, np.array([STEP, SPACING])).intersection(area).area / area.area,
        photos_of(strips, PHOTO).intersection(area).area / area.area,
        int(np.ceil(length / STEP - SAME).sum()) + len(strips),
        float(COST(legs[:, 1] - legs[:, 0]).sum()),
        float(shapely.length(shapely.intersection(shapely.linestrings(legs), holes)).sum()),
        how,
    )


def ours(area: Any) -> Judged:
    zones = shapely.union_all([shapely.Polygon(hole) for hole in area.interiors])
    free = shapely.box(*area.buffer(500.0).bounds).difference(zones)
    plan = sweep(area, free, SPACING, cost=COST, reach=0.5 * STEP)
    route = sweep_route(plan.strips, free, COST)
    legs = np.stack([route.points[:-1], route.points[1:]], 1)
    return judge(area, route.strips, legs, f"{len(plan.directions)} directions")


def straight(area: Any, strips: np.ndarray, how: str) -> Judged:
    stops = strips.reshape(-1, 2)
    return judge(area, strips, np.stack([stops[:-1], stops[1:]], 1), how)


def equal(plans: list[Judged], we: Judged, share: str, less: float) -> list[Judged]:
    """Return the plans that keep (or see) as much of an area as ours, `less` at most, and fly through no hole."""
    return [plan for plan in plans if getattr(plan, share) >= getattr(we, share) - less and plan.within < SAME]


def quickest(plans: list[Judged]) -> Judged | None:
    return min(plans, key=lambda plan: plan.seconds, default=None)


def compared(mine: list[Judged], theirs: list[list[Judged]], share: str, less: float) -> list[str]:
    """Return cells: areas compared, where no plan of theirs needs as few photos and as little time, and ratios."""
    fair = [(we, equal(plans, we, share, less)) for we, plans in zip(mine, theirs, strict=True)]
    fair = [(we, plans) for we, plans in fair if plans]
    won = [not any(beats(plan, we) for plan in plans) for we, plans in fair]
    firsts = [(we, min(plans, key=lambda plan: plan.seconds)) for we, plans in fair]
    both = sum(we.photos < first.photos and we.seconds < first.seconds for we, first in firsts)
    ratios = np.array([(we.photos / first.photos, we.seconds / first.seconds) for we, first in firsts])
    middle = np.median(ratios, axis=0) if len(ratios) else np.full(2, np.nan)
    return [str(len(fair)), str(sum(won)), str(both), *(f"{ratio:.3f}" for ratio in middle)]


def beats(plan: Judged, we: Judged) -> bool:
    return plan.photos <= we.photos and plan.seconds <= we.seconds + SAME


def left_out(mine: list[Judged], theirs: list[list[Judged]], share: str, slack: float) -> list[str]:
    """Return cells: on how many areas every plan of theirs sees less, flies through a hole, or there is none."""
    less = holes = none = 0
    for we, plans in zip(mine, theirs, strict=True):
        if not equal(plans, we, share, slack):
            enough = any(getattr(plan, share) >= getattr(we, share) - slack for plan in plans)
            less, holes, none = less + (bool(plans) and not enough), holes + enough, none + (not plans)
    return [str(less), str(holes), str(none)]


def random_areas() -> Iterator[tuple[str, Any]]:
    """Yield areas: convex ones, concave ones, fields with straight sides, and areas with holes that are zones."""
    seed = 0
    while True:
        rng = np.random.default_rng([36, seed])
        kind, size = ("convex", "concave", "field", "holes")[seed % 4], rng.uniform(180.0, 420.0)
        if kind == "field":
            boxes = [shapely.box(0, 0, *rng.uniform(0.6, 1.6, 2) * size)]
            for _ in range(int(rng.integers(1, 4))):
                x, y = rng.uniform(-0.4, 1.0, 2) * size
                boxes.append(shapely.box(x, y, *(np.array([x, y]) + rng.uniform(0.3, 1.2, 2) * size)))
            area = shapely.affinity.skew(shapely.union_all(boxes), *rng.uniform(-15, 15, 2))
            area = shapely.affinity.rotate(area, rng.uniform(0, 180))
        else:
            area = blob(rng, np.zeros(2), size, int(rng.integers(5, 14)))
            area = area.convex_hull if kind == "convex" else area
        if kind == "holes":
            for place in rng.uniform(-0.6, 0.6, (int(rng.integers(1, 6)), 2)) * size:
                hole = blob(rng, place, rng.uniform(0.08, 0.25) * size, int(rng.integers(3, 8)))
                area = area.difference(hole) if area.contains(hole.buffer(5.0)) else area
        simple = area.geom_type == "Polygon" and area.is_valid and area.area > (4.0 * SPACING) ** 2
        if simple and bool(area.interiors) == (kind == "holes"):
            yield f"{kind} {seed}", area
        seed += 1


def real_areas(folder: Path) -> Iterator[tuple[str, Any]]:
    """Yield areas of a folder of others' data, metres; those that are not geodetic are scaled to 20 ha."""

    def metres(latlon: Any) -> np.ndarray:
        points = np.array(latlon, dtype=float)[:, ::-1]
        scale = 111_320.0 * np.array([np.cos(np.radians(points[0, 1])), 1.0])
        return (points - points[0]) * scale

    def scaled(shell: Any, holes: Any = ()) -> Any:
        area = shapely.Polygon(shell, holes)
        area = shapely.affinity.scale(area, *[np.sqrt(200_000.0 / area.area)] * 2, origin=(0.0, 0.0))
        return shapely.affinity.translate(area, *-np.array(area.bounds[:2]))

    for file in sorted(folder.glob("ctu_gpl3/*_fly_zone.csv")):
        with file.open(encoding="utf-8") as lines:
            yield file.stem, shapely.Polygon(metres([row[:2] for row in csv.reader(lines) if len(row) >= 2]))
    for file in sorted(folder.glob("*/*.plan")):
        for item in json.loads(file.read_text(encoding="utf-8")).get("mission", {}).get("items", []):
            if len(item.get("polygon", ())) > 4:
                yield file.stem, shapely.Polygon(metres(item["polygon"]))
    for file in sorted(folder.glob("matlab*.csv")):
        rows = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines() if line[:1].isdigit()]
        yield file.stem, scaled(np.array(rows, dtype=float))
    for file in sorted(folder.glob("eth_gpl3/*.yaml")):
        text = file.read_text(encoding="utf-8").split("hull:")
        rings = []
        for part in (text[1].split("holes:")[0], *re.split(r"- *points:", text[0] + text[1].partition("holes:")[2])):
            found = re.findall(r"x: ([-\d.e]+),?\s+y: ([-\d.e]+)", part)
            rings += [np.array(found, dtype=float)] if len(found) > 2 else []
        yield file.stem, scaled(rings[0], rings[1:])
    for file in sorted(folder.glob("alenex24_mit/*.json")):
        wanted = json.loads(file.read_text(encoding="utf-8"))["original_area"]
        yield f"alenex {file.stem}", scaled(wanted["exterior"], wanted.get("interiors", ()))


def areas_of(folder: Path | None) -> list[tuple[str, Any]]:
    found = [] if folder is None else [one for one in real_areas(folder) if one[1].is_valid]
    more = random_areas()
    return found[:20] + [next(more) for _ in range(AREAS - len(found[:20]))]


def routes(planner: str, python: Path, areas: list[tuple[str, Any]]) -> tuple[str, list[Any]] | None:
    """Return the version of a planner and what it plans for areas; None where it is not there."""
    camera = {"pixels": CAMERA.image, "pixel": CAMERA.sensor[0] / CAMERA.image[0], "focal": CAMERA.focal}
    camera |= {"interval": CAMERA.min_interval, "height": HEIGHT, "overlap": [FRONT, SIDE]}
    given = [{"shell": [*a.exterior.coords], "holes": [[*hole.coords] for hole in a.interiors]} for _, a in areas]
    task = {"planner": planner, "camera": camera, "speed": COST.speed, "step": STEP, "spacing": SPACING}
    asked = json.dumps(task | {"areas": given})
    done = subprocess.run([python, RUNNER], input=asked, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    if len(lines) != len(areas) + 1:
        return None
    return lines[0], [json.loads(line) for line in lines[1:]]


def report(
    mine: list[Judged], judged: dict[str, list[list[Judged]]], names: list[str], share: str, less: float
) -> None:
    every = {
        **judged,
        "all of them": [[one for some in plans for one in some] for plans in zip(*judged.values(), strict=True)],
    }
    head = ["peer", "compared", "ours better", "in both", "photos", "time", f"{share} less", "through holes", "no plan"]
    rows = [
        [peer, *compared(mine, plans, share, less), *left_out(mine, plans, share, less)]
        for peer, plans in every.items()
    ]
    table(head, rows)
    rows = []
    for name, we, *plans in zip(names, mine, *judged.values(), strict=True):
        for peer, some in zip(judged, plans, strict=True):
            better = quickest([plan for plan in equal(some, we, share, less) if beats(plan, we)])
            if better is not None:
                numbers = f"{better.photos} / {we.photos}", f"{better.seconds:.0f} / {we.seconds:.0f}"
                shares = f"{getattr(better, share):.2%} / {getattr(we, share):.2%}"
                rows.append([name, peer.split()[0], *numbers, shares, better.how])
    if rows:
        print("Not better (theirs / ours):")
        table(["area", "peer", "photos", "seconds", share, "how"], rows)


def peers(*given: Path) -> None:
    """Print on how many areas ours needs fewer photos or less time; give Pythons of environments, then a folder."""
    pythons = [path for path in given if not path.is_dir()]
    areas = areas_of(next((path for path in given if path.is_dir()), None))
    mine, times = [], []
    for _, area in areas:
        begun = time.perf_counter()
        mine.append(ours(area))
        times.append(time.perf_counter() - begun)
    print(f"{len(areas)} areas, {np.mean([we.kept for we in mine]):.2%} kept by ours, ", end="")
    print(f"{min(we.kept for we in mine):.2%} at least; {np.median(times):.2f} s for each")
    judged: dict[str, list[list[Judged]]] = {}
    with ThreadPoolExecutor(2) as pool:
        asked = [[pool.submit(routes, planner, python, areas) for python in pythons] for planner in PLANNERS]
    for planner, answers in zip(PLANNERS, asked, strict=True):
        found = next((one.result() for one in answers if one.result()), None)
        if found is None:
            print(f"{planner} is left out: none of the environments has it")
            continue
        judged[f"{planner} {found[0]}"] = [
            [straight(area, np.array(plan["strips"]), plan["how"]) for plan in one["plans"]]
            for (_, area), one in zip(areas, found[1], strict=True)
        ]
        print(
            f"{planner}: {np.median([one['seconds'] for one in found[1]]):.1f} s for each area, all settings; ", end=""
        )
        print(f"faults {sorted({one['fault'] for one in found[1] if one['fault']})}")
    for share, less in (*(("kept", less) for less in EQUAL), ("seen", EQUAL[0])):
        print(f"\nAt equal shares {share}, {less:.1%} less at most:")
        report(mine, judged, [name for name, _ in areas], share, less)
