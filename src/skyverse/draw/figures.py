"""Still figures, of a mission: paths, trajectories, three instants of the flight, convergence; and their files."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyverse._typing import Floats
from skyverse.atomic import whole_file
from skyverse.draw.map_figure import (
    GRID,
    INK,
    LINE_STYLES,
    blank,
    ends,
    legend,
    line,
    logarithmic,
    map_figure,
    plain,
    ring,
    surveys,
    uav,
)
from skyverse.draw.scenes import MissionScene, Scene, SceneFinding, scenario_scene, scene
from skyverse.draw.track import DrawnTrack
from skyverse.errors import InputError, path_of, require_kind
from skyverse.model.mission import Mission
from skyverse.model.scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_figures(mission: Mission | Scenario, folder: str | Path, *, suffix: str = ".png") -> list[Path]:
    """Write the still figures of a mission or a scenario into `folder`, which must exist, and return their paths.

    Of a scenario there is one figure, ``scenario``, with rings around starts and targets that are not safe. The figures
    of a mission are ``paths``; where any UAV flies, ``trajectories``, ``flight-start``, ``flight-middle`` and
    ``flight-end`` (at 0, at half and at all of the makespan); and ``convergence`` where a search kept its history.

    Parameters
    ----------
    suffix
        ``".png"``, ``".svg"`` or ``".pdf"``.

    Raises
    ------
    InputError
        For another suffix, or if the folder does not exist or a file cannot be written.
    """
    require_kind(mission, (Mission, Scenario), "mission")
    if isinstance(mission, Scenario):
        return write_stills([("scenario", partial(given, scenario_scene(mission)))], folder, suffix)
    return write_stills(mission_figures(scene(mission)), folder, suffix)


def mission_figures(drawn: MissionScene) -> list[tuple[str, Callable[[], "Figure"]]]:
    """Return the names of the figures that a mission has, and what draws each of them."""
    makespan = drawn.makespan
    wanted: list[tuple[str, Callable[[], Figure]]] = [("paths", partial(paths, drawn))]
    if makespan is not None:
        shares = (("start", 0.0), ("middle", 0.5), ("end", 1.0))
        wanted.append(("trajectories", partial(trajectories, drawn)))
        wanted += [(f"flight-{name}", partial(instant, drawn, share * makespan)) for name, share in shares]
    if drawn.curves:
        wanted.append(("convergence", partial(convergence, drawn)))
    return wanted


def given(drawn: Scene) -> "Figure":
    """Return the figure of a scenario before anything is planned."""
    return fleet_figure(drawn, "before planning", lambda track: [], findings=drawn.findings)


def paths(drawn: MissionScene) -> "Figure":
    """Return the figure of the map with the paths."""
    return fleet_figure(drawn, "path" if len(drawn.tracks) == 1 else "paths", lambda track: [(track.path, 2.0, 1.0)])


def trajectories(drawn: MissionScene) -> "Figure":
    """Return the figure of the map with trajectories, thin paths, and rings around the referee's findings."""
    heading = "trajectory" if len(drawn.tracks) == 1 else "trajectories"
    return fleet_figure(
        drawn, heading, lambda track: [(track.path, 0.8, 0.55), (track.positions, 2.4, 1.0)], findings=drawn.findings
    )


def instant(drawn: MissionScene, t: float) -> "Figure":
    """Return the figure of the fleet at `t` seconds, with its trajectories up to that time."""
    heading = f"t = {t:.1f} s of {drawn.makespan or 0.0:.1f} s"
    return fleet_figure(drawn, heading, lambda track: [(track.positions, 0.9, 0.55), (track.flown(t), 2.6, 1.0)], t=t)


def convergence(drawn: MissionScene) -> "Figure":
    """Return the figure of the best cost so far, against iterations and against generated paths."""
    rows = -(-len(drawn.curves) // 8)
    height = 4.4 + 0.23 * rows
    figure = blank(10.0, height)
    both: Any = figure.subplots(1, 2, sharey=True)
    for axes, over in zip(both, ("iterations", "generated paths"), strict=True):
        for track, result in drawn.curves:
            cost, generated = result.history.cost, result.history.generated_paths
            _curve(axes, track, result.history.iteration if over == "iterations" else generated, cost, result.bound)
        axes.set_xlabel(over)
        axes.grid(color=GRID)
        axes.spines[["top", "right"]].set_visible(False)
    costs = np.concatenate([result.history.cost for _, result in drawn.curves])
    costs = costs[np.isfinite(costs) & (costs > 0)]
    if len(costs) and costs.max() > 12 * costs.min():
        logarithmic(both[0], "y", (1.0, 2.0, 5.0))
    both[0].set_ylabel("best cost so far")
    dashed = any(result.bound is not None for _, result in drawn.curves)
    heading = f"{plain(drawn.scenario.name)}: convergence{f' (dashed: the {drawn.bound})' if dashed else ''}"
    figure.suptitle(heading, fontsize=12, color=INK, y=1 - 0.2 / height)
    figure.subplots_adjust(
        left=0.08, right=0.98, top=1 - 0.55 / height, bottom=(0.75 + 0.23 * rows) / height, wspace=0.06
    )
    lines = both[0].get_lines()
    names = [plain(track.name) for track, _ in drawn.curves]
    figure.legend(lines, names, loc="lower center", ncols=min(8, len(names)), frameon=False, fontsize=9)
    return figure


def _curve(axes: Any, track: DrawnTrack, x: Any, cost: Floats, bound: float | None) -> None:
    dash = LINE_STYLES[track.lap % len(LINE_STYLES)]
    finite = np.where(np.isfinite(cost), cost, np.nan)
    axes.step(x, finite, where="post", color=track.colour, linestyle=dash, linewidth=1.8)
    if bound is not None:
        axes.hlines(bound, x[0], x[-1], color=track.colour, linestyles=(0, (4, 3)), linewidth=1.1)


DOTS_PER_INCH = 160


Line = tuple[Floats, float, float]
"""The points of a line, (n, 3), its width, and how opaque it is, from 0 to 1."""


def fleet_figure(
    drawn: Scene,
    heading: str,
    lines: Callable[[DrawnTrack], Sequence[Line]],
    *,
    t: float | None = None,
    findings: Iterable[SceneFinding] = (),
) -> "Figure":
    """Return the figure of the map with the lines of each UAV, its start and target, and rings around findings.

    With `t`, seconds, the UAVs are drawn where they are then.
    """
    figure, axes = map_figure(drawn, heading)
    surveys(axes, drawn)
    for track in drawn.tracks:
        for points, width, alpha in lines(track):
            line(axes, track, points, width=width, alpha=alpha)
        ends(axes, track)
        if t is not None:
            uav(axes, track, track.at(t))
    for finding in findings:
        ring(axes, finding)
    legend(figure, drawn)
    return figure


def write_stills(figures: Iterable[tuple[str, Callable[[], "Figure"]]], folder: Path | str, suffix: str) -> list[Path]:
    """Write figures, given by name, into a folder that exists, and return their paths.

    Raises
    ------
    InputError
        For a suffix other than ``".png"``, ``".svg"`` and ``".pdf"``, or if the folder does not exist or a file cannot
        be written.
    """
    if suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"figures are written as .png, .svg or .pdf, not as {suffix!r}", field="suffix")
    folder, written = path_of(folder, "folder"), []
    for name, draw in figures:
        path = folder / f"{name}{suffix}"
        with whole_file(path) as beside:
            draw().savefig(beside, dpi=DOTS_PER_INCH, facecolor="white")
        written.append(path)
    return written
