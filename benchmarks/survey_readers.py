"""Files of planned surveys, read by readers that others wrote, and compared with what was exported.

Readers are pymavlink, litchi-wp and djikmz, where they are installed. The survey items of QGroundControl are compared
with stored plans that it has written itself, of a folder.
"""

import importlib
import importlib.util
import json
import re
import sys
import tempfile
import zipfile
from collections import Counter
from pathlib import Path

import skyverse as sky

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
from flown_surveys import flat, planned
from planned_surveys import KINDS, planned_survey

WITH_TERRAIN = 3
"""The distance mode of QGroundControl that it stores keys of the terrain with."""


def readers(stored: Path, first: int = 0) -> None:
    """Export a survey of each kind to each format, read the files with foreign readers, and print what is the same."""
    keys, found = _keys_of_plans(stored), Counter()
    print(f"keys of {len(keys)} kinds of survey items in stored plans of {stored.name}")
    for seed, kind in enumerate(KINDS, first):
        mission = planned_survey(kind, seed)
        for suffix, read in READERS.items():
            if read is not _survey_items and importlib.util.find_spec(MODULES[suffix]) is None:
                found[f"{suffix}: {MODULES[suffix]} is not installed"] += 1
                continue
            with tempfile.TemporaryDirectory() as folder:
                above = "home" if suffix == "litchi.csv" else "amsl"
                options = sky.ExportOptions(altitude=above, survey_item=suffix == "plan", allow_close=True)
                try:
                    files = sky.export(mission, Path(folder) / f"m.{suffix}", options)
                except sky.InputError:
                    found[f"{suffix}: refused"] += 1
                    continue
                for file in files:
                    wrong = [*read(file, keys)]
                    found[f"{suffix}: {'the same' if not wrong else 'differs'}"] += 1
                    for line in wrong[:3]:
                        print(f"  {kind} {seed}, {file.name}: {line}")
    for said, many in sorted(found.items()):
        print(f"{said}: {many}")


def _keys_of_plans(folder: Path) -> list[tuple[set[str], set[str], set[str]]]:
    """Return the keys of each stored survey item of today's version: its own, its style's, and its camera's."""
    plans = [json.loads(file.read_text())["mission"]["items"] for file in sorted(folder.rglob("*.plan"))]
    surveys = [item for items in plans for item in items if item.get("complexItemType") == "survey"]
    return [_keys(item) for item in surveys if item["TransectStyleComplexItem"].get("version") == 2]


def _keys(item: dict) -> tuple[set[str], set[str], set[str]]:
    style = item["TransectStyleComplexItem"]
    terrain = style["CameraCalc"].get("DistanceMode") == WITH_TERRAIN
    return (
        set(item),
        {key for key in style if not (terrain and key.startswith("Terrain"))},
        set(style["CameraCalc"]),
    )


def _survey_items(file: Path, keys: list):
    """Yield how survey items differ in keys from stored ones, and in photos from those that are expected."""
    items = json.loads(file.read_text())["mission"]["items"]
    for item in items:
        if item["type"] != "ComplexItem":
            continue
        if _keys(item) not in keys:
            yield f"keys {_keys(item)}"
        shots, count = item["TransectStyleComplexItem"]["CameraShots"], len(planned(file)[0])
        if shots != count:
            yield f"{shots} shots, {count} photos expected"
    numbers = [one["doJumpId"] for one in flat(items)]
    if numbers != [*range(1, len(numbers) + 1)]:
        yield "items are not numbered one after the other"


def _pymavlink(file: Path, _: list):
    """Yield how the rows differ that pymavlink reads."""
    loader = importlib.import_module("pymavlink.mavwp").MAVWPLoader()
    loader.load(str(file))
    rows = [line.split("\t") for line in file.read_text().splitlines()[1:]]
    if loader.count() != len(rows):
        yield f"{loader.count()} rows of {len(rows)}"
    for k, row in enumerate(rows):
        one = loader.wp(k)
        theirs = [one.command, one.frame, one.x, one.y, one.z]
        ours = [float(row[n]) for n in (3, 2, 8, 9, 10)]
        if max(abs(a - b) for a, b in zip(theirs, ours, strict=True)) > 1e-4:
            yield f"row {k}: {theirs}, told {ours}"


def _djikmz(file: Path, _: list):
    """Yield how the waypoints differ that djikmz reads of a template and of waylines."""
    reader = importlib.import_module("djikmz.model.waypoint").Waypoint
    parse = importlib.import_module("xmltodict").parse
    with zipfile.ZipFile(file) as archive:
        texts = [archive.read(f"wpmz/{name}").decode() for name in ("template.kml", "waylines.wpml")]
    marks = parse(texts[0])["kml"]["Document"]["Folder"]["Placemark"]
    for mark in marks:
        mark.pop("wpml:actionGroup", None)  # it knows none of distance and time
    places = [reader.from_dict(mark) for mark in marks]
    told = [tuple(map(float, pair.split(","))) for pair in re.findall(r"<coordinates>(.*?)<", texts[1])]
    if len(places) != len(told):
        yield f"{len(places)} waypoints of {len(told)}"
    for k, (one, (longitude, latitude)) in enumerate(zip(places, told, strict=False)):
        if max(abs(one.latitude - latitude), abs(one.longitude - longitude)) > 1e-9:
            yield f"waypoint {k}: {one.latitude}, {one.longitude}, told {latitude}, {longitude}"


def _litchi_wp(file: Path, _: list):
    """Yield how the lines differ that litchi-wp reads and writes again."""
    reader = importlib.import_module("litchi_wp.waypoint").Waypoint
    lines = file.read_text().splitlines()[1:]
    for k, line in enumerate(lines):
        ours, theirs = line.split(","), reader.from_line(line).to_line().strip().split(",")
        wrong = [n for n, (a, b) in enumerate(zip(ours, theirs, strict=True)) if abs(float(a) - float(b)) > 1e-6]
        if wrong:
            yield f"line {k}, column {wrong[0]}: {theirs[wrong[0]]}, told {ours[wrong[0]]}"


READERS = {"plan": _survey_items, "waypoints": _pymavlink, "wpml.kmz": _djikmz, "litchi.csv": _litchi_wp}
MODULES = {"plan": "json", "waypoints": "pymavlink", "wpml.kmz": "djikmz", "litchi.csv": "litchi_wp"}
