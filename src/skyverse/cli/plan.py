"""The verb ``plan``: a mission from a scenario."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skyverse.cli.exit_codes import FOUND_WRONG, INTERRUPTED
from skyverse.cli.given_scenario import (
    from_the_ground,
    limited,
    refuse_unsafe,
    tell_unknown,
    tell_unsought,
    tell_unspent,
    with_ceiling,
    with_ends,
    with_lattice,
    with_wind,
    with_work,
)
from skyverse.cli.map_options import taking, values_of
from skyverse.cli.option_types import FLAG, PLANNER, SIGNED, AsJson, GivenScenario, Output, Whole
from skyverse.cli.outputs import mission_file, refuse_output, source_from
from skyverse.cli.places import wind_of
from skyverse.cli.report import report, tell_apart_by_timing
from skyverse.cli.settings import planner_of
from skyverse.cli.watch import compile_with_bar, progress_bar, stop_rule
from skyverse.errors import InputError
from skyverse.model.vehicle_profiles import FleetLimits

if TYPE_CHECKING:
    from skyverse.model.scenario import Scenario

More = Annotated[list[str] | None, SIGNED]


SEARCH, _OUTPUT = Group("How missions are sought"), Group("What else is written and printed")


@Parameter(name="*", group=SEARCH)
@dataclass(frozen=True, kw_only=True)
class PlannerOptions:
    """How paths are searched for.

    Parameters
    ----------
    planner
        By default auto, which chooses by what the scenario prices: astar, exact on the lattice, where nodes are priced;
        taut where length is all, among boxes; cheapest where turns, altitude, risk or climb are priced too, or where
        obstacles have other shapes.
    settings
        A setting of the planner, as in `--set universes=50`; repeat for more.
    seed
        The seed, for the same mission again; drawn and told when left out.
    workers
        Threads that price pairs and plan paths side by side; as many as there are cores when left out. The mission does
        not depend on it.
    """

    planner: Annotated[str, PLANNER] = "auto"
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None
    seed: Whole = None
    workers: Whole = None


@Parameter(
    name="*", group=Group("Budget (whichever comes first; 40 iterations without any; a clock only beside a count)")
)
@dataclass(frozen=True, kw_only=True)
class BudgetOptions:
    """When the search for a UAV's path ends.

    Parameters
    ----------
    iterations
        End each UAV's run after so many iterations.
    paths
        End it after so many generated paths.
    seconds
        End it after so many seconds.
    """

    iterations: Whole = None
    paths: Whole = None
    seconds: float | None = None


@Parameter(name="*", group=Group("Assignment and flight"))
@dataclass(frozen=True, kw_only=True)
class FleetOptions:
    """What `plan_mission` makes of the paths.

    Parameters
    ----------
    assignment
        How targets are assigned: by the exact cost of each path, by straight lines, in the order given, or several to
        each UAV, as also path-cost does where there are more targets than UAVs.
    order
        Of the targets that one UAV visits: the best, or that of the scenario.
    criterion
        What the assignment minimises: the fleet's total cost, or its largest single cost.
    shape
        The trajectories: through waypoints without stopping, with little snap or little jerk, or at rest at each one.
    keep_apart
        Resolve conflicts between UAVs by delay, speed, exchange of targets, or detour; otherwise only report them.
    apart_in_space
        Lead UAVs around the paths of others, so that they keep apart whatever the timing; exports then say so.
    """

    assignment: Literal["path-cost", "euclidean", "identity", "tours"] = "path-cost"
    order: Literal["best", "given"] = "best"
    criterion: Literal["min-sum", "min-max"] = "min-sum"
    shape: Literal["minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go"] = "minimum-time"
    keep_apart: bool = True
    apart_in_space: Annotated[bool, FLAG] = False


_OTHERWISE = Group("In place of what the scenario says")


@Parameter(name="*", group=_OTHERWISE)
@dataclass(frozen=True, kw_only=True)
class ScenarioOptions:
    """What is otherwise than in the scenario's file.

    Parameters
    ----------
    uav
        UAVs in place of the scenario's, with their limits: where each starts, as x,y,z in metres or, in a scenario with
        an origin, as `46.81,9.85,60 m agl`; with a name as in `alpha=46.81,9.85,60 m agl`. Repeat for more.
    target
        Targets in place of the scenario's, written in the same ways, or the points of a file, as `towers.kml` or, with
        the altitude of all, `towers.csv,60 m agl` (KML, GPX, GeoJSON, CSV and others); repeat for more.
    end
        Where all UAVs end: at their last target, or at home, where they start.
    stay
        How long a UAV stays at each target, seconds.
    max_height
        How high above the ground below UAVs may fly, as in `120 m agl`; the scenario needs a terrain.
    lattice_step
        The step of the lattice in place of the scenario's, metres, or along x, y and z as in `50,50,10`. When left out,
        it is the scenario's, with steps upright that fit below the ceiling above ground.
    unknown
        What an OctoMap's unknown space is taken for; occupied when left out, if the map says what is free.
    """

    uav: More = None
    target: More = None
    end: Literal["target", "home"] | None = None
    stay: float | None = None
    max_height: Annotated[str | None, SIGNED] = None
    lattice_step: Annotated[str | None, SIGNED] = None
    unknown: Literal["free", "occupied"] | None = None


@Parameter(name="*", group=_OTHERWISE)
@dataclass(frozen=True, kw_only=True)
class WindOptions:
    """The wind in which all fly.

    Parameters
    ----------
    wind
        The wind in which all fly, in place of the scenario's: its velocity towards east, north and up, m/s.
    wind_speed
        Its speed, m/s, with --wind-from.
    wind_from
        Where it blows from, degrees from north, clockwise, as pilots tell it: 270 is a west wind.
    gust
        How far the true wind may be from that, m/s, in any direction at any instant.
    """

    wind: Annotated[str | None, SIGNED] = None
    wind_speed: float | None = None
    wind_from: float | None = None
    gust: float | None = None

    def of(self, scenario: "Scenario") -> "Scenario":
        """Return a scenario in this wind."""
        return with_wind(scenario, wind_of(self.wind, self.wind_speed, self.wind_from), self.gust)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class MissionOutput:
    """What is written and printed of a mission.

    Parameters
    ----------
    output
        The mission file, .json; the page is put beside it. By default out/NAME.json, named after SCENARIO, which
        planning it again replaces, also after a change; NAME-2.json and so on where that is of another scenario.
    page
        Write the page as well.
    details
        Print of each search also the bound, the generated paths and the terms of the cost.
    as_json
        Print what was found as JSON.
    """

    output: Output = None
    page: Annotated[bool, Parameter(group=_OUTPUT)] = True
    details: Annotated[bool, FLAG, Parameter(group=_OUTPUT)] = False
    as_json: Annotated[AsJson, Parameter(group=_OUTPUT)] = False


_SEARCH, _BUDGET, _MISSION = PlannerOptions(), BudgetOptions(), FleetOptions()
_SCENARIO, _WIND, _WRITTEN = ScenarioOptions(), WindOptions(), MissionOutput()


@taking({FleetLimits: Group("Limits of all UAVs, instead of those in the scenario")})
def plan(
    scenario: GivenScenario,
    /,
    *,
    search: PlannerOptions = _SEARCH,
    budget: BudgetOptions = _BUDGET,
    mission: FleetOptions = _MISSION,
    otherwise: ScenarioOptions = _SCENARIO,
    wind: WindOptions = _WIND,
    written: MissionOutput = _WRITTEN,
    **limits: Any,
) -> int:
    """Plan a mission: assign targets, plan paths and trajectories, resolve conflicts, prove; write a file and a page.

    Examples: `skyverse plan table-4.8`, `skyverse plan map.txt --uav 0,-4,1 --target 2,17,3 --seed 1`,
    `skyverse plan map1 --planner mvo --set universes=50 --iterations 100`, `skyverse plan city.yaml --vehicle camera
    --max-speed 8 --separation 10`, `skyverse plan city.yaml --assignment tours --end home --stay 20 --vehicle camera`

    Exit code: 0 when every UAV that has a target has a path and a trajectory to it, tours visit all targets, and all
    are proven safe, within limits and apart; 1 when not, also where UAVs start too close to each other; 2 for bad
    input; 130 when interrupted: Ctrl-C writes the best mission so far.

    Parameters
    ----------
    scenario
        A built-in name (see `skyverse scenarios`), a scenario file, a course map, or a mission to plan anew.
    """
    import skyverse as sky

    given = sky.read_scenario(scenario, unknown=otherwise.unknown)
    asked = with_ends(scenario, with_ceiling(scenario, given, otherwise.max_height), otherwise.uav, otherwise.target)
    asked = with_work(asked, otherwise.end, otherwise.stay)
    asked = with_lattice(limited(asked, FleetLimits(**values_of(FleetLimits, limits))), otherwise.lattice_step)
    asked = wind.of(from_the_ground(asked))
    tell_unknown(asked, otherwise.unknown)
    return plan_scenario(asked, scenario, written, search, mission, budget, maps_told=bool(asked.built_with))


def plan_scenario(
    asked: "Scenario",
    scenario: str,
    written: MissionOutput,
    search: PlannerOptions,
    mission: FleetOptions,
    budget: BudgetOptions = _BUDGET,
    *,
    maps_told: bool = True,
) -> int:
    """Plan a mission of a scenario that was read from a source; write it, report it, and return the exit code."""
    import skyverse as sky
    from skyverse.model.go_no_go import go_no_go
    from skyverse.numerics.compiling import before_compiling

    refuse_unsafe(scenario, asked)
    method = planner_of(search.planner, search.settings or [], asked)
    tell_unsought(asked, method)
    out = written.output if written.output is not None else mission_file(scenario, asked)
    if out.suffix.lower() != ".json":
        raise InputError(f"--output: {out}: a mission is written as .json")
    refuse_output(out, scenario)
    if written.page:
        refuse_output(out.with_suffix(".html"))
    kinds = {"aeroplane": any(uav.fixed_wing for uav in asked.uavs), "survey": bool(asked.surveys)}
    needed = ["mission", type(method).__name__, mission.shape, *(name for name, there in kinds.items() if there)]
    before_compiling(lambda: compile_with_bar(needed))
    with (
        stop_rule(budget.iterations, budget.paths, budget.seconds) as stop,
        progress_bar(asked, stop) as on_progress,
    ):
        tell_unspent(method, {f"--{name}": most for name, most in vars(budget).items()})
        options = {name: value for name, value in vars(mission).items() if name != "assignment"}
        planned = sky.plan_mission(
            asked,
            method,
            stop=stop,
            rng=search.seed,
            assignment=mission.assignment,
            options=sky.MissionOptions(**options),
            workers=search.workers,
            on_progress=on_progress,
        )
        if planned.interrupted and not any(one is not None and len(one.path) for one in planned.results):
            raise KeyboardInterrupt("nothing was planned yet, and nothing is written")
        planned = replace(planned, source=source_from(out, scenario))
        sky.write(planned, out)
    files = [out]
    if written.page and not planned.interrupted:
        files.append(out.with_suffix(".html"))
        try:
            sky.write_html(planned, files[-1])
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"{out} is kept; skyverse show {out} draws it") from None
    report(planned, files, written.as_json, written.details, maps_told=maps_told)
    if mission.apart_in_space:
        tell_apart_by_timing(planned)
    if planned.interrupted:
        return INTERRUPTED
    return 0 if go_no_go(planned).go else FOUND_WRONG
