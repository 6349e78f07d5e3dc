"""Figures of a study, drawn from plain data: one palette, one type size, the same bytes from the same data."""

import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from skyverse._typing import Floats
from skyverse.draw import INK, TRACKS, blank, logarithmic
from skyverse.draw.map_figure import GRID, LINE_STYLES, SOFT, plain
from skyverse.lab.curves import Band
from skyverse.lab.report import one_line
from skyverse.lab.statistics import Ranking, quantile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

T = TypeVar("T")
FIGURE_WIDTH = 8.0
"""Inches of every figure."""
PLANNER_COLOURS = (*TRACKS, "#000000")
"""Okabe and Ito's colours without yellow, which is hard to see on white; planners from the eighth on are dashed."""

_STYLE: Any = {
    "axes.axisbelow": True,
    "axes.edgecolor": SOFT,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.5,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10.5,
    "figure.constrained_layout.h_pad": 0.08,
    "font.size": 9.5,
    "grid.color": GRID,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "legend.fontsize": 9.5,
    "svg.hashsalt": "skyverse",
    "text.color": INK,
    "xtick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.color": SOFT,
    "ytick.labelcolor": INK,
}
_BOUND: Any = {"color": SOFT, "linestyle": (0, (4, 3)), "linewidth": 1.1}
_UNDATED: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None}}


@contextmanager
def style() -> Iterator[None]:
    """Use the laboratory's style for figures within this context, whatever the user's matplotlibrc says."""
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", message="Glyph .* missing"
        )  # for labels in a script that no installed font has
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


def image(figure: "Figure", suffix: str) -> bytes:
    """Return `figure` as the bytes of an ``"svg"``, ``"png"`` or ``"pdf"`` file without a date."""
    file = BytesIO()
    figure.savefig(file, format=suffix, dpi=160, facecolor="white", metadata=_UNDATED[suffix])
    return file.getvalue()


Panel = tuple[str, float | None, Sequence[T]]
"""One scenario's part of a figure: title, lower bound where known, and what is drawn of each planner."""


def convergence(labels: Sequence[str], panels: Sequence[Panel[Band]]) -> "Figure":
    """Draw median and quartiles of the best cost so far against evaluations, one panel for each scenario.

    The cost axis covers the costs after the first quarter of the evaluations; higher costs are cut off.
    """
    columns = min(2, len(panels))
    height = (2.9 if columns > 1 else 3.8) * math.ceil(len(panels) / columns) + _legend_height(labels)
    figure, grid = _panels(len(panels), columns, height=height)
    for axes, (title, bound, bands) in zip(grid, panels, strict=True):
        late: list[float] = []
        for index, (at, *quartiles) in enumerate(bands):
            low, median, high = (np.where(np.isfinite(costs), costs, np.nan) for costs in quartiles)
            axes.fill_between(at, low, high, step="post", color=_colour(index), alpha=0.14, linewidth=0)
            _step(axes, index, at, median)
            shown = np.concatenate([low, high])[np.tile(at >= 0.25 * at[-1], 2)]
            late += shown[np.isfinite(shown)].tolist()
        if bound is not None:
            axes.axhline(bound, **_BOUND)
            late.append(bound)
        if late:
            margin = 0.04 * (max(late) - min(late)) or 0.01 * abs(max(late)) or 1.0
            axes.set_ylim(min(late) - margin, max(late) + margin)
        logarithmic(axes, "x", (1.0,))
        axes.set_xlim(left=1)
        axes.set_title(plain(_short(title)))
        axes.set_xlabel("evaluations")
        axes.set_ylabel("best cost so far")
    _legend(figure, labels, bound=any(bound is not None for _, bound, _ in panels))
    return figure


