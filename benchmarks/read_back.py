"""Whether what skyverse exports gets the same verdict when it is read back and judged as anybody's mission.

``python benchmarks/read_back.py 500`` plans random fleets of two to five UAVs, every second one among boxes and every
third of aeroplanes where its autopilot flies any, exports them for PX4, ArduPilot and DJI in turn, with every end and
both references of altitudes, reads the files, and judges them in the scenario, with the height of PX4's turns that the
parameter files set. The same are: no leg, corner, climb or end is wrong, the time without a way home, and how each pair
of UAVs is kept apart. Each difference is printed with the seed; the exit code is then 1. Fleets whose straight legs
cannot be proven among the boxes are refused when they are exported; they do not count.
"""

import argparse
import re
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from machine import describe

import skyverse as sky
from skyverse.exports import ExportCertificate
from skyverse.model.quantities import derived
from skyverse.numerics.cores import cores

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "exports"))
from exported_fleets import random_fleet

WAYS = ((".plan", "px4"), (".waypoints", "ardupilot"), (".wpml.kmz", "dji"))
ENDS = ("loiter", "rtl", "land")
RETURN = 60.0
"""Metres above home."""
SECONDS = 1.0
"""By which times without a way home may differ."""
WING = sky.FixedWing(speed=10.0, turn_radius=32.0, climb=15.0)


def fleet_of(seed: int) -> sky.Mission:
    """Return a planned fleet: in the open, among boxes, or of aeroplanes, if all have a trajectory."""
    mission = random_fleet(seed)
    rng, scenario = np.random.default_rng([seed, 1]), mission.scenario
    places = np.array([*(uav.start for uav in scenario.uavs), *(target.position for target in scenario.targets)])
    boxes = []
    while seed % 2 and len(boxes) < 6:
        middle, size = rng.uniform(places.min(axis=0), places.max(axis=0) + 1), rng.uniform(3, 15, 2)
        if (np.abs(places - middle)[:, :2] > size + 12).any(axis=1).all():
            low, high = middle[:2] - size, middle[:2] + size
            boxes.append(sky.Box(min=(*low, scenario.bounds.min[2]), max=(*high, middle[2] + rng.uniform(-10, 15))))
    wing = {"fixed_wing": WING, "max_speed": 12.0} if seed // 2 % 3 == 0 and WAYS[seed % 3][1] != "dji" else {}
    uavs = tuple(derived(uav, **wing) for uav in scenario.uavs)
    scenario = derived(scenario, obstacles=tuple(boxes), uavs=uavs)
    made = sky.plan_mission(scenario, sky.Taut(), assignment="identity", rng=seed)
    return mission if any(one is None for one in made.trajectories) else made


def differences(seed: int) -> list[str] | None:
    """Return how the verdict on what is read back differs from that of the export; ``None`` if that is refused."""
    mission = fleet_of(seed)
    suffix, autopilot = WAYS[seed % 3]
    end, above = ENDS[seed // 3 % 3], ("amsl", "home")[seed // 9 % 2]
    seen: list[ExportCertificate] = []
    flies = any(uav.fixed_wing is not None for uav in mission.scenario.uavs)
    options = sky.ExportOptions(altitude=above, end=end, return_altitude=None if flies else RETURN, allow_close=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"m{suffix}"
        try:
            files = sky.export(mission, path, options, on_certificate=seen.append)
        except sky.InputError:  # no way home from the target, or none down to the ground
            try:
                files = sky.export(mission, path, replace(options, end="loiter"), on_certificate=seen.append)
            except sky.InputError:
                return None
        geoid = mission.scenario.frame.origin.geoid if suffix == ".wpml.kmz" and above == "amsl" else None
        told = {} if geoid is None else {"geoid": geoid}
        upright: list[float | None] = [None] * len(mission.scenario.uavs)
        if autopilot == "px4" and not flies:
            tables = [file.with_suffix(".params").read_text() for file in files]
            upright = [float(re.findall(r"NAV_MC_ALT_RAD\t([.\d]+)", table)[0]) for table in tables]
        read = [sky.read_waypoints(file, **told) for file in files if file.name.endswith(suffix)]
    fleets = {
        metres: sky.check_waypoints(
            read, mission.scenario, sky.FlightSettings(autopilot, None, None, options.radius, metres, RETURN)
        )
        for metres in upright
    }
    checked = [fleets[metres].missions[number] for number, metres in enumerate(upright)]
    fleet = fleets[max(fleets, key=lambda metres: metres or 0.0)]
    found = []
    for number, (one, back) in enumerate(zip(checked, seen[-1].returns, strict=True)):
        found += [
            f"UAV {number}: {each.subject.value} {each.items}: {each.what}"
            for each in one.findings
            if each.wrong and each.subject.value not in ("way home", "separation")
        ]
        lost = [0.0 if way is None else sum(gap.end - gap.begin for gap in way.gaps) for way in (back, one.back)]
        if abs(lost[0] - lost[1]) > SECONDS:
            found.append(f"UAV {number}: {lost[1]:.0f} s without a way home, when exported {lost[0]:.0f} s")
    for pair, kind in seen[-1].apart.pairs.items():
        if fleet.apart.pairs[pair] is not kind:
            found.append(f"UAVs {pair}: apart {fleet.apart.pairs[pair].value}, when exported {kind.value}")
    return found


def main() -> int:
    """Read the exports of all fleets back and print what differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("fleets", type=int, nargs="?", default=30)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--processes", type=int, default=cores(), help="processes side by side; all cores by default")
    options = parser.parse_args()
    print(describe(), flush=True)
    same, refused, seeds = 0, 0, range(options.first, options.first + options.fleets)
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for seed, found in zip(seeds, pool.map(differences, seeds), strict=True):
            same += found == []
            refused += found is None
            if seed % 25 == 24:
                print(f"  {seed + 1 - options.first} of {options.fleets} fleets", file=sys.stderr, flush=True)
            for line in (found or [])[:4]:
                print(f"seed {seed}, {WAYS[seed % 3][1]}, {ENDS[seed // 3 % 3]}: {line}", flush=True)
    exported = options.fleets - refused
    print(f"the same verdict: {same} of {exported}")
    return 0 if same == exported else 1


if __name__ == "__main__":
    raise SystemExit(main())
