"""Reads damaged files of every format: each must be read, or refused in one sentence, quickly and in little memory.

python benchmarks/fuzz_readers.py [MINUTES [FORMAT ...]] [--seed N] [--keep FOLDER]

Each file is read in a separate process, which is ended after 20 seconds and may use 3 GB more than at its start. Files
that give anything but a result or an `InputError` are kept in FOLDER (fuzz-failures), with the traceback.
"""

import argparse
import copy
import json
import multiprocessing
import random
import re
import resource
import shutil
import sys
import tempfile
import time
import traceback
import warnings
import xml.etree.ElementTree as ET
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from fuzz_seeds import write_seeds

SECONDS = 20.0
MEMORY = 3 << 30
SEEDS = Path(tempfile.gettempdir()) / f"skyverse-fuzz-{multiprocessing.current_process().pid}"
NUMBERS = ["0", "-1", "1", "nan", "inf", "-inf", "1e308", "1e-308", "99999999999999999999", "4294967295", "2147483648",
           "65536", "1000000", "0.5", "-0.0", "1e9", "180", "-181", "90.1"]  # fmt: skip
VALUES: list[Any] = [None, True, False, 0, -1, 1e308, float("nan"), 10**30, "", "x", "\0", "\u2028", "NaN", [], {},
                     [[]], [None], {"a": 1}, [0, 0, 0], [[[[]]]]]  # fmt: skip
FEATURES = (".geojson", ".kml", ".kmz", ".osm", ".pbf", ".gpkg", ".fgb", ".shp")
RASTERS = (".tif", ".asc", ".hgt", ".bil")


def read(path: Path) -> None:
    """Read a file as what its suffix says it is."""
    import skyverse as sky

    if path.suffix in RASTERS:
        area = (12.6745, 46.797, 12.68, 46.801)
        terrain = [sky.Raster(path, crs="EPSG:32632")]
        assert (
            sky.build_scenario(sky.BuildOptions("a", terrain=terrain, area=area, fill_nodata="nearest")).terrain
            is not None
        )
    elif path.name.startswith("aerial"):
        assert sky.build_scenario(sky.BuildOptions("a", voxels=[path], ground=sky.AboveSea(300))).terrain is not None
    elif path.suffix in FEATURES or path.name == "city.json":
        from skyverse.maps.georeference.reading import Choices
        from skyverse.maps.readers import read_features

        found = read_features(path, Choices(altitudes="agl", building_height=10.0, buffer=5.0))
        assert isinstance(found, list)
    else:
        assert isinstance(sky.read(path), sky.Scenario | sky.Mission)


def outcome(path: Path) -> tuple[str, str]:
    """Return how reading ended, and the message or traceback."""
    from skyverse.errors import InputError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            read(path)
    except InputError as error:
        said = str(error)
        return ("refused", said) if "\n" not in said and said.strip() else ("not one sentence", said)
    except Warning:
        return "warning", traceback.format_exc()
    except MemoryError:
        return "memory", traceback.format_exc()
    except BaseException:
        return "traceback", traceback.format_exc()
    return "read", ""


def work(line: Connection) -> None:
    """Read what is named, one file after another."""
    import skyverse as sky

    sky.read("map1")
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY + (1 << 30), resource.RLIM_INFINITY))
    while True:
        line.send(outcome(Path(line.recv())))


class Reader:
    """A process that reads; another one takes its place when it dies or takes too long."""

    def __init__(self) -> None:
        self._process: Any = None

    def read(self, path: Path) -> tuple[str, str]:
        """Return how reading ended, and the message or traceback."""
        if self._process is None:
            self._line, other = multiprocessing.Pipe()
            self._process = multiprocessing.get_context("spawn").Process(target=work, args=(other,), daemon=True)
            self._process.start()
            other.close()
            self._fresh = True
        self._line.send(str(path))
        try:
            # the first one loads libraries and compiles
            if self._line.poll(SECONDS * (6 if self._fresh else 1)):
                self._fresh = False
                return self._line.recv()
            ended = "timeout"
        except (EOFError, ConnectionResetError):
            ended = "crash"
        self._process.kill()
        self._process.join()
        code, self._process = self._process.exitcode, None
        return ended, f"exit code {code}"


def damaged(data: bytes, suffix: str, rng: random.Random) -> bytes:
    """Return a file's bytes with one or a few things wrong."""
    kinds = [truncated, flipped, copied, renumbered, renumbered]
    if suffix in (".json", ".geojson"):
        kinds += [json_changed] * 5
    if suffix == ".yaml":
        kinds += [yaml_changed] * 3
    if suffix in (".kml", ".osm"):
        kinds += [xml_changed] * 5
    for _ in range(rng.choice([1, 1, 1, 2, 4])):
        data = rng.choice(kinds)(data, rng)
    return data


