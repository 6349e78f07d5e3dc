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
BESIDE = {"plan": "params", "waypoints": "param"}
RULES = {"slow ramps": {"acceleration": 1.5}, "steep ramps": {"acceleration": 5.0}}
"""How a replay flies: m/s2 of its ramps. ArduPilot turns somewhere within its radius: at once, or at the waypoint."""


def triggers(runs: int = 110, first: int = 0) -> None:
    """Plan random surveys of all kinds, replay each exported file, and print how photos differ from planned ones."""
    off, counts, photos = (defaultdict(list) for _ in range(3))
    refused, begun = Counter(), time.perf_counter()
    for seed in range(first, first + runs):
        kind = KINDS[seed % len(KINDS)]
        mission = planned_survey(kind, seed)
        for suffix in FORMATS:
            options = sky.ExportOptions(altitude="home" if suffix == "litchi.csv" else "amsl", allow_close=True)
            with tempfile.TemporaryDirectory() as folder:
                try:
                    files = sky.export(mission, Path(folder) / f"m.{suffix}", options)
                except sky.InputError as error:
                    refused[suffix, kind, str(error).split("; ")[0][-120:]] += 1
                    continue
                for how, rule in RULES.items():
                    for worst, differ, many in _flown(mission, files, suffix, rule):
                        off[suffix, how].append((worst, seed))
                        if worst > 1.0 or np.abs(differ).max() > 1:
                            print(suffix, how, kind, seed, round(worst, 2), differ)
                        counts[suffix, how] += differ
                        photos[suffix, how].append(many)
        if seed % 10 == 9:
            print(f"  {seed + 1 - first} of {runs}", file=sys.stderr, flush=True)
    print(f"{runs} surveys in {time.perf_counter() - begun:.0f} s")
    for at, found in off.items():
        many, worst = np.abs(counts[at]), max(found)
        print(
            f"{at[0]:11} {at[1]:12} {sum(photos[at]):6} photos on {len(many):5} strips: at most {worst[0]:.2f} m off "
            f"(seed {worst[1]}), 95 % of flights {np.quantile([one for one, _ in found], 0.95):.2f} m; "
            f"counts as planned on {np.mean(many == 0):.2%}, at most {many.max()} off"
        )
    for (suffix, kind, why), many in refused.items():
        print(f"{suffix}: {many} of {kind} refused: {why}")


def _flown(mission, files, suffix, rule):
    """Yield of each flight: metres of its worst planned photo, differences of counts on strips, and its photos."""
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
        yield float(off), differ, len(places)


def _stem(file, suffix):
    return file.name.removesuffix(f".{suffix}").split("-part-")[0]
