"""The verb ``plan``: a mission from a scenario."""

from dataclasses import replace
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from skyverse.cli.apart_by_timing import tell_apart_by_timing
from skyverse.cli.exit_codes import FOUND_WRONG, INTERRUPTED
from skyverse.cli.given_scenario import (
    limited,
    refuse_unsafe,
    tell_unknown,
    tell_unsought,
    tell_unspent,
    with_ceiling,
    with_ends,
    with_lattice,
)
from skyverse.cli.option_types import FLAG, PLANNER, SIGNED, WHOLE, AsJson, GivenScenario, Output, Whole
from skyverse.cli.outputs import mission_file, refuse_output, source_from
from skyverse.cli.places import tracking_error_of
from skyverse.cli.report import report
from skyverse.cli.settings import planner_of
from skyverse.cli.watch import compile_with_bar, progress_bar, stop_rule
from skyverse.errors import InputError

budget = Group("Budget (whichever comes first; 40 iterations without any; a clock only beside a count)")
fleet = Group("Limits of all UAVs, instead of those in the scenario")
More = Annotated[list[str] | None, SIGNED]


def plan(
    scenario: GivenScenario,
    /,
    *,
    output: Output = None,
    planner: Annotated[str, PLANNER] = "auto",
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    seed: Whole = None,
    iterations: Annotated[int | None, Parameter(group=budget), WHOLE] = None,
    paths: Annotated[int | None, Parameter(group=budget), WHOLE] = None,
    seconds: Annotated[float | None, Parameter(group=budget)] = None,
    assignment: Literal["path-cost", "euclidean", "identity"] = "path-cost",
    criterion: Literal["min-sum", "min-max"] = "min-sum",
    shape: Literal["minimum-time", "minimum-snap", "minimum-jerk", "stop-and-go"] = "minimum-time",
    keep_apart: bool = True,
    apart_in_space: Annotated[bool, FLAG] = False,
    uav: More = None,
    target: More = None,
    vehicle: Annotated[str | None, Parameter(group=fleet)] = None,
    max_speed: Annotated[float | None, Parameter(group=fleet)] = None,
    max_climb: Annotated[float | None, Parameter(group=fleet)] = None,
    max_descent: Annotated[float | None, Parameter(group=fleet)] = None,
    separation: Annotated[float | None, Parameter(group=fleet)] = None,
    tracking_error: Annotated[str | None, Parameter(group=fleet), SIGNED] = None,
    max_height: Annotated[str | None, SIGNED] = None,
    lattice_step: Annotated[str | None, SIGNED] = None,
    unknown: Literal["free", "occupied"] | None = None,
    workers: Whole = None,
    page: bool = True,
    details: Annotated[bool, FLAG] = False,
    as_json: AsJson = False,
) -> int:
    """Plan a mission: assign targets, plan paths and trajectories, resolve conflicts, prove; write a file and a page.

    Examples: `skyverse plan table-4.8`, `skyverse plan map.txt --uav 0,-4,1 --target 2,17,3 --seed 1`,
    `skyverse plan map1 --planner mvo --set universes=50 --iterations 100`, `skyverse plan city.yaml --vehicle camera
    --max-speed 8 --separation 10`

    Exit code: 0 when every UAV that has a target has a path and a trajectory to it, and all are proven safe, within
    limits and apart; 1 when not, also where UAVs start too close to each other; 2 for bad input; 130 when interrupted:
    Ctrl-C writes the best mission so far.

    Parameters
    ----------
    scenario
        A built-in name (see `skyverse scenarios`), a scenario file, a course map, or a mission to plan anew.
    output
        The mission file, .json; the page is put beside it. By default out/NAME.json, named after SCENARIO, which
        planning it again replaces, also after a change; NAME-2.json and so on where that is of another scenario.
    planner
        By default auto, which chooses by what the scenario prices: astar, exact on the lattice, where nodes are priced;
        taut where length is all, among boxes; cheapest where turns, altitude, risk or climb are priced too, or where
        obstacles have other shapes.
    settings
        A setting of the planner, as in `--set universes=50`; repeat for more.
    seed
        The seed, for the same mission again; drawn and told when left out.
    iterations
        End each UAV's run after so many iterations.
    paths
        End it after so many generated paths.
    seconds
        End it after so many seconds.
    assignment
        How targets are assigned: by the exact cost of each path, by straight lines, or in the order given.
    criterion
        What the assignment minimises: the fleet's total cost, or its largest single cost.
    shape
        The trajectories: through waypoints without stopping, with little snap or little jerk, or at rest at each one.
    keep_apart
        Resolve conflicts between UAVs by delay, speed, exchange of targets, or detour; otherwise only report them.
    apart_in_space
        Lead UAVs around the paths of others, so that they keep apart whatever the timing; exports then say so.
    uav
        UAVs in place of the scenario's, with their limits: where each starts, as x,y,z in metres or, in a scenario with
        an origin, as `46.81,9.85,60 m agl`; with a name as in `alpha=46.81,9.85,60 m agl`. Repeat for more.
    target
        Targets in place of the scenario's, written in the same ways; repeat for more.
    vehicle
        Give all UAVs the limits of a vehicle: indoor, thesis, camera, heavy or mapping.
    max_speed
        The fastest that UAVs fly, m/s.
    max_climb
        The fastest that they climb, m/s.
    max_descent
        The fastest that they descend, m/s.
    separation
        The distance that they keep from each other, metres; twice as much above and below, or the vehicle's own.
    tracking_error
        How far they may stray, as in `1.5,2`: metres seen from above, and metres in altitude.
    max_height
        How high above the ground below UAVs may fly, as in `120 m agl`; the scenario needs a terrain.
    lattice_step
        The step of the lattice in place of the scenario's, metres, or along x, y and z as in `50,50,10`. When left out,
        it is the scenario's, with steps upright that fit below the ceiling above ground.
    unknown
        What an OctoMap's unknown space is taken for; occupied when left out, if the map says what is free.
    workers
        Threads that price pairs and plan paths side by side; as many as there are cores when left out. The mission does
        not depend on it.
    page
        Write the page as well.
    details
        Print of each search also the bound, the generated paths and the terms of the cost.
    as_json
        Print what was found as JSON.
    """
    import skyverse as sky
    from skyverse.model.fleet_limits import FleetLimits
    from skyverse.numerics.compiling.kept_code import before_compiling

    limits = FleetLimits(
        vehicle=vehicle,
        max_speed=max_speed,
        max_climb=max_climb,
        max_descent=max_descent,
        separation=separation,
        tracking_error=tracking_error_of(tracking_error),
    )
    asked = with_ceiling(scenario, sky.read_scenario(scenario, unknown=unknown), max_height)
    asked = with_lattice(limited(with_ends(scenario, asked, uav, target), limits), lattice_step)
    tell_unknown(asked, unknown)
    refuse_unsafe(scenario, asked)
    method = planner_of(planner, settings or [], asked)
    tell_unsought(asked, method)
    out = output if output is not None else mission_file(scenario, asked)
    if out.suffix.lower() != ".json":
        raise InputError(f"--output: {out}: a mission is written as .json")
    refuse_output(out, scenario)
    if page:
        refuse_output(out.with_suffix(".html"))
    wings = ["aeroplane"] if any(uav.fixed_wing for uav in asked.uavs) else []
    before_compiling(lambda: compile_with_bar(["mission", type(method).__name__, shape, *wings]))
    with stop_rule(iterations, paths, seconds) as stop, progress_bar(asked, stop) as on_progress:
        tell_unspent(method, {"--iterations": iterations, "--paths": paths, "--seconds": seconds})
        mission = sky.plan_mission(
            asked,
            method,
            stop=stop,
            rng=seed,
            assignment=assignment,
            criterion=criterion,
            shape=shape,
            keep_apart=keep_apart,
            apart_in_space=apart_in_space,
            workers=workers,
            on_progress=on_progress,
        )
        mission = replace(mission, source=source_from(out, scenario))
        sky.write(mission, out)
        written = [out]
        if page:
            written.append(out.with_suffix(".html"))
            sky.write_html(mission, written[-1])
    report(mission, written, as_json, details)
    if apart_in_space:
        tell_apart_by_timing(mission)
    if mission.interrupted:
        return INTERRUPTED
    return 0 if mission.complete and not mission.violations else FOUND_WRONG