def boxes(
    labels: Sequence[str], panels: Sequence[Panel[Floats]], quantity: str = "cost", lost: str = "without any path"
) -> "Figure":
    """Draw box plots of the costs, or of another quantity, with dots beyond the whiskers and the mean as a diamond.

    A box goes from the first to the third quartile, its whiskers to the last cost within 1.5 box lengths. Five costs or
    fewer are drawn as dots. Costs far beyond all whiskers, and infinite ones, are stated in words.
    """
    columns = min(2, len(panels))
    height = (0.26 * len(labels) + 1.1) * math.ceil(len(panels) / columns)
    figure, grid = _panels(len(panels), columns, height=height, sharey=True)
    for axes, (title, bound, everyone) in zip(grid, panels, strict=True):
        ends = [_whiskers(costs) for costs in everyone if np.isfinite(costs).any()]
        ends += [] if bound is None else [(bound, bound)]
        low, high = min((low for low, _ in ends), default=0.0), max((high for _, high in ends), default=1.0)
        margin = 0.05 * (high - low) or 0.01 * abs(high) or 1.0
        end = high + 8 * margin
        largest = max([float(costs[np.isfinite(costs)].max(initial=low)) for costs in everyone], default=high)
        axes.set_xlim(low - margin, min(end, max(high, largest) + margin))
        for index, costs in enumerate(everyone):
            _box(axes, index, costs, end, lost)
        if bound is not None:
            axes.axvline(bound, **_BOUND)
        axes.set_title(plain(_short(title)))
        axes.set_xlabel(quantity if bound is None else f"{quantity} (dashed: lower bound, {bound:,.6g})")
        _named(axes, labels)
    return figure


def bars(labels: Sequence[str], efforts: Mapping[str, Sequence[float]]) -> "Figure":
    """Draw one panel of bars, a bar for each label, for each of `efforts`, whose keys are the panels' titles."""
    figure, grid = _panels(len(efforts), len(efforts), height=0.26 * len(labels) + 0.9, sharey=True)
    for axes, (title, values) in zip(grid, efforts.items(), strict=True):
        largest = max(values)
        for index, value in enumerate(values):
            axes.barh(index, value, height=0.62, color=_colour(index), hatch="///" if _lap(index) else None, alpha=0.85)
            axes.annotate(_amount(value), (value, index), (3, 0), textcoords="offset points", va="center", fontsize=8.5)
        axes.set_xlim(0, 1.45 * largest or 1.0)
        axes.set_xticks([])
        axes.grid(visible=False)
        axes.spines["bottom"].set_visible(False)
        axes.set_title(title)
        _named(axes, labels)
    return figure


def profiles(labels: Sequence[str], curves: Sequence[tuple[Floats, Floats]], against: str) -> "Figure":
    """Draw performance profiles: the share of runs whose cost is within a ratio of `against`.

    The axis ends twice as far from 1 as the 95 % quantile of the ratios, or at the largest ratio, so that a few large
    ratios do not squeeze the others.
    """
    found = np.concatenate([[1.0], *(ratio for ratio, _ in curves)])
    far = float(found.max())
    end = max(1.01, min(1.03 * far - 0.03, 2 * float(np.quantile(found, 0.95)) - 1))
    steps = [
        (np.r_[1.0, ratio, max(end, far)], np.r_[0.0, share, share[-1:] if len(share) else 0.0])
        for ratio, share in curves
    ]
    figure, axes = _shares(labels, steps, f"cost / {against}", "share of runs")
    if end > 4:
        logarithmic(axes, "x", (1.0, 2.0, 5.0))
    axes.set_xlim(1.0, end)
    return figure


def run_lengths(labels: Sequence[str], lengths: Sequence[Floats]) -> "Figure":
    """Draw the share of runs and targets that were reached after so many evaluations; `lengths` (n,) of each label."""
    reached = [np.sort(each[np.isfinite(each)]) for each in lengths]
    steps = [(x, np.arange(1, len(x) + 1) / max(1, len(each))) for x, each in zip(reached, lengths, strict=True)]
    figure, axes = _shares(labels, steps, "evaluations", "share of runs and targets")
    logarithmic(axes, "x", (1.0,))
    axes.set_xlim(left=1)
    return figure


