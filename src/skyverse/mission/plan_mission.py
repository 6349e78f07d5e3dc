"""Plan the mission of a fleet: assign targets, plan paths, make trajectories, resolve conflicts, and check it all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, Protocol, get_args

from skyverse.deconfliction.detours import MakeTrajectory
from skyverse.deconfliction.find_conflicts import find_conflicts
from skyverse.deconfliction.paths_apart import apart_by_timing_only, keep_paths_apart
from skyverse.deconfliction.resolve_conflicts import resolve_conflicts
from skyverse.errors import InputError, require_choice, require_flag, require_kind
from skyverse.interrupt import Interrupted, interruptible
from skyverse.mission.assignment import Assignment, Criterion, assign_targets
from skyverse.mission.leg_planning import LegPlanning
from skyverse.mission.survey_flights import survey_flights
from skyverse.mission.tours import TourOptions, plan_tours
from skyverse.model.mission import Mission
from skyverse.model.result import Result, Status
from skyverse.model.scenario import Scenario
from skyverse.model.trajectory import Trajectory
from skyverse.model.verdict import Action, Deconfliction
from skyverse.model.wind import refuse_wind
from skyverse.numerics.side_by_side import side_by_side, threads
from skyverse.planners import planner_of
from skyverse.planners.auto import Auto
from skyverse.planners.base import DirectPlanner, Planner, Seed, provenance, seeded
from skyverse.planners.own_path import require_result
from skyverse.planners.results import refused_result
from skyverse.planners.taut import Taut
from skyverse.problem import Airspace, Problem
from skyverse.referee import judged
from skyverse.stop import Progress, Stop, is_cancelled, require_stop
from skyverse.summary import with_flight_summaries
from skyverse.trajectory import Shape, fly_along


@dataclass(frozen=True, kw_only=True)
class MissionOptions:
    """What `plan_mission` makes of targets and paths, other than by default.

    Attributes
    ----------
    criterion
        What the assignment minimises, ``"min-sum"`` or ``"min-max"``; ignored for ``"identity"``. See `assign`.
    shape
        Of the trajectories of multirotors. ``"minimum-time"``: along the path's straight legs with blends at the bends,
        or along a spline near the path where that is faster; ``"minimum-snap"`` and ``"minimum-jerk"``: along splines
        that may cut corners; ``"stop-and-go"``: at rest at every waypoint.
    order
        Of tours: ``"best"``, or ``"given"`` where each UAV visits its targets in the scenario's order.
    keep_apart
        Whether conflicts are resolved: UAVs that would come too close, those of lower priority first, depart later, fly
        more slowly, take a detour, or exchange targets (unless the assignment is ``"identity"``).
    apart_in_space
        Whether UAVs are first led around the paths of others, so that they keep their separation whatever the timing,
        as far as that can be; needs `keep_apart`. Conflicts that are left are resolved, and paths that are then near
        each other are led around once more.

    Raises
    ------
    InputError
        If paths are to be apart in space while conflicts are left.
    """

    criterion: Criterion = "min-sum"
    shape: Shape = "minimum-time"
    order: Literal["best", "given"] = "best"
    keep_apart: bool = True
    apart_in_space: bool = False

    def __post_init__(self) -> None:
        require_choice(self.criterion, get_args(Criterion), "criterion")
        require_choice(self.shape, get_args(Shape), "shape")
        require_choice(self.order, ("best", "given"), "order")
        require_flag(self.keep_apart, "keep_apart")
        require_flag(self.apart_in_space, "apart_in_space")
        if self.apart_in_space and not self.keep_apart:
            why = "conflicts are to be left, so that paths cannot be led apart in space"
            raise InputError(why, field="apart_in_space")


_BY_DEFAULT = MissionOptions()


class OnProgress(Protocol):
    """Called while a fleet is planned, with a UAV's index and its planner's progress (``None`` when it is done)."""

    def __call__(self, uav: int, progress: Progress | None, /) -> None:
        """Take note of the progress."""


def plan_mission(
    scenario: Scenario,
    planner: Planner | str | None = None,
    *,
    stop: Stop | None = None,
    rng: Seed = None,
    assignment: Assignment | Literal["tours"] = "path-cost",
    options: MissionOptions = _BY_DEFAULT,
    workers: int | None = None,
    on_progress: OnProgress | None = None,
) -> Mission:
    """Assign UAVs to targets, plan paths, make trajectories, resolve conflicts between them, and check the mission.

    Parameters
    ----------
    scenario
        The UAVs, targets, obstacles and the objective.
    planner
        Plans each UAV's path, or its name, such as ``"mvo"``; `Auto` by default, which chooses the best for the
        scenario.
    stop
        When the planning of each UAV's path ends. A `Cancelled` rule ends the whole mission with the results so far:
        once it is met no further path is begun, those begun are kept, of the first UAVs in the scenario's order, and
        nothing is judged; `check` and `certify` judge what is kept.
    rng
        Seed or generator. Every UAV draws from a stream of its own.
    assignment
        ``"path-cost"`` prices a pair by the exact cheapest path, ``"euclidean"`` by the straight line (the thesis's
        Algorithm 4), ``"identity"`` sends UAV i to target i (the thesis's "without coordination"). By ``"tours"`` each
        UAV visits as many targets as is best; so it does by ``"path-cost"`` where there are more targets than UAVs.
        Where targets ask for more than that one UAV flies there and stays, or UAVs return, all of them make tours, of
        one target each by ``"euclidean"`` and ``"identity"``.
    options
        What the assignment minimises, the shape of trajectories, and whether and how UAVs are kept apart.
    workers
        The number of threads by which pairs are priced and, where the planner ends by itself, paths are planned side by
        side; by default the number of cores. The mission does not depend on it.
    on_progress
        Called after every iteration, and when a UAV is done.

    Returns
    -------
    Mission
        Where a UAV has no path, the status of its result says why; nothing is raised.

    Raises
    ------
    InputError
        If scenario, planner, assignment, options, workers or seed is invalid, the stop rule does not fit the planner,
        or a UAV cannot fly in the scenario's wind.
    """
    require_kind(options, MissionOptions, "options")
    require_stop(stop)
    planned: Mission | None = None
    with interruptible(partial(is_cancelled, stop)):
        try:
            planned = _planned(scenario, planner, stop, rng, assignment, options, workers, on_progress)
            return judged(scenario, planned)
        except Interrupted:
            return _nobody_flies(scenario, planner) if planned is None else replace(planned, interrupted=True)


def _nobody_flies(scenario: Scenario, planner: Planner | str | None) -> Mission:
    """Return the mission of a run that was interrupted before any UAV had its turn."""
    nobody, origin = (None,) * len(scenario.uavs), provenance(repr(planner), None, None)
    sorties = ((),) * len(scenario.uavs) if scenario.surveys or scenario.asks_for_tours else ()
    mission = Mission(scenario, nobody, nobody, nobody, (), origin, interrupted=True, sorties=sorties)
    return with_flight_summaries(mission)


def _planned(
    scenario: Scenario,
    planner: Planner | str | None,
    stop: Stop | None,
    rng: Seed,
    assignment: Assignment | Literal["tours"],
    options: MissionOptions,
    workers: int | None,
    on_progress: OnProgress | None,
) -> Mission:
    """Return a mission that is not judged yet; see `plan_mission`."""
    require_kind(scenario, Scenario, "scenario")
    most_threads = threads(workers)
    flights = survey_flights(scenario)
    airspace = Airspace(flights.staged)
    for vehicle in scenario.uavs:
        refuse_wind(vehicle, scenario.winds)
    planner = planner_of(planner)
    if isinstance(planner, Auto):
        planner = Taut() if scenario.surveys else planner.choose(scenario)
    if scenario.surveys and not planner.leaves_lattice(scenario):
        raise InputError("surveys leave the lattice, which this planner does not; taut does", field="planner")
    generator, seed = seeded(rng)
    streams = generator.spawn(len(scenario.uavs))
    shape = options.shape
    require_choice(assignment, (*get_args(Assignment), "tours"), "assignment")
    if scenario.surveys and assignment in ("euclidean", "identity"):
        why = f"surveys need tours, which {assignment!r} does not make; use 'path-cost' or 'tours'"
        raise InputError(why, field="assignment")
    asked = f"{planner!r}, assignment={assignment!r}, criterion={options.criterion!r}, shape={shape!r}"
    direct = isinstance(planner, DirectPlanner)
    origin = provenance(asked, *((None, None) if direct else (stop, seed)))
    makes_tours = _makes_tours(scenario, assignment)
    assigned: tuple[int | None, ...] | None = None
    if assignment != "tours" and not (makes_tours and assignment == "path-cost"):
        assigned = assign_targets(airspace, assignment, options.criterion, most_threads)
    if assigned is None or makes_tours:
        legs = int(generator.integers(2**31))
        how = LegPlanning(planner=planner, stop=stop, seed=legs, shape=shape, workers=most_threads)
        tours = plan_tours(airspace, how, _tour_options(options, assigned), origin, flights.ways)
        return with_flight_summaries(flights.as_asked(tours))

    def flight(uav: int) -> tuple[Result | None, Trajectory | None]:
        target = assigned[uav]
        if target is None:
            return None, None
        problem = Problem(airspace, uav, target)
        report = None if on_progress is None else partial(on_progress, uav)
        result = require_result(planner.plan(problem, stop=stop, rng=streams[uav], on_iteration=report))
        return result, fly_along(problem, result, shape)

    results: list[Result | None] = []
    trajectories: list[Trajectory | None] = []
    flown = side_by_side(flight, len(assigned), most_threads if direct else 1)
    for uav, target in enumerate(assigned):
        left = None if target is None else refused_result(Problem(airspace, uav, target), Status.NOT_PLANNED, origin)
        result, trajectory = next(flown, (left, None))
        results.append(result)
        trajectories.append(trajectory)
        if on_progress is not None:
            on_progress(uav, None)
    interrupted = any(one is not None and (one.cancelled or one.status is Status.NOT_PLANNED) for one in results)
    mission = Mission(scenario, assigned, tuple(results), tuple(trajectories), (), origin, interrupted)
    if options.keep_apart and not interrupted:
        make_trajectory = partial(fly_along, shape=shape)
        replan = None if assignment == "identity" else partial(planner.plan, stop=stop, rng=generator.spawn(1)[0])
        resolve = partial(resolve_conflicts, airspace, make_trajectory=make_trajectory, replan=replan)
        if options.apart_in_space:
            mission = _apart_in_space(airspace, mission, make_trajectory, resolve)
        else:
            mission = resolve(mission)
    return with_flight_summaries(mission)


def _makes_tours(scenario: Scenario, assignment: str) -> bool:
    """Tell whether UAVs make tours; by ``"path-cost"`` also since there are more targets than UAVs, if all can stop."""
    more = len(scenario.targets) > len(scenario.uavs) > 0 and all(uav.fixed_wing is None for uav in scenario.uavs)
    return assignment == "tours" or scenario.asks_for_tours or (more and assignment == "path-cost")


def _tour_options(options: MissionOptions, only: tuple[int | None, ...] | None) -> TourOptions:
    if options.apart_in_space:
        raise InputError("tours are kept apart by timing only", field="apart_in_space")
    keep_order = options.order == "given"
    return TourOptions(criterion=options.criterion, keep_order=keep_order, keep_apart=options.keep_apart, only=only)


def _apart_in_space(
    airspace: Airspace, asked: Mission, make_trajectory: MakeTrajectory, resolve: Callable[[Mission], Mission]
) -> Mission:
    """Return a mission whose paths are led around each other, and whose remaining conflicts are resolved by `resolve`.

    What resolves a conflict, a detour or an exchange of targets, may lead a path near another one from which it was
    apart. So paths are then led around each other once more, and that is kept if it leaves fewer conflicts, or fewer
    pairs that are apart by timing only.
    """
    around, actions = keep_paths_apart(airspace, asked, make_trajectory)
    mission = _since(asked, resolve(around), actions)
    paths_changed = any(now is not then for now, then in zip(mission.results, around.results, strict=True))
    if mission.interrupted or not paths_changed:
        return mission
    again, actions = keep_paths_apart(airspace, mission, make_trajectory)
    anew = {action.uav for action in actions}
    done = () if mission.deconfliction is None else mission.deconfliction.actions
    holds = [action for action in done if action.uav not in anew or action.kind == "exchange"]
    second = _since(asked, resolve(replace(again, deconfliction=None)), [*holds, *actions])
    return min(mission, second, key=_left_undone)


def _left_undone(mission: Mission) -> tuple[int, int]:
    """Return how many conflicts that are not given are left in a mission, and how many pairs are apart by timing."""
    conflicts = find_conflicts(mission.scenario, mission.trajectories)
    return sum(not conflict.given for conflict in conflicts), len(apart_by_timing_only(mission))


def _since(asked: Mission, mission: Mission, actions: Sequence[Action]) -> Mission:
    """Return a mission whose record of deconfliction compares with the one asked for, and begins with some actions."""
    record = Deconfliction(
        found=find_conflicts(asked.scenario, asked.trajectories),
        left=find_conflicts(mission.scenario, mission.trajectories),
        actions=(*actions, *(() if mission.deconfliction is None else mission.deconfliction.actions)),
        total_before=asked.total_time,
        total_after=mission.total_time,
        makespan_before=asked.makespan,
        makespan_after=mission.makespan,
    )
    return replace(mission, deconfliction=record)
