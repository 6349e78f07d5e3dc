"""The picture of docs/showcase.md: how the best price falls, and the best paths from above."""

from pathlib import Path

import numpy as np

import skyverse as sky
from skyverse.draw import INK, logarithmic
from skyverse.lab import band, grid
from skyverse.lab.figures import PLANNER_COLOURS, image, style

MOST = 7500
"""The price at which the axis ends."""
COLOURS = (*PLANNER_COLOURS, "#6a3d9a")
THREAT = "#c8323c"


def draw(study: sky.Study, rows: sky.Rows, file: Path) -> None:
    """Write it as a PNG; the best run of each planner is made once more, since rows hold no paths."""
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(11.5, 5.9), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
        fall(left, rows)
        paths(right, study, rows)
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=5, handlelength=2.6)
        file.write_bytes(image(figure, "png"))


def fall(axes, rows: sky.Rows) -> None:
    """Draw the best price so far against evaluations."""
    found = rows.select(("evaluations", "bound", "seed"))
    at, bound = grid(np.median(found["evaluations"])), found["bound"].max()
    for label, colour in zip(rows.labels("planner"), COLOURS, strict=True):
        quartiles = band(rows.histories(planner=label), at)[1:]
        low, median, high = (np.where(np.isfinite(costs), costs, np.nan) for costs in quartiles)
        if np.isfinite(median).any():
            axes.fill_between(at, low, high, step="post", color=colour, alpha=0.16, linewidth=0)
            axes.step(at, median, where="post", label=label, linewidth=1.8, color=colour)
        else:  # it ends by itself
            cost = np.median(rows.select(("cost",), planner=label)["cost"])
            axes.axhline(cost, label=label, linewidth=1.8, color=colour)
    axes.axhline(bound, color=INK, linestyle=(0, (4, 3)), linewidth=1.2, label="no path is cheaper (proven)")
    logarithmic(axes, "x", (1.0,))
    axes.set(xlim=(100, at[-1]), ylim=(bound - 100, MOST), xlabel="evaluations", ylabel="price of the best path so far")
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.set_title(f"Median and quartiles of {len(np.unique(found['seed']))} runs")


def paths(axes, study: sky.Study, rows: sky.Rows) -> None:
    """Draw the cheapest path of each planner from above, over the ground and the threats."""
    jobs = {(job.label, job.seed): job for job in study.jobs()}
    problem = sky.Problem(next(iter(jobs.values())).case.scenario)
    heights = problem.scenario.terrain.heights
    extent = (1, heights.shape[0], 1, heights.shape[1])
    axes.imshow(heights.T, origin="lower", extent=extent, cmap="Greys", alpha=0.5, vmin=0)
    for threat in problem.scenario.obstacles:
        axes.add_patch(_circle(threat.centre, threat.radius))
    for label, colour in zip(rows.labels("planner"), COLOURS, strict=True):
        found = rows.select(("seed", "cost"), planner=label)
        best = jobs[label, int(found["seed"][found["cost"].argmin()])]
        path = best.planner.plan(problem, stop=best.stop, rng=best.seed).path
        axes.plot(*path[:, :2].T, linewidth=1.6, marker="o", markersize=2.6, color=colour)
    for place, word, where in ((problem.start, "start", (-36, -4)), (problem.end, "target", (9, -3))):
        axes.plot(*place[:2], "o", markersize=7, markerfacecolor="white", markeredgecolor=INK, zorder=5)
        axes.annotate(word, place[:2], where, textcoords="offset points", color=INK)
    axes.set(xlim=(100, 900), ylim=(0, heights.shape[1]), xlabel="x, metres", ylabel="y, metres", aspect="equal")
    axes.grid(visible=False)
    axes.set_title("The cheapest path of each, from above; threats in red")


def _circle(centre: tuple[float, float], radius: float):
    from matplotlib.patches import Circle

    return Circle(centre, radius, facecolor=THREAT + "33", edgecolor=THREAT, linewidth=1.2)