def _shares(labels: Sequence[str], steps: Sequence[tuple[Floats, Floats]], x: str, y: str) -> tuple["Figure", Any]:
    """Return a figure of step functions from 0 to 1, one for each label, and its axes."""
    figure, (axes,) = _panels(1, 1, height=3.8 + _legend_height(labels))
    for index, step in enumerate(steps):
        _step(axes, index, *step)
    axes.set_ylim(0.0, 1.02)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    _legend(figure, labels, bound=False)
    return figure, axes


def _step(axes: Any, index: int, x: Floats, y: Floats) -> None:
    axes.step(x, y, where="post", color=_colour(index), linestyle=_dash(index), linewidth=1.7)


def critical_difference(labels: Sequence[str], found: Ranking) -> "Figure":
    """Draw mean ranks on a line, the best at the left; bars join planners that do not differ (Demsar 2006)."""
    count = len(labels)
    left = (count + 1) // 2
    levels = _levels(found)
    first = 0.42 + 0.14 * (max(levels, default=-1) + 1)  # inches from the axis to the first name
    depth = first + 0.24 * (left - 1) + 0.2
    above = 0.75
    figure = blank(FIGURE_WIDTH, above + depth)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0, FIGURE_WIDTH)
    axes.set_ylim(-depth, above)
    names = [_short(label, 30) for label in labels]
    side = max(1.1, 0.3 + 0.069 * (max(map(len, names)) + 6))

    def x(rank: float) -> float:
        return side + (rank - 1) / (count - 1) * (FIGURE_WIDTH - 2 * side)

    line: Any = {"color": INK, "linewidth": 1.1, "solid_capstyle": "butt"}
    axes.plot([x(1), x(count)], [0, 0], **line)
    for rank in range(1, count + 1):
        axes.plot([x(rank)] * 2, [0, 0.09], **line)
        if count < 9 or rank % 2:
            axes.text(x(rank), 0.13, str(rank), ha="center", va="bottom", fontsize=9)
    axes.text(x(1) - 0.15, 0.13, "mean rank", ha="right", va="bottom", fontsize=9, color=SOFT)
    reach = min(found.critical_difference, count - 1.0)
    axes.plot([x(1), x(1 + reach)], [0.5, 0.5], **line | {"linewidth": 2.2})
    at_least = "" if reach == found.critical_difference else " (longer than the axis)"
    axes.text(x(1), 0.56, f"critical difference {found.critical_difference:.2f}{at_least}", va="bottom", fontsize=9)
    for group, level in zip(found.groups, levels, strict=True):
        ends = [x(found.ranks[group[0]]) - 0.05, x(found.ranks[group[-1]]) + 0.05]
        axes.plot(ends, [-0.16 - 0.14 * level] * 2, **line | {"linewidth": 3.6})
    for place, index in enumerate(np.argsort(found.ranks, kind="stable")):
        at_left = place < left
        y = -first - 0.24 * (place if at_left else count - 1 - place)
        edge, end = (side - 0.12, "right") if at_left else (FIGURE_WIDTH - side + 0.12, "left")
        mean, label = f"{found.ranks[index]:.2f}", plain(names[index])
        axes.plot([x(found.ranks[index])] * 2 + [edge], [0, y, y], color=_colour(int(index)), linewidth=1.1)
        text = f"{label}  {mean} " if at_left else f" {mean}  {label}"
        axes.text(edge, y, text, ha=end, va="center", fontsize=9.5)
    return figure


def _levels(found: Ranking) -> list[int]:
    """Return the level below the axis at which each group's bar is drawn, so that no two bars touch."""
    ends: list[float] = []
    levels = []
    for group in found.groups:
        low, high = found.ranks[group[0]], found.ranks[group[-1]]
        level = next((k for k, end in enumerate(ends) if end + 0.3 < low), len(ends))
        ends[level : level + 1] = [high]
        levels.append(level)
    return levels


