"""The charts of the reproduction: lines over iterations or populations, and groups of bars."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skyverse.draw import INK, blank, logarithmic
from skyverse.draw.map_figure import SOFT
from skyverse.lab.figures import FIGURE_WIDTH, PLANNER_COLOURS
from skyverse.mission.assignment import Assignment
from skyverse.reproduction.cells import FORMS, CellRuns, Size, grid
from skyverse.reproduction.published import METHODS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METHOD_COLOURS = dict(zip(("MVO", "GSO", "BBO", "random restart"), PLANNER_COLOURS, strict=False))
FORM_DASHES: dict[str, Any] = {"thesis": ":", "as run": "-", "as described": "--", "": "-"}
FORM_MARKERS = {"thesis": "x", "as run": "o", "as described": "s", "": "D"}


@dataclass(frozen=True)
class ChartSeries:
    """Points of a method in one form (``"thesis"``, ``"as run"``, ``"as described"``, ``""``), with standard errors."""

    method: str
    form: str
    x: Sequence[float]
    y: Sequence[float]
    error: Sequence[float] | None = None


def method_series(
    cells: CellRuns,
    scenarios: Sequence[str],
    sizes: Sequence[Size],
    x: Sequence[float] = (),
    *,
    column: str = "cost",
    thesis: Mapping[str, tuple[Sequence[float], Sequence[float] | None]] = {},
    assignment: Assignment = "path-cost",
) -> list[ChartSeries]:
    """Return each method's series: the thesis's where given, and mean costs or medians of a column in each form."""
    found = []
    for method in METHODS:
        if method in thesis:
            found.append(ChartSeries(method, "thesis", x, *thesis[method]))
        for form in FORMS:
            some = grid(scenarios, sizes, [method], [form], assignment=assignment)
            values = cells.means(some) if column == "cost" else (cells.medians(column, some), None)
            found.append(ChartSeries(method, form, x, *values))
    return found


def lines(series: Sequence[ChartSeries], x: str, y: str, *, bound: float | None = None, log: bool = False) -> "Figure":
    """Draw a line for each series, in the colour of its method and with the dash of its form."""
    from matplotlib.ticker import MaxNLocator

    figure, axes = _chart(4.6)
    for one in series:
        colour, name = METHOD_COLOURS[one.method], f"{one.method} {one.form}".strip()
        style: Any = {"color": colour, "linestyle": FORM_DASHES[one.form], "linewidth": 1.6, "label": name}
        axes.plot(one.x, one.y, marker=FORM_MARKERS[one.form], markersize=4.5, **style)
        if one.error is not None:
            low, high = np.subtract(one.y, one.error), np.add(one.y, one.error)
            axes.fill_between(one.x, low, high, color=colour, alpha=0.13, linewidth=0)
    if bound is not None:
        axes.axhline(bound, color=SOFT, linestyle=(0, (4, 3)), linewidth=1.1, label="exact optimum")
    if log:
        logarithmic(axes, "y", (1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
    else:
        _counted(axes)
    axes.xaxis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10], integer=True))
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    figure.legend(loc="lower center", ncols=4, handlelength=3)
    return figure


def bars(groups: Sequence[str], series: Sequence[ChartSeries], y: str, *, bounds: Sequence[float] = ()) -> "Figure":
    """Draw a group of bars for each name: the thesis's hollow, ours filled, those as described hatched."""
    figure, axes = _chart(4.4)
    width = 0.84 / len(series)
    for k, one in enumerate(series):
        colour, at = METHOD_COLOURS[one.method], np.arange(len(groups)) - 0.42 + (k + 0.5) * width
        style: Any = {"edgecolor": colour, "linewidth": 1.1, "label": f"{one.method} {one.form}".strip()}
        style |= {"facecolor": "white"} if one.form == "thesis" else {"facecolor": colour}
        if one.form == "as described":
            style |= {"facecolor": colour + "55", "hatch": "////"}
        axes.bar(at, one.y, 0.92 * width, yerr=one.error, error_kw={"ecolor": INK, "elinewidth": 0.9}, **style)
    if bounds:
        middle = np.arange(float(len(groups)))
        dash: Any = {"color": SOFT, "linestyle": (0, (4, 3)), "linewidth": 1.3}
        axes.hlines(bounds, middle - 0.45, middle + 0.45, label="exact optimum", **dash)
    axes.set_xticks(range(len(groups)), groups)
    axes.grid(visible=False, axis="x")
    _counted(axes)
    axes.set_ylabel(y)
    figure.legend(loc="lower center", ncols=4)
    return figure


def _counted(axes: Any) -> None:
    from matplotlib.ticker import FuncFormatter

    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.6g}"))
    axes.set_ylim(bottom=0)


def _chart(height: float) -> tuple["Figure", Any]:
    """Return a figure and its axes, placed by hand (faster than a layout engine) above a legend of three rows."""
    figure = blank(FIGURE_WIDTH, height)
    return figure, figure.add_axes((0.125, 1.2 / height, 0.855, 1 - 1.35 / height))
