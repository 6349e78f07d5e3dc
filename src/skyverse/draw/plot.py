"""Pictures for the prompt and for notebooks: ``plot`` returns a figure of whatever can be drawn."""

from functools import singledispatch
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from skyverse.draw.figures import fleet_figure, given, mission_figures
from skyverse.draw.map_figure import GRID, INK, SOFT, blank, plain
from skyverse.draw.palette import FINDINGS, TRACKS
from skyverse.draw.scenes import Scene, scenario_scene, scene
from skyverse.draw.track import track
from skyverse.errors import InputError, shown
from skyverse.model.mission import Mission, PlannedFlight
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario, Target
from skyverse.model.short_lines import told_seconds
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV

SAMPLES = 17
"""Instants at which each piece of a trajectory is drawn."""
_COLOUR, _LIMIT_COLOUR = TRACKS[0], FINDINGS["error"]


def plot(drawn: Scenario | Mission | Result | Trajectory, detail: object = None) -> Figure:
    """Return a figure; a notebook shows it, and ``.savefig("mission.png")`` writes it.

    Parameters
    ----------
    drawn
        A scenario: the space with starts and targets, and rings around those that are not safe. A mission: its
        trajectories, or its paths where nobody flies. A result: the path from above and from the side, and the search
        where it has a history. A trajectory: height, speed, climb and acceleration over time.
    detail
        Of a mission the name of another figure, as `write_figures` has them: ``"paths"``, ``"flight-start"``,
        ``"flight-middle"``, ``"flight-end"`` or ``"convergence"``. Of a result the scenario among whose obstacles the
        path is drawn instead. Of a trajectory the UAV whose limits are drawn too, as in ``scenario.uavs[0]``.

    Raises
    ------
    InputError
        If it is none of these, or has no such figure; the message names those that it has.
    """
    return _figure(drawn, detail)


@singledispatch
def _figure(drawn: object, detail: object) -> Figure:
    raise InputError(f"plot: expected a scenario, a mission, a result or a trajectory, found {shown(drawn)}")


@_figure.register
def _(drawn: Scenario, detail: object) -> Figure:
    if detail is not None:
        raise InputError(f"a scenario has one figure, which is drawn by plot(scenario); found {shown(detail)}")
    return given(scenario_scene(drawn))


@_figure.register
def _(drawn: Mission, detail: object) -> Figure:
    known = dict(mission_figures(scene(drawn)))
    wanted = detail or ("trajectories" if "trajectories" in known else "paths")
    if not isinstance(wanted, str) or wanted not in known:
        raise InputError(f"this mission has no figure {shown(wanted)}; it has {', '.join(known)}")
    return known[wanted]()


@_figure.register
def _(drawn: Result, detail: object) -> Figure:
    if detail is None:
        return path_figure(drawn)
    if not isinstance(detail, Scenario):
        searched = " and its search" if has_search(drawn) else "; its search has no history to draw"
        raise InputError(
            f"a result is drawn by plot(result), its path{searched}, or by plot(result, scenario), its path among "
            f"obstacles; found {shown(detail)}"
        )
    start, goal = (tuple(map(float, place)) for place in (drawn.start, drawn.goal))
    flyer = UAV(name=drawn.provenance.planner.partition("(")[0], start=start)
    flight = PlannedFlight(flyer, Target(name="target", position=goal), drawn)
    alone = Scene(scenario=detail, tracks=(track(flight, 0, detail.bounds),), spare_targets=(), findings=())
    return fleet_figure(alone, "path", lambda track: [(track.path, 2.0, 1.0)])


@_figure.register
def _(drawn: Trajectory, detail: object) -> Figure:
    if detail is not None and not isinstance(detail, UAV):
        raise InputError(
            "a trajectory is drawn by plot(trajectory), over time, or by plot(trajectory, uav), with the limits of a "
            f"UAV such as scenario.uavs[0]; found {shown(detail)}"
        )
    return motion_figure(drawn, detail)


# ---- figures of one path and of one trajectory, without the world around them ----
def has_search(result: Result) -> bool:
    """Tell whether a result has a history of its search that can be drawn."""
    return len(result.history.cost) > 1


