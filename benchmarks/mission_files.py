"""How other people's missions are read: ``python benchmarks/mission_files.py FOLDER``.

Every file of a folder that ends as missions do is read, written unchanged, and written with its second waypoint moved.
What is found is compared, number by number, with what a foreign reader finds in the same files: pymavlink, MAVSDK,
litchi-wp, or xmltodict with the height and place of each of DJI's waypoints; one that is not installed is left out.
DJI's parts that are not packed (``waylines.wpml`` with ``template.kml``) are packed first. Where a file needs to be
told what its altitudes are counted from, or the geoid, "home" and 0 m are given.
"""

import argparse
import contextlib
import io
import json
import math
import socket
import sys
import tempfile
import zipfile
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import skyverse as sky
from skyverse.model.waypoints import OrderKind, Waypoints
from skyverse.orders.files import FORMATS

TOLD = {"altitude": "home", "geoid": 0.0}
Rows = list[tuple[float, ...]]
"""What a foreign reader finds: the numbers of each item, of which the last three are latitude, longitude, altitude."""


def pymavlink_rows(path: Path) -> Rows:
    """Return frame, command, the first four numbers and the place of each row but home."""
    from pymavlink.mavwp import MAVWPLoader

    loader = MAVWPLoader()
    loader.load(str(path))
    items = [loader.wp(k) for k in range(1, loader.count())]
    return [(i.frame, i.command, i.param1, i.param2, i.param3, i.param4, i.x, i.y, i.z) for i in items]


class MavsdkReader:
    """MAVSDK's ground station, which needs an autopilot, a simulated one, to be made."""

    def __init__(self) -> None:
        from mavsdk.component_type import ComponentType
        from mavsdk.mavsdk import Configuration, Mavsdk
        from mavsdk.plugins.mission_raw.mission_raw import MissionRaw

        kinds = (ComponentType.GROUND_STATION, ComponentType.AUTOPILOT)
        self.parts = [Mavsdk(Configuration.create_with_component_type(kind)) for kind in kinds]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.parts[1].add_any_connection(f"udpin://127.0.0.1:{port}")
        self.parts[0].add_any_connection(f"udpout://127.0.0.1:{port}")
        self.mission = MissionRaw(self.parts[0].first_autopilot(30.0))

    def rows(self, path: Path) -> Rows:
        """Return the same numbers as `pymavlink_rows`; fences and rally points of version 1 are left out for it."""
        plan = json.loads(path.read_text(encoding="utf-8-sig"))
        if '"coordinate"' in path.read_text(encoding="utf-8-sig"):
            raise ValueError("MAVSDK overlooks the places of QGroundControl's files until 2017")
        if (plan.get("geoFence") or {}).get("version") != 2 or (plan.get("rallyPoints") or {}).get("version") != 2:
            plan |= {"geoFence": {"circles": [], "polygons": [], "version": 2}}
            plan |= {"rallyPoints": {"points": [], "version": 2}}
        with tempfile.TemporaryDirectory() as folder:
            without = Path(folder) / "mission.plan"
            without.write_text(json.dumps(plan))
            items = self.mission.import_qgroundcontrol_mission(str(without)).mission_items
        return [(i.frame, i.command, i.param1, i.param2, i.param3, i.param4, i.x / 1e7, i.y / 1e7, i.z) for i in items]


def litchi_rows(path: Path) -> Rows:
    """Return heading, curve size and place of each line that litchi-wp takes."""
    from litchi_wp.waypoint import Waypoint

    with contextlib.redirect_stdout(io.StringIO()):
        lines = [one.to_line().split(",") for one in Waypoint.from_file(str(path))]
    if len(lines) != sum(bool(line.strip(", \t")) for line in path.read_text().splitlines()[1:]):
        raise ValueError("litchi-wp leaves out the lines that it does not understand")
    return [(float(line[3]), float(line[4]), *map(float, line[:3])) for line in lines]


def dji_rows(path: Path) -> Rows:
    """Return speed and place of each waypoint of the waylines, or else of the template."""
    import xmltodict

    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if name.endswith(("waylines.wpml", "template.kml"))]
        folder = xmltodict.parse(archive.read(max(names)), force_list=("Placemark",))["kml"]["Document"]["Folder"]
    found = []
    for mark in folder["Placemark"]:
        longitude, latitude, *_ = map(float, mark["Point"]["coordinates"].split(","))
        height = mark.get("wpml:executeHeight", mark.get("wpml:height"))
        found.append((float(mark.get("wpml:waypointSpeed", "nan")), latitude, longitude, float(height)))
    return found


def foreign_readers() -> dict[str, Callable[[Path], Rows]]:
    """Return the readers that are installed, by the endings of files."""
    found: dict[str, Callable[[Path], Rows]] = {}
    with contextlib.suppress(ImportError):
        import pymavlink.mavwp  # noqa: F401

        found[".waypoints"] = found[".txt"] = pymavlink_rows
    with contextlib.suppress(ImportError):
        found[".plan"] = MavsdkReader().rows
    with contextlib.suppress(ImportError):
        import litchi_wp  # noqa: F401

        found[".csv"] = litchi_rows
    with contextlib.suppress(ImportError):
        import xmltodict  # noqa: F401

        found[".kmz"] = dji_rows
    return found


