"""The command line: every verb a few lines over the public API; what a user got wrong ends in one sentence and 2."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, CycloptsError, Group, Parameter, UnusedCliTokensError

from skyverse._version import __version__
from skyverse.cli.cache import cache
from skyverse.cli.compare import compare
from skyverse.cli.export import export
from skyverse.cli.fly import fly
from skyverse.cli.options import for_command_line
from skyverse.cli.report import json_text, report, table, violation_data
from skyverse.cli.reproduce import reproduce
from skyverse.cli.scenario import app as scenario_app
from skyverse.cli.watch import progress_bar, stop_rule
from skyverse.cli.words import (
    file_name,
    make_folder,
    planner_of,
    refuse_output,
    refuse_unsafe,
    tell_unknown,
    tell_unsought,
    whole_number,
    with_more,
    without_way,
)
from skyverse.errors import InputError

FOUND_WRONG, BAD_INPUT, INTERRUPTED = 1, 2, 130

app = App(
    name="skyverse",
    version=__version__,
    help="Plan, prove and export 3-D missions for fleets of UAVs.\n\nExample: `skyverse plan table-4.8`",
    help_format="markdown",
    default_parameter=Parameter(negative_iterable=()),
)
budget = Group("Budget (whichever comes first; 40 iterations without any; a clock only beside a count)")
Output = Annotated[Path | None, Parameter(name=["--output", "-o"])]
AsJson = Annotated[bool, Parameter(name="--json", negative="")]
More = Annotated[list[str] | None, Parameter(allow_leading_hyphen=True)]


def main(words: Sequence[str] | None = None) -> None:
    """Run a command line, the program's own by default, and end with its exit code."""
    try:
        code = app(
            sys.argv[1:] if words is None else words,
            exit_on_error=False,
            print_error=False,
            result_action="return_value",
        )
    except UnusedCliTokensError as error:
        found = " ".join(map(repr, error.unused_tokens or ()))
        _fail(f"expected each of several values after its own option, as in --uav A --uav B, found {found} without one")
    except CycloptsError as error:
        _fail(" ".join(str(error).split()))
    except InputError as error:
        _fail(for_command_line(error))
    except MemoryError:
        _fail("the memory of this machine does not suffice; take longer lattice steps, smaller bounds or fewer paths")
    except KeyboardInterrupt:
        print("skyverse: interrupted, nothing was written", file=sys.stderr)
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(FOUND_WRONG)
    sys.exit(code)


@app.command
def scenarios(
    name: str | None = None,
    /,
    *,
    schema: Annotated[bool, Parameter(negative="")] = False,
    output: Output = None,
    as_json: AsJson = False,
) -> None:
    """List the built-in scenarios, or print one as YAML to start your own from.

    Examples: `skyverse scenarios`, `skyverse scenarios map1 -o mine.yaml`, `skyverse scenarios --schema`

    Parameters
    ----------
    name
        A built-in scenario, or a scenario or mission file.
    schema
        Print the JSON Schema of scenario files instead, for editors.
    output
        Write to this file (.yaml or .json) instead of printing.
    as_json
        Print JSON.
    """
    import skyverse as sky
    from skyverse.files import NAMES
    from skyverse.files.scenarios import scenario_text

    if schema or name:
        if schema:
            text = json_text(sky.scenario_schema())
        else:
            text = scenario_text(sky.read_scenario(str(name)), ".json" if as_json else ".yaml")
        if output is None:
            print(text, end="")
        elif schema:
            from skyverse.atomic import write_text

            write_text(output, text)
        else:
            refuse_output(output, str(name))
            sky.write(sky.read_scenario(str(name)), output)
        return
    rows = [
        {"name": s.name, "uavs": len(s.uavs), "obstacles": len(s.obstacles), "description": s.description}
        for s in map(sky.read_scenario, NAMES)
    ]
    if as_json:
        print(json_text(rows), end="")
    else:
        table(list(rows[0]), [[str(v) for v in row.values()] for row in rows])


