"""Pictures for the prompt and for notebooks: ``plot`` returns a figure of whatever can be drawn."""

from functools import singledispatch

from matplotlib.figure import Figure

from skyverse.draw.figures import fleet_figure, given, mission_figures
from skyverse.draw.line_figures import has_search, motion_figure, path_figure
from skyverse.draw.scene import Scene, scenario_scene, scene
from skyverse.draw.track import track
from skyverse.errors import InputError, shown
from skyverse.model.mission import Mission, PlannedFlight
from skyverse.model.result import Result
from skyverse.model.scenario import Scenario, Target
from skyverse.model.trajectory import Trajectory
from skyverse.model.uav import UAV


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