def read(path: Path) -> Waypoints:
    """Read a file, and give it what it asks for."""
    told: dict[str, Any] = {}
    while True:
        try:
            return sky.read_waypoints(path, **told)
        except sky.InputError as error:
            asked = [one.field for one in error.sentence.give if one.field in TOLD and one.field not in told]
            if not asked:
                raise
            told[asked[0]] = TOLD[asked[0]]


def near(one: float, other: float) -> bool:
    """Tell whether two numbers are the same but for how MAVLink rounds them."""
    return one == other or (one != one and other != other) or math.isclose(one, other, rel_tol=2e-7, abs_tol=6e-8)


def agree(waypoints: Waypoints, rows: Rows) -> bool:
    """Tell whether a foreign reader finds the same places, of items or of waypoints alone, in the same order."""
    by_item = len(rows) == len(waypoints.orders)
    ours = waypoints.orders if by_item else [one for one in waypoints.orders if one.kind is OrderKind.WAYPOINT]
    if len(ours) != len(rows):
        return False
    for order, row in zip(ours, rows, strict=True):
        if order.place is None:
            continue
        theirs = row[-3:]
        here = theirs[:2] == (0.0, 0.0) or any(map(math.isnan, theirs[:2]))
        mine = (*order.place[:2], order.place[2].metres)
        if not all(near(a, b) or (here and a != a) or b != b for a, b in zip(mine, theirs, strict=True)):
            return False
    return True


def moved(waypoints: Waypoints) -> tuple[Waypoints, int] | None:
    """Return a mission with its second waypoint elsewhere, and the number of that among all waypoints with a place."""
    places = [k for k, one in enumerate(waypoints.orders) if one.kind is OrderKind.WAYPOINT and one.place]
    if len(places) < 2:
        return None
    orders = list(waypoints.orders)
    latitude, longitude, altitude = orders[places[1]].place  # type: ignore[misc]
    there = (latitude + 1e-4, longitude, type(altitude)(altitude.metres + 1.0))
    orders[places[1]] = replace(orders[places[1]], place=there)
    return replace(waypoints, orders=tuple(orders)), places[1]


def same_but_for_one(before: Rows, after: Rows) -> bool:
    """Tell whether all rows but one are the same to the last bit, and that one but for its place."""
    if len(before) != len(after):
        return False
    changed = [k for k, (one, other) in enumerate(zip(before, after, strict=True)) if repr(one) != repr(other)]
    return len(changed) == 1 and repr(before[changed[0]][:-3]) == repr(after[changed[0]][:-3])


def pack(folder: Path, into: Path) -> list[Path]:
    """Pack DJI's files that stand beside one another."""
    made = []
    for waylines in sorted(folder.rglob("*waylines.wpml")):
        path = into / f"{waylines.name.removesuffix('waylines.wpml').rstrip('+') or 'packed'}.kmz"
        with zipfile.ZipFile(path, "w") as archive:
            archive.write(waylines, "wpmz/waylines.wpml")
            template = waylines.with_name(waylines.name.replace("waylines.wpml", "template.kml"))
            if template.exists():
                archive.write(template, "wpmz/template.kml")
        made.append(path)
    return made


def main() -> int:
    """Read a folder, and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--refusals", action="store_true", help="print the sentence of each refusal")
    options = parser.parse_args()
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    readers = foreign_readers()
    with tempfile.TemporaryDirectory() as folder:
        files = [
            path
            for path in sorted(options.folder.rglob("*"))
            if path.is_file() and path.name.lower().endswith(tuple(FORMATS))
        ]
        files = [path for path in files if not path.name.endswith("template.kml")]
        for path in [*files, *pack(options.folder, Path(folder))]:
            try_file(path, Path(folder), readers, counts[path.suffix.lower()], options.refusals)
    columns = ("files", "read", "refused", "same bytes", "agree", "differ", "foreign refuses", "kept", "not kept")
    print("| format | " + " | ".join(columns) + " |\n|" + "---|" * (len(columns) + 1))
    for suffix, count in counts.items():
        print(f"| {suffix} | " + " | ".join(str(count[column]) for column in columns) + " |")
    return int(any(count["differ"] + count["not kept"] for count in counts.values()))


def try_file(
    path: Path, folder: Path, readers: dict[str, Callable[[Path], Rows]], count: Counter[str], tell: bool
) -> None:
    """Read and write one file, and count what comes of it."""
    count["files"] += 1
    try:
        waypoints = read(path)
    except sky.InputError as error:
        count["refused"] += 1
        if tell:
            print(str(error).removeprefix(f"{path.parent}/"), file=sys.stderr)
        return
    count["read"] += 1
    out = folder / f"written{path.suffix}"
    sky.write_waypoints(waypoints, out)
    count["same bytes"] += out.read_bytes() == path.read_bytes()
    reader = readers.get(path.suffix.lower())
    if reader is None or not waypoints.orders:
        return
    try:
        rows = reader(path)
    except Exception:
        count["foreign refuses"] += 1
        return
    count["agree" if agree(waypoints, rows) else "differ"] += 1
    if not agree(waypoints, rows):
        print(f"differs: {path}", file=sys.stderr)
    changed = moved(waypoints)
    if changed is None:
        return
    sky.write_waypoints(changed[0], out)
    kept = same_but_for_one(rows, reader(out)) and agree(read(out), reader(out))
    count["kept" if kept else "not kept"] += 1
    if not kept:
        print(f"not kept: {path}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