def path_figure(result: Result) -> Figure:
    """Return the figure of a result: its path from above and from the side, and its best cost where it has a history.

    A white dot is the start, a diamond the goal.
    """
    searched = has_search(result)
    figure, (above, side, *rest) = _panels(1, 3 if searched else 2, width=12.0 if searched else 8.4, height=3.8)
    path = result.path
    flown = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1))])[: len(path)]
    above.plot(path[:, 0], path[:, 1], color=_COLOUR, linewidth=2)
    side.plot(flown, path[:, 2], color=_COLOUR, linewidth=2)
    _ends(above, result.start[:2], result.goal[:2])
    if result.status.reached:
        _ends(side, (flown[0], path[0, 2]), (flown[-1], path[-1, 2]))
    above.set_aspect("equal", adjustable="datalim")
    _name(above, "The path from above", "x, m", "y, m")
    _name(side, "The path from the side", "metres flown, seen from above", "z, m")
    for axes in rest:
        cost = np.where(np.isfinite(result.history.cost), result.history.cost, np.nan)
        axes.step(result.history.generated_paths, cost, where="post", color=_COLOUR, linewidth=2)
        if result.bound is not None:
            axes.axhline(result.bound, color=SOFT, linestyle="--", linewidth=1.1)
        _name(axes, f"Best cost so far{'' if result.bound is None else ' (dashed: its bound)'}", "generated paths", "")
    return figure


def motion_figure(trajectory: Trajectory, uav: UAV | None) -> Figure:
    """Return the figure of height, speed, climb and acceleration over time, with the limits of `uav` if it is given."""
    begins, lengths = trajectory.knots[:-1, None], np.diff(trajectory.knots)[:, None]
    t = np.unique(begins + lengths * np.linspace(0.0, 1.0, SAMPLES))
    motion = trajectory.at(t)
    speed, strength = (np.linalg.norm(values, axis=1) for values in (motion.velocity, motion.acceleration))
    curves = {
        "height z, m": motion.position[:, 2],
        "speed, m/s": speed,
        "climb, m/s": motion.velocity[:, 2],
        "acceleration, m/s²": strength,
    }
    figure, column = _panels(len(curves), 1, width=8.0, height=7.2)
    flown = f"{trajectory.form} trajectory, {told_seconds(trajectory.end - trajectory.start)} long"
    figure.suptitle(flown if uav is None else f"{plain(uav.name)}: {flown}", fontsize=12, color=INK)
    for axes, (name, values) in zip(column, curves.items(), strict=True):
        axes.plot(t, values, color=_COLOUR, linewidth=1.8)
        _name(axes, "", "", name)
        axes.sharex(column[0])
        axes.label_outer()
    column[-1].set_xlabel("seconds")
    if uav is not None:
        _, fast, climb, strong = column
        descent = None if uav.max_descent is None else -uav.max_descent
        limits = ((fast, uav.max_speed), (climb, uav.max_climb), (climb, descent), (strong, uav.max_acceleration))
        for axes, limit in limits:
            if limit is not None:
                axes.axhline(limit, color=_LIMIT_COLOUR, linestyle="--", linewidth=1.1)
        column[-1].set_xlabel(f"seconds (dashed: the limits of {plain(uav.name)})")
    return figure


def _panels(rows: int, columns: int, *, width: float, height: float) -> tuple[Figure, list[Any]]:
    """Return a figure of so many inches, and its panels."""
    figure = blank(width, height)
    figure.set_layout_engine("constrained")
    return figure, figure.subplots(rows, columns, squeeze=False).ravel().tolist()


def _ends(axes: Any, start: Any, goal: Any) -> None:
    """Mark a start and a goal, two numbers each."""
    for (x, y), symbol, inside in ((start, "o", "white"), (goal, "D", _COLOUR)):
        axes.plot(x, y, symbol, markersize=7, markerfacecolor=inside, markeredgecolor=_COLOUR, clip_on=False, zorder=3)


def _name(axes: Any, title: str, x: str, y: str) -> None:
    """Name a panel and its axes."""
    axes.set_title(title, fontsize=10.5, loc="left", color=INK)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
