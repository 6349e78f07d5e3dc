"""The figure of length against time, with a panel for each problem."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import contenders
import numpy as np
from course import Course, median
from problems import Case
from report import reference

LEAST = 0.01
"""Per cent above the reference at which the axis ends; smaller differences are drawn at this value."""

STYLES = {"ours": "-", "sampling": "-", "optimiser": "--", "grid": ":"}
COLOURS = {
    "Taut": "#c1121f",
    "Theta*": "#e36414",
    "HybridMVO": "#222222",
    "A*, 26-connected": "#e0a100",
    "A*, 6-connected": "#b08968",
    "OMPL BIT*": "#003f88",
    "OMPL Informed RRT*": "#3a86c8",
    "OMPL AORRTC": "#00a6a6",
    "CMA-ES (cma)": "#386641",
    "DE (pymoo)": "#7cb518",
    "pathfinding3d A*": "#5a189a",
    "pathfinding3d Theta*": "#b5179e",
}


def draw(
    cases: Sequence[Case], found: Mapping[tuple[str, str], Sequence[Course]], seconds: float, folder: Path
) -> None:
    """Write peers.png and peers.svg."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = min(3, len(cases) + 1)
    rows = math.ceil((len(cases) + 1) / columns)
    figure = Figure(figsize=(4.6 * columns, 3.7 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(rows, columns, squeeze=False).flat)
    names = [name for name in contenders.ALL if any(key[0] == name for key in found)]
    for panel, case in zip(panels, cases, strict=False):
        of_case = {name: found[name, case.name] for name in names if (name, case.name) in found}
        best = reference(case, list(of_case.values()))
        for name, courses in of_case.items():
            _line(panel, name, courses, best, seconds)
        source = "shortest known" if case.known is not None else "best found here"
        panel.set_title(f"{case.name}  ({source}: {best:.2f} m)", fontsize=10, loc="left")
        panel.set(xscale="log", yscale="log", xlim=(1e-4, 1.3 * seconds), ylim=(0.7 * LEAST, 150))
        panel.set_yticks([0.01, 0.1, 1, 10, 100], ["≤0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
        panel.set_xticks([t for t in (1e-3, 1e-2, 1e-1, 1, 10) if t <= seconds])
        panel.set_xticklabels([f"{t * 1e3:g} ms" if t < 1 else f"{t:g} s" for t in panel.get_xticks()])
        panel.grid(True, color="#dddddd", linewidth=0.6)
        panel.minorticks_off()
        panel.spines[["top", "right"]].set_visible(False)
    for row in range(rows):
        panels[row * columns].set_ylabel("longer than the reference by")
    for panel in panels[len(cases) :]:
        panel.axis("off")
    lines = {line.get_label(): line for panel in panels for line in panel.get_lines() if line.get_label() in COLOURS}
    wanted = [name for name in names if name in lines]
    panels[len(cases)].legend([lines[n] for n in wanted], wanted, loc="upper left", frameon=False, fontsize=10)
    panels[len(cases)].text(
        0.02,
        0.02,
        "Medians over the seeds.\nA dot: the planner ends by itself.",
        fontsize=9,
        transform=panels[len(cases)].transAxes,
    )
    figure.supxlabel("processor time of the search", fontsize=10)
    for kind in ("png", "svg"):
        figure.savefig(folder / f"peers.{kind}", dpi=150)


def _line(panel: object, name: str, courses: Sequence[Course], best: float, seconds: float) -> None:
    kind = contenders.ALL[name].kind
    known = [course for course in courses if course.steps]
    if not known:
        return
    times = np.unique([step.seconds for course in known for step in course.steps])
    metres = np.array([median(courses, lambda c, t=t: c.metres(t)) for t in times])
    seen = np.isfinite(metres)
    if not seen.any():
        return
    above = np.maximum(100 * (metres[seen] / best - 1), LEAST)
    at = np.maximum(times[seen], 1.2e-4)
    style = {"color": COLOURS[name], "linestyle": STYLES[kind], "label": name}
    if len(at) == 1:  # it ends by itself
        panel.plot(at, above, marker="o", markersize=6, **style | {"linestyle": "none"})
        panel.hlines(above[0], at[0], max(seconds, at[0]), color=COLOURS[name], linewidth=0.8, linestyle=":")
    else:
        at, above = np.append(at, max(seconds, at[-1])), np.append(above, above[-1])
        panel.step(at, above, where="post", linewidth=1.8, **style)
