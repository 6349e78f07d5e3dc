"""What ``compare`` prints of a study."""

import itertools
from typing import Any

import numpy as np

from skyverse.lab.rows import Rows

_COLUMNS = ("success", "cost", "gap", "generated_paths", "seconds")
_FLOWN_COLUMNS = ("contacts", "least_gap", "replans", "unproven", "milliseconds_99", "milliseconds_worst")


def study_summary(rows: Rows) -> list[dict[str, Any]]:
    """Return a line for each planner on each scenario under each budget; costs are those of all runs."""
    lines = []
    names = ("scenario", "budget", "planner")
    for labels in itertools.product(*(rows.labels(name) for name in names)):
        group = dict(zip(names, labels, strict=True))
        found = rows.select(_COLUMNS + _FLOWN_COLUMNS, **group)
        cost, gap, runs = found["cost"], found["gap"], len(found["cost"])
        if not runs:
            continue
        known, finite = gap[np.isfinite(gap)], bool(np.isfinite(cost).all())
        measured = {
            "runs": runs,
            "success": float(found["success"].mean()),
            "median": float(np.median(cost)) if finite else None,
            "mean": float(cost.mean()) if finite else None,
            "standard error": float(cost.std(ddof=1) / runs**0.5) if finite and runs > 1 else None,
            "gap": float(known.mean()) if len(known) else None,
            "generated paths": float(found["generated_paths"].mean()),
            "seconds": float(found["seconds"].mean()),
        }
        if np.isfinite(found["replans"]).all():
            measured |= {
                "contacts": int(found["contacts"].sum()),
                "least gap": float(found["least_gap"].min()),
                "replans": float(found["replans"].mean()),
                "unproven": int(found["unproven"].sum()),
                "milliseconds 99 %": float(np.median(found["milliseconds_99"])),
                "milliseconds worst": float(found["milliseconds_worst"].max()),
            }
        lines.append(group | measured)
    return lines


def summary_lines(summary: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the lines of a summary as they are printed."""
    return [_line(line) for line in summary]


def _line(line: dict[str, Any]) -> dict[str, str]:
    mean, error, gap = line["mean"], line["standard error"], line["gap"]
    printed = {
        "scenario": line["scenario"],
        "budget": line["budget"],
        "planner": line["planner"],
        "success": f"{round(line['success'] * line['runs'])}/{line['runs']}",
        "median": "-" if line["median"] is None else f"{line['median']:.1f}",
        "mean": "-" if mean is None else f"{mean:.1f}" if error is None else f"{mean:.1f} ± {error:.1f}",
        "gap": "-" if gap is None else f"{gap:.1%}",
        "paths": f"{line['generated paths']:.0f}",
        "seconds": f"{line['seconds']:.3g}",
    }
    if "contacts" in line:
        printed |= {"contacts": str(line["contacts"]), "replans": f"{line['replans']:.0f}"}
        printed |= {"ms, 99 %": f"{line['milliseconds 99 %']:.1f}", "worst": f"{line['milliseconds worst']:.0f}"}
    return printed
