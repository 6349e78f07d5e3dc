"""What ``compare`` prints of a study of replanning policies among movers."""

import itertools
from typing import Any

import numpy as np

from skyverse.lab.moving_row import MovingRows

_COLUMNS = ("arrived", "safe", "contacts", "least_gap", "time_ratio", "length_ratio", "replans", "unproven")
_EFFORT_COLUMNS = ("milliseconds", "milliseconds_99", "milliseconds_worst", "evaluations")


def policy_summary(rows: MovingRows) -> list[dict[str, Any]]:
    """Return a line for each policy on each scenario among each kind of movers."""
    lines = []
    for scenario, movers, policy in itertools.product(*(rows.labels(kind) for kind in rows.label_kinds)):
        group = {"scenario": scenario, "movers": movers, "policy": policy}
        found = rows.select(_COLUMNS + _EFFORT_COLUMNS, **group)
        flights = len(found["arrived"])
        if not flights:
            continue
        ratio, length = (np.median(found[name]) for name in ("time_ratio", "length_ratio"))
        measured = {
            "flights": flights,
            "arrived": int(found["arrived"].sum()),
            "safe": int(found["safe"].sum()),
            "contacts": int(found["contacts"].sum()),
            "least gap": float(found["least_gap"].min()),
            "time over bound": float(ratio) if np.isfinite(ratio) else None,
            "length over bound": float(length) if np.isfinite(length) else None,
            "replans": float(found["replans"].mean()),
            "unproven": int(found["unproven"].sum()),
            "milliseconds": float(np.median(found["milliseconds"])),
            "milliseconds 99 %": float(np.median(found["milliseconds_99"])),
            "milliseconds worst": float(found["milliseconds_worst"].max()),
        }
        lines.append(group | measured)
    return lines


def policy_lines(summary: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the lines of a summary as they are printed."""
    return [_line(line) for line in summary]


def _line(line: dict[str, Any]) -> dict[str, str]:
    flights, ratio, longer = line["flights"], line["time over bound"], line["length over bound"]
    return {
        "scenario": line["scenario"],
        "movers": line["movers"],
        "policy": line["policy"],
        "arrived": f"{line['arrived']}/{flights}",
        "safe": f"{line['safe']}/{flights}",
        "contacts": str(line["contacts"]),
        "time": "-" if ratio is None else f"{ratio:.2f}",
        "length": "-" if longer is None else f"{longer:.2f}",
        "replans": f"{line['replans']:.0f}",
        "ms": f"{line['milliseconds']:.1f}",
        "99 %": f"{line['milliseconds 99 %']:.1f}",
        "worst": f"{line['milliseconds worst']:.0f}",
    }
