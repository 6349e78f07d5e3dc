"""Pictures for the prompt and for notebooks: what ``plot`` returns, and what a notebook shows of an answer."""

from base64 import b64encode
from html import escape

from matplotlib.figure import Figure

from skyverse.draw.figure_files import fleet_figure
from skyverse.draw.figures import given, mission_figures
from skyverse.draw.line_figures import has_search, motion_figure, path_figure
from skyverse.draw.mission_tables import flight_table
from skyverse.draw.scenario_scene import scenario_scene
from skyverse.draw.scene import Scene, scene
from skyverse.draw.shown_figure import png
from skyverse.draw.track import track
from skyverse.errors import InputError, shown
from skyverse.model.mission import Mission
from skyverse.model.planned_flights import PlannedFlight
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario, Target
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV


def plot_scenario(scenario: Scenario) -> Figure:
    """Return the figure of a scenario."""
    return given(scenario_scene(scenario))


def plot_mission(mission: Mission, figure: str | None) -> Figure:
    """Return the figure of a mission of that name; without a name the trajectories, or the paths where none fly."""
    known = dict(mission_figures(scene(mission)))
    wanted = figure or ("trajectories" if "trajectories" in known else "paths")
    if wanted not in known:
        raise InputError(f"this mission has no figure {shown(wanted)}; it has {', '.join(known)}")
    return known[wanted]()


def plot_result(result: Result, scenario: object) -> Figure:
    """Return the figure of a path and of the search for it, or of the path among the obstacles of a scenario."""
    if scenario is None:
        return path_figure(result)
    if not isinstance(scenario, Scenario):
        searched = " and its search" if has_search(result) else "; its search has no history to draw"
        raise InputError(
            f"a result is drawn by plot(), its path{searched}, or by plot(scenario), its path among obstacles; "
            f"found {shown(scenario)}"
        )
    start, goal = (tuple(map(float, place)) for place in (result.start, result.goal))
    flyer = UAV(name=result.provenance.planner.partition("(")[0], start=start)
    flight = PlannedFlight(flyer, Target(name="target", position=goal), result)
    one = track(flight, 0, scenario.bounds)
    drawn = Scene(scenario=scenario, tracks=(one,), spare_targets=(), findings=())
    return fleet_figure(drawn, "path", lambda track: [(track.path, 2.0, 1.0)])


def plot_trajectory(trajectory: Trajectory, uav: object) -> Figure:
    """Return the figure of a trajectory over time, with the limits of a UAV where it is given."""
    if uav is not None and not isinstance(uav, UAV):
        raise InputError(
            "a trajectory is drawn by plot(), over time, or by plot(uav), with the limits of a UAV such as "
            f"scenario.uavs[0]; found {shown(uav)}"
        )
    return motion_figure(trajectory, uav)


def as_html(shown: Scenario | Mission | Result | Trajectory) -> str:
    """Return what a notebook shows: a picture, what the prompt would show, and of a mission its table.

    The picture is a PNG inside the text: it looks the same in every notebook, in what is exported from it, and where
    the notebook is not trusted. The interactive page of `write_html` has plotly inside, and is twenty times as large.
    """
    picture = b64encode(png(shown.plot())).decode("ascii")
    parts = [
        f'<img src="data:image/png;base64,{picture}" style="max-width: 100%" alt="{type(shown).__name__}">',
        f"<pre>{escape(repr(shown))}</pre>",
    ]
    if isinstance(shown, Mission):
        parts.append(f'<div style="max-height: 24em; overflow: auto"><table>{flight_table(scene(shown))}</table></div>')
    return "\n".join(parts)
