"""Photos of planned surveys, taken by replays of their exported files, beside where they are planned."""

import sys
import tempfile
import time
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np

import skyverse as sky

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "support"))
from flown_surveys import POLL, Flight, compared, planned, steps_of
from planned_surveys import KINDS, home_of, planned_survey

FORMATS = ("plan", "waypoints", "wpml.kmz", "litchi.csv")
FEW = "oblique"
"""Has a thousand photos, which are slow to fly."""
OFTEN = [kind for kind in KINDS if kind != FEW]
BESIDE = {"plan": "params", "waypoints": "param"}
RULES = {"slow ramps": {"acceleration": 1.5}, "steep ramps": {"acceleration": 5.0}}
"""How a replay flies: m/s2 of its ramps. ArduPilot turns somewhere within its radius: at once, or at the waypoint."""


def triggers(runs: int = 110, first: int = 0) -> None:
    """Plan random surveys of all kinds, replay each exported file, and print how photos differ from planned ones."""
    off, counts, worst = defaultdict(list), defaultdict(list), defaultdict(lambda: (0.0, "", 0))
    refused, begun = Counter(), time.perf_counter()
    for seed in range(first, first + runs):
        kind = FEW if seed % 40 == 7 else OFTEN[seed % len(OFTEN)]
        mission = planned_survey(kind, seed)
        for suffix in FORMATS:
            options = sky.ExportOptions(altitude="home" if suffix == "litchi.csv" else "amsl", allow_close=True)
            with tempfile.TemporaryDirectory() as folder:
                try:
                    files = sky.export(mission, Path(folder) / f"m.{suffix}", options)
                except sky.InputError as error:
                    refused[suffix, kind, str(error).split("; ")[0][-120:]] += 1
                    continue
                for k, (how, rule) in enumerate(RULES.items()):
                    if k != seed // len(OFTEN) % 2 and suffix != "waypoints":
                        continue
                    for away, differ in _flown(mission, files, suffix, rule):
                        off[suffix, how] += away.tolist()
                        worst[suffix, how] = max(worst[suffix, how], (float(away.max()), kind, seed))
                        counts[suffix, how] += differ
        if seed % 10 == 9:
            print(f"  {seed + 1 - first} of {runs}", file=sys.stderr, flush=True)
    print(f"{runs} surveys in {time.perf_counter() - begun:.0f} s")
    for at, found in off.items():
        many, (far, kind, seed) = np.abs(counts[at]), worst[at]
        print(
            f"{at[0]:11} {at[1]:12} {len(found):6} photos: {np.mean(np.array(found) <= 1.0):.2%} within 1 m, at most "
            f"{far:.2f} m off ({kind} {seed}); {len(many):5} strips: {np.mean(many == 0):.2%} with as many photos as "
            f"planned, {np.mean(many <= 1):.2%} within 1, at most {many.max()} off"
        )
    for (suffix, kind, why), many in refused.items():
        print(f"{suffix}: {many} of {kind} refused: {why}")


def _flown(mission, files, suffix, rule):
    """Yield of each flight: metres that planned photos are off, and differences of counts on strips."""
    flights = defaultdict(list)
    for file in files:  # several where one takes too few waypoints
        flights[_stem(file, suffix)].append(file)
    homes = [home_of(mission, k) for k, sorties in enumerate(mission.sorties) for _ in sorties]
    for (stem, parts), home in zip(flights.items(), homes, strict=True):
        taken, at = [], home
        for file in parts:
            beside = file.with_name(f"{stem}.{BESIDE.get(suffix, 'none')}")
            steps, name = steps_of(file, beside.read_text() if beside.is_file() else "", home[2])
            late = float(name == "ardupilot" and rule["acceleration"] > 2.0)
            flight = Flight(steps, at, poll=POLL[name], late=late, **rule)
            taken.append(flight.run())
            at = flight.at
        places, _, strips = planned(parts[0].with_name(f"{stem}.{suffix}"))
        off, differ, _ = compared(np.concatenate(taken), places, strips)
        yield off, differ


def _stem(file, suffix):
    return file.name.removesuffix(f".{suffix}").split("-part-")[0]