def truncated(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def flipped(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(min(len(data), rng.choice([1, 1, 4, 30]))):
        changed[rng.randrange(min(len(data), rng.choice([200, 10**9])))] = rng.choice([0, 255, 127, rng.randrange(256)])
    return bytes(changed)


def copied(data: bytes, rng: random.Random) -> bytes:
    start, to = rng.randrange(len(data) + 1), rng.randrange(len(data) + 1)
    piece = data[start : start + rng.choice([1, 4, 40, 1000])]
    return data[:to] + piece * rng.choice([1, 1, 2, 1000]) + data[to + rng.choice([0, 0, len(piece)]) :]


def renumbered(data: bytes, rng: random.Random) -> bytes:
    found = list(re.finditer(rb"-?\d+(\.\d+)?(e[-+]?\d+)?", data))
    if not found:
        return flipped(data, rng)
    for one in sorted(rng.sample(found, min(len(found), rng.choice([1, 1, 3]))), key=lambda m: -m.start()):
        data = data[: one.start()] + rng.choice(NUMBERS).encode() + data[one.end() :]
    return data


def changed_tree(tree: Any, rng: random.Random) -> Any:
    """Return data with one value replaced, left out, doubled, wrapped or renamed."""
    places: list[tuple[Any, Any]] = []
    todo = [tree]
    while todo:
        node = todo.pop()
        pairs = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
        for key, value in pairs:
            places.append((node, key))
            todo.append(value)
    if not places:
        return rng.choice(VALUES)
    node, key = rng.choice(places)
    how = rng.randrange(5)
    if how == 0:
        del node[key]
    elif how == 1 and isinstance(node, dict):
        node[rng.choice(["type", "x", str(key) + "s", "shape"])] = node[key]
    elif how == 1:
        node.insert(key, node[key])
    elif how == 2:
        node[key] = [node[key]]
    elif how == 3 and len(places) > 1:
        other = rng.choice(places)
        node[key] = json.loads(json.dumps(other[0][other[1]], default=str)) if other[1] in _keys(other[0]) else None
    else:
        node[key] = rng.choice(VALUES)
    return tree


def _keys(node: Any) -> Any:
    return node if isinstance(node, dict) else range(len(node))


def json_changed(data: bytes, rng: random.Random) -> bytes:
    try:
        return json.dumps(changed_tree(json.loads(data), rng)).encode("utf-8", "surrogatepass")
    except (ValueError, RecursionError):
        return flipped(data, rng)


def yaml_changed(data: bytes, rng: random.Random) -> bytes:
    from skyverse.documents.yaml import load_yaml, yaml_text

    try:
        return yaml_text(changed_tree(load_yaml(data.decode()), rng)).encode()
    except Exception:  # it was damaged before
        return flipped(data, rng)


def xml_changed(data: bytes, rng: random.Random) -> bytes:
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, LookupError, ValueError):
        return flipped(data, rng)
    node = rng.choice(list(root.iter()))
    how = rng.randrange(5)
    if how == 0 and len(node):
        node.remove(rng.choice(list(node)))
    elif how == 1 and len(node):
        node.append(copy.deepcopy(rng.choice(list(root.iter()))))  # not itself, which would never end
    elif how == 2 and node.attrib:
        node.attrib[rng.choice(list(node.attrib))] = rng.choice([*NUMBERS, "", "x"])
    elif how == 3:
        node.tag = rng.choice(list(root.iter())).tag
    else:
        node.text = rng.choice([*NUMBERS, "", "1,2", "8,47 8,47 8,47", "x" * 1000])
    try:
        return ET.tostring(root)
    except (RecursionError, ValueError, TypeError):
        return flipped(data, rng)


def main() -> int:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("minutes", type=float, nargs="?", default=3.0)
    asked.add_argument("formats", nargs="*", help="such as .bt; all of them")
    asked.add_argument("--seed", type=int, default=0)
    asked.add_argument("--keep", type=Path, default=Path("fuzz-failures"))
    given = asked.parse_args()
    rng = random.Random(given.seed)
    reader, counts, failures = Reader(), Counter[tuple[str, str]](), 0
    kept: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        seeds, trial = Path(folder) / "seeds", Path(folder) / "trial"
        seeds.mkdir()
        trial.mkdir()
        files = write_seeds(seeds)
        chosen = [name for name in files if not given.formats or Path(name).suffix in given.formats]
        for name in chosen:  # as they are
            how, said = attempt(reader, files[name], files[name][0].read_bytes(), trial)
            if how != "read":
                print(f"the seed {name} is not read: {said}")
        until = time.monotonic() + 60 * given.minutes
        while time.monotonic() < until:
            name = rng.choice(chosen)
            data = damaged(files[name][0].read_bytes(), Path(name).suffix, rng)
            how, said = attempt(reader, files[name], data, trial)
            counts[name, how] += 1
            if how not in ("read", "refused"):
                failures += 1
                last = (said.strip().splitlines() or [""])[-1][:160]
                at = (re.findall(r'File ".*?(\w+/\w+\.py)", line (\d+)', said) or [("", "")])[-1]
                kept[name, at[0] + at[1]] += 1
                if kept[name, at[0] + at[1]] == 1:
                    given.keep.mkdir(exist_ok=True)
                    target = given.keep / f"{failures:04d}-{name}"
                    target.write_bytes(data)
                    target.with_name(target.name + ".said").write_text(f"{how}\n{said}\n")
                    print(f"{target}: {how}: {last}", flush=True)
    outcomes = sorted({how for _, how in counts})
    print(f"{'':24}" + "".join(f"{how:>14}" for how in outcomes))
    for name in chosen:
        print(f"{name:24}" + "".join(f"{counts[name, how]:14}" for how in outcomes))
    print(f"{counts.total()} files, {failures} failures")
    return 1 if failures else 0


def attempt(reader: Reader, files: list[Path], data: bytes, trial: Path) -> tuple[str, str]:
    """Read data in place of the first file, the others beside it."""
    for old in trial.iterdir():
        old.unlink()
    for other in files[1:]:
        shutil.copy(other, trial / other.name)
    path = trial / files[0].name
    path.write_bytes(data)
    return reader.read(trial / "grids.json" if path.suffix == ".npz" else path)


if __name__ == "__main__":
    sys.exit(main())
