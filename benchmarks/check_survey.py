"""How long the check and the repair of a large survey take: 567 items over ground of a million heights.

``python benchmarks/check_survey.py`` writes a survey that follows hilly ground at 60 m, and one of the same places at a
level height that flies into a hill, and prints how long ``skyverse check`` and ``skyverse repair`` take for each, as a
user starts them: with the start of Python, whose bytecode is kept, the median of some runs after one that is not
counted. The seconds of the processor are less than those on the clock where others use the machine, too.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

import numpy as np
import rasterio
from machine import describe, median, table

from skyverse.model.frame import Origin
from skyverse.model.geodesy import to_wgs84

NODES, CELL = 1000, 2.0
"""Heights along each side, and metres between them."""
STRIPS, PLACES = 27, 21
HIGH = 60.0
"""Metres above ground."""
SURVEYS = {"follows the ground": False, "flies into a hill": True}
"""Which is level."""
ORIGIN = Origin(latitude=46.8, longitude=9.8, altitude=0.0)


def hills() -> np.ndarray:
    """Return metres above the sea, (NODES, NODES), along x and y."""
    x, y = np.meshgrid(*[np.arange(NODES) * CELL] * 2, indexing="ij")
    long = 40 * np.sin(x / 310) * np.cos(y / 270) + 30 * np.exp(-(((x - 700) / 150) ** 2) - ((y - 1100) / 260) ** 2)
    return 800 + long + 4 * np.sin(x / 41 + y / 57)


def write_ground(path: Path, heights: np.ndarray) -> None:
    """Write the ground on an azimuthal map."""
    local = f"+proj=aeqd +lat_0={ORIGIN.latitude} +lon_0={ORIGIN.longitude} +datum=WGS84"
    transform = rasterio.Affine(CELL, 0, -CELL / 2, 0, -CELL, (NODES - 0.5) * CELL)
    profile = {"driver": "GTiff", "height": NODES, "width": NODES, "count": 1, "dtype": "float32", "crs": local}
    with rasterio.open(path, "w", transform=transform, **profile) as file:
        file.write(heights.T[::-1].astype("float32"), 1)
        file.units = ("metre",)


def write_survey(path: Path, heights: np.ndarray, *, level: bool) -> None:
    """Write the survey, its altitudes above the sea."""
    along = np.linspace(60, (NODES - 1) * CELL - 60, PLACES)
    across = np.linspace(60, (NODES - 1) * CELL - 60, STRIPS)
    places = [(x, y) for k, y in enumerate(across) for x in (along if k % 2 else along[::-1])]
    ground = [float(heights[round(x / CELL), round(y / CELL)]) for x, y in places]
    high = [min(ground) + HIGH if level else z + HIGH for z in ground]
    globe = to_wgs84(ORIGIN, [[x, y, z] for (x, y), z in zip(places, high, strict=True)]).tolist()
    first = globe[0]
    rows = [(22, 3, [0, 0, 0, None, *first[:2], 60.0]), *((16, 0, [0, 0, 0, None, *one]) for one in globe)]
    rows.append((20, 2, [0.0] * 7))
    items = [
        {"type": "SimpleItem", "autoContinue": True, "command": c, "frame": f, "params": p, "doJumpId": k}
        for k, (c, f, p) in enumerate(rows, 1)
    ]
    mission = {"version": 2, "firmwareType": 12, "vehicleType": 2, "cruiseSpeed": 15, "hoverSpeed": 8, "items": items,
               "plannedHomePosition": [*first[:2], ground[0]]}  # fmt: skip
    fence = {"version": 2, "circles": [], "polygons": []}
    plan = {"fileType": "Plan", "version": 1, "groundStation": "QGroundControl", "mission": mission,
            "geoFence": fence, "rallyPoints": {"version": 2, "points": []}}  # fmt: skip
    path.write_text(json.dumps(plan))


def main() -> int:
    """Time the checks and repairs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    print(describe(), flush=True)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        heights, ground = hills(), Path(folder) / "dem.tif"
        write_ground(ground, heights)
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        environment["PYTHONPYCACHEPREFIX"] = folder  # bytecode is kept, as where skyverse is installed
        for verb, (name, level) in product(("check", "repair"), SURVEYS.items()):
            path, mended = Path(folder) / "survey.plan", Path(folder) / "mended.plan"
            write_survey(path, heights, level=level)
            words = [verb, str(path), *(["-o", str(mended)] if verb == "repair" else []), "--terrain", str(ground)]
            words += ["--vehicle", "camera", "--return-altitude", "100", "--max-height", "200 m agl", "--json"]
            command = [sys.executable, "-m", "skyverse", *words]

            def run(command: list[str] = command) -> None:
                subprocess.run(command, capture_output=True, check=False, env=environment)

            seconds, told = median(run, options.runs), subprocess.run(command, capture_output=True, env=environment)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            run()
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            verdict = ("proven", "faults", "refused")[told.returncode]
            rows.append([verb, name, verdict, f"{seconds:.2f}", f"{spent:.2f}"])
    table(("verb", "survey", "verdict", "seconds", "of the processor"), rows)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
