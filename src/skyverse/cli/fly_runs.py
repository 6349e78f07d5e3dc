"""What the verb ``fly`` prints of a mission that was flown many times."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skyverse.cli.report import json_text, say, table

if TYPE_CHECKING:
    from skyverse._typing import Floats
    from skyverse.model.flight_record import FlightRuns, TrackingErrors

MOST_TOUCHES = 5
"""How many of the runs that went wrong are printed."""


def report_runs(flown: "FlightRuns", written: list[Path], as_json: bool) -> None:
    """Print the tracking errors of each UAV, the least distances, the verdict, and where the files are."""
    from skyverse.model.short_lines import counted

    names = [uav.name for uav in flown.mission.scenario.uavs]
    rows = [(names[uav], errors) for uav, errors in enumerate(flown.errors) if errors is not None]
    if as_json:
        print(json_text(_data(flown, rows, written)), end="")
        return
    print(flown.vehicle_sentence)
    if len(rows) > 1:
        rows.append(("all", flown.all_errors))
    head = ["tracking error", "horizontal: median", "99 %", "largest", "vertical: median", "99 %", "largest"]
    cells = []
    for name, errors in rows:
        both = (errors.horizontal, errors.vertical)
        cells.append(
            [name, *(f"{metres:.3f} m" for part in both for metres in (part.median, part.percentile_99, part.largest))]
        )
    table(head, cells)
    say(*flown.checks, flown.tube_sentence)
    if flown.outside.max() > 0:
        print(f"A UAV was {flown.outside.max():.3f} m out of bounds at most.")
    size = f"the vehicle's propellers reach {flown.radius:.3g} m from its centre"
    weather = flown.conditions.told(flown.seed)
    say(f"{size}; {weather}; {counted(flown.runs, 'run')}", *flown.rounds)
    whose = f"{flown.vehicle} alone: " if flown.stands_in else ""
    say(*(f"{whose}{violation.message}" for violation in list(flown.violations.values())[:MOST_TOUCHES]))
    if len(flown.violations) > MOST_TOUCHES:
        print(f"and {counted(len(flown.violations) - MOST_TOUCHES, 'more run')}")
    say(flown.sentence, *written)


def _data(flown: "FlightRuns", rows: "list[tuple[str, TrackingErrors]]", written: list[Path]) -> dict[str, Any]:
    """Return what is printed as JSON; what is infinite, as where there is nothing to come near to, is null."""

    def errors_of(errors: "TrackingErrors") -> dict[str, Any]:
        parts = {"horizontal": errors.horizontal, "vertical": errors.vertical}
        return {
            name: {"median": part.median, "percentile_99": part.percentile_99, "largest": part.largest}
            for name, part in parts.items()
        }

    def least(values: "Floats") -> float | None:
        return float(values.min()) if math.isfinite(values.min()) else None

    held = flown.held
    return {
        "safe": None if flown.stands_in else flown.safe,
        "verdict": flown.sentence,
        "simulated": flown.vehicle_sentence,
        "runs": flown.runs,
        **{name: getattr(flown, name) for name in ("radius", "seed", "rounds", "refusal")},
        **vars(flown.conditions),
        "makespan": flown.mission.makespan,
        "all": errors_of(flown.all_errors),
        "uavs": [{"uav": name} | errors_of(errors) for name, errors in rows],
        "clearance": least(flown.clearance),
        "separation": least(flown.separation),
        "nearness": least(flown.nearness),
        "outside": float(flown.outside.max()),
        "runs_within_tracking_error": None if held is None else held.count(True),
        "touches": [
            {"run": run, "seed": int(flown.seeds[run]), "time": one.time, "sentence": one.message}
            for run, one in flown.violations.items()
        ],
        "checks": flown.checks,
        "files": [str(path) for path in written],
    }
