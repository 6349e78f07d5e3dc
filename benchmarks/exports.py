"""Replays exported fleets: whether autopilots that climb and fly faster or slower keep what the export promises.

``python benchmarks/exports.py --fleets 300`` plans random fleets of two to five UAVs in the open, with and without
``apart_in_space``, exports them, reads the files back and replays each four times at climbs of 1 to 5 m/s and speeds
10 % off. It prints how many pairs of UAVs are apart in which way, and how many broke the promise.
"""

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

import skyverse as sky
from skyverse.exports.separation import Apart
from skyverse.exports.waypoint_files import ExportCertificate

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "exports"))
from exported_fleets import broken_promises, random_fleet, read_orders

SUFFIXES = ("plan", "waypoints", "wpml.kmz")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--fleets", type=int, default=30, help="fleets of each kind; 30 by default")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    options = parser.parse_args()
    broken = 0
    for apart_in_space in (False, True):
        kinds: Counter[str] = Counter()
        whole = 0
        for seed in range(options.first, options.first + options.fleets):
            mission = random_fleet(seed, apart_in_space=apart_in_space)
            seen: list[ExportCertificate] = []
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / f"m.{SUFFIXES[seed % 3]}"
                asked = {"apart_in_space": True} if apart_in_space else {"allow_close": True}
                try:
                    files = sky.export(mission, path, **asked, on_certificate=seen.append)
                except sky.InputError:
                    files = sky.export(mission, path, allow_close=True, on_certificate=seen.append)
                orders = read_orders(mission.scenario, files)
            pairs = seen[-1].apart.pairs
            kinds.update(kind.value for kind in pairs.values())
            whole += set(pairs.values()) == {Apart.SPACE}
            for found in broken_promises(mission, orders, pairs, np.random.default_rng(seed)):
                broken += 1
                print(f"seed {seed}: {found}", file=sys.stderr)
        print(f"{options.fleets} fleets, {'planned apart in space' if apart_in_space else 'planned as usual'}:")
        for kind in Apart:
            print(f"  pairs {kind.value}: {kinds[kind.value]}")
        print(f"  fleets with all paths apart in space: {whole}", flush=True)
    print(f"broken promises: {broken}")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