def _panels(panels: int, columns: int, *, height: float, sharey: bool = False) -> tuple["Figure", list[Any]]:
    rows = math.ceil(panels / columns)
    figure = blank(FIGURE_WIDTH, height)
    figure.set_layout_engine("constrained")
    grid = figure.subplots(rows, columns, sharey=sharey, squeeze=False).ravel().tolist()
    for axes in grid[panels:]:
        axes.remove()
    return figure, grid[:panels]


def _whiskers(costs: Floats) -> tuple[float, float]:
    """Return the least and the largest cost within 1.5 box lengths of the box; five costs or fewer all count."""
    finite = costs[np.isfinite(costs)]
    if len(finite) > 5:
        low, high = (float(quantile(finite, q)) for q in (0.25, 0.75))
        reach = 1.5 * (high - low)
        finite = finite[(finite >= low - reach) & (finite <= high + reach)]
    return float(finite.min()), float(finite.max())


def _box(axes: Any, index: int, costs: Floats, end: float, without: str) -> None:
    colour = _colour(index)
    finite = costs[np.isfinite(costs)]
    dots = finite
    if len(finite) > 5:
        low, median, high = (float(quantile(finite, q)) for q in (0.25, 0.5, 0.75))
        least, most = _whiskers(costs)
        dots = finite[(finite < least) | (finite > most)]
        axes.hlines([index, index], [least, high], [low, most], color=colour, linewidth=1.1)
        axes.barh(index, high - low, left=low, height=0.56, facecolor=colour + "33", edgecolor=colour, linewidth=1.1)
        axes.vlines(median, index - 0.28, index + 0.28, color=colour, linewidth=2.2)
        axes.plot(finite.mean(), index, "D", color="white", markeredgecolor=colour, markersize=4.5)
    near = dots[dots <= end]
    axes.plot(near, np.full(len(near), index), "o", color=colour, markersize=3.2, alpha=0.6, markeredgewidth=0)
    far, lost = dots[dots > end], len(costs) - len(finite)
    told = [f"{len(far)} beyond, up to {far.max():,.4g}"] if len(far) else []
    told += [f"{lost} {without}"] if lost else [] if len(costs) else ["no runs"]
    under: Any = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
    where: Any = {"xycoords": ("axes fraction", "data"), "ha": "right", "va": "center"}
    axes.annotate(", ".join(told), (1, index), **where, fontsize=8.5, color=INK, bbox=under if told else None)


def _named(axes: Any, labels: Sequence[str]) -> None:
    axes.set_yticks(range(len(labels)), [plain(_short(label)) for label in labels])
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")


def _legend(figure: "Figure", labels: Sequence[str], *, bound: bool) -> None:
    from matplotlib.lines import Line2D

    lines = [Line2D([], [], color=_colour(k), linestyle=_dash(k), linewidth=1.9) for k in range(len(labels))]
    names = [plain(_short(label)) for label in labels]
    if bound:
        lines.append(Line2D([], [], **_BOUND))
        names.append("lower bound")
    figure.legend(lines, names, loc="outside lower center", ncols=_columns(labels), handlelength=2.4)


def _columns(labels: Sequence[str]) -> int:
    widest = max([len(_short(label)) for label in labels] + [13])
    return max(1, min(len(labels) + 1, 105 // (widest + 8)))


def _legend_height(labels: Sequence[str]) -> float:
    return 0.25 + 0.2 * math.ceil((len(labels) + 1) / _columns(labels))


def _amount(value: float) -> str:
    return f"{value:,.0f}" if value >= 100 or value == int(value) else f"{value:.3g}"


def _short(label: str, most: int = 36) -> str:
    line = one_line(label)
    tail = most // 2  # the settings that distinguish planners are at the end
    return line if len(line) <= most else f"{line[: most - tail - 1]}…{line[-tail:]}"


def _lap(index: int) -> int:
    return index // len(PLANNER_COLOURS)


def _colour(index: int) -> str:
    return PLANNER_COLOURS[index % len(PLANNER_COLOURS)]


def _dash(index: int) -> Any:
    return LINE_STYLES[_lap(index) % len(LINE_STYLES)]