@app.command
def plan(
    scenario: str,
    /,
    *,
    output: Output = None,
    planner: str = "mvo",
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    seed: Annotated[int | None, Parameter(converter=whole_number)] = None,
    iterations: Annotated[int | None, Parameter(group=budget, converter=whole_number)] = None,
    paths: Annotated[int | None, Parameter(group=budget, converter=whole_number)] = None,
    seconds: Annotated[float | None, Parameter(group=budget)] = None,
    assignment: Literal["path-cost", "euclidean", "identity"] = "path-cost",
    criterion: Literal["min-sum", "min-max"] = "min-sum",
    shape: Literal["minimum-snap", "minimum-jerk", "stop-and-go"] = "minimum-snap",
    keep_apart: bool = True,
    uav: More = None,
    target: More = None,
    unknown: Literal["free", "occupied"] | None = None,
    page: bool = True,
    as_json: AsJson = False,
) -> int:
    """Plan a mission: assign, plan, fly, keep apart, prove; write the mission file and its page.

    Examples: `skyverse plan table-4.8`, `skyverse plan map.txt --uav 0,-4,1 --target 2,17,3 --seed 1`,
    `skyverse plan map1 --planner mvo --set universes=50 --iterations 100`

    Exit code: 0 when every UAV that has a target got a path and a trajectory to it, all proven safe, within limits
    and apart; 1 when not, also where UAVs are given too close; 2 for bad input; 130 when interrupted: Ctrl-C writes
    the best mission so far.

    Parameters
    ----------
    scenario
        A built-in name (see `skyverse scenarios`), a scenario file, a course map, or a mission to plan anew.
    output
        The mission file, .json; the page is put beside it. By default out/NAME.json.
    planner
        mvo, gso, bbo, random-restart, hybrid-mvo, taut, theta-star, astar, cma-es, pso, ga, de, l-shade, woa, mfo, gwo
        or da.
    settings
        A planner's setting, as in `--set universes=50`; repeat for more.
    seed
        For the same mission again; drawn and told when left out.
    iterations
        End each UAV's run after so many iterations.
    paths
        End it after so many generated paths.
    seconds
        End it after so many seconds.
    assignment
        What a UAV's way to a target costs when they are assigned: exactly, in a straight line, or in the order given.
    criterion
        Make the fleet's total smallest, or its largest single cost.
    shape
        Trajectories through waypoints without stopping, with little snap or little jerk, or at rest at each.
    keep_apart
        Resolve conflicts between UAVs: by delay, speed, exchange of targets, or detour; or only report them.
    uav
        Add a UAV that starts at x,y,z; repeat for more.
    target
        Add a target at x,y,z; repeat for more.
    unknown
        What an OctoMap's unknown space is taken for; occupied when left out, if the map says what is free.
    page
        Write the page too.
    as_json
        Print what was found as JSON.
    """
    import skyverse as sky

    asked = with_more(scenario, sky.read_scenario(scenario, unknown=unknown), uav, target)
    tell_unknown(asked, unknown)
    refuse_unsafe(scenario, asked)
    method = planner_of(planner, settings or [])
    tell_unsought(asked, method)
    out = output if output is not None else Path("out") / f"{file_name(asked.name)}.json"
    if out.suffix.lower() != ".json":
        raise InputError(f"--output: {out}: a mission is written as .json")
    refuse_output(out, scenario)
    if page:
        refuse_output(out.with_suffix(".html"))
    with stop_rule(iterations, paths, seconds) as stop, progress_bar(asked, stop) as on_progress:
        mission = sky.plan_mission(
            asked,
            method,
            stop=stop,
            rng=seed,
            assignment=assignment,
            criterion=criterion,
            shape=shape,
            keep_apart=keep_apart,
            on_progress=on_progress,
        )
        sky.write(mission, out)
        written = [out]
        if page:
            written.append(out.with_suffix(".html"))
            sky.write_html(mission, written[-1])
    report(mission, written, as_json)
    if mission.interrupted:
        return INTERRUPTED
    return 0 if mission.complete and not mission.violations else FOUND_WRONG


@app.command
def check(mission: str, /, *, scenario: str | None = None, as_json: AsJson = False) -> int:
    """Let the referee judge a mission file, whoever planned it; exit code 1 if anything is wrong.

    Example: `skyverse check out/table-4.8.json`

    Parameters
    ----------
    mission
        A mission file.
    scenario
        Judge it against this scenario, not against the one that it embeds.
    as_json
        Print the violations as JSON.
    """
    import skyverse as sky

    judged = sky.read_mission(mission)
    violations = sky.check(judged.scenario if scenario is None else sky.read_scenario(scenario), judged)
    if as_json:
        print(json_text([violation_data(v) for v in violations]), end="")
    else:
        for violation in violations:
            print(f"{violation.fault.value}: {violation.message}")
        print(f"{len(violations)} found." if violations else "The referee found nothing wrong.")
    if not judged.complete:
        print(without_way(judged), file=sys.stderr)
    return FOUND_WRONG if violations or not judged.complete else 0


@app.command
def show(
    mission: str,
    /,
    *,
    output: Output = None,
    figures: Path | None = None,
    browse: Annotated[bool, Parameter(name="--open", negative="")] = False,
) -> None:
    """Draw a mission: a page that flies it, or static figures.

    Examples: `skyverse show out/table-4.8.json --open`, `skyverse show out/table-4.8.json --figures figures/`

    Parameters
    ----------
    mission
        A mission file.
    output
        The page, .html; by default beside the mission file.
    figures
        Write figures (PNG) into this folder instead.
    browse
        Open the page in the browser.
    """
    import skyverse as sky

    drawn = sky.read_mission(mission)
    if figures is not None:
        make_folder(figures)
        for path in sky.write_figures(drawn, figures):
            print(path)
        return
    page = output if output is not None else Path(mission).with_suffix(".html")
    if page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--output: expected a file ending in .html, found {str(page)!r}")
    refuse_output(page)
    sky.write_html(drawn, page)
    print(page)
    if browse:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())


app.command(export)
app.command(fly)
app.command(compare)
app.command(reproduce)
app.command(scenario_app)
app.command(cache)


def _fail(sentence: str) -> None:
    print(f"skyverse: {sentence}", file=sys.stderr)
    sys.exit(BAD_INPUT)
