"""The command line: every verb a few lines over the public API; what a user got wrong ends in one sentence and 2."""

import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, CycloptsError, Group, Parameter

from skyverse._version import __version__
from skyverse.errors import InputError

if TYPE_CHECKING:
    from skyverse.mission import OnProgress
    from skyverse.planners.base import Planner
    from skyverse.result import Mission
    from skyverse.scenario import Scenario
    from skyverse.stop import Stop

FOUND_WRONG, BAD_INPUT, INTERRUPTED = 1, 2, 130

app = App(
    name="skyverse",
    version=__version__,
    help="Plan, prove and export 3-D missions for fleets of UAVs.\n\nExample: `skyverse plan table-4.8`",
    help_format="markdown",
    default_parameter=Parameter(negative_iterable=()),
)
budget = Group("Budget (whichever comes first; 40 iterations without any)")
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
    except CycloptsError as error:
        _fail(" ".join(str(error).split()))
    except InputError as error:
        _fail(str(error))
    except KeyboardInterrupt:
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
            text = _json(sky.scenario_schema())
        else:
            text = scenario_text(sky.read_scenario(str(name)), ".json" if as_json else ".yaml")
        if output is None:
            print(text, end="")
        elif schema:
            from skyverse.atomic import write_text

            write_text(output, text)
        else:
            sky.write(sky.read_scenario(str(name)), output)
        return
    rows = [
        {"name": s.name, "uavs": len(s.uavs), "obstacles": len(s.obstacles), "description": s.description}
        for s in map(sky.read_scenario, NAMES)
    ]
    if as_json:
        print(_json(rows), end="")
    else:
        _table(list(rows[0]), [[str(v) for v in row.values()] for row in rows])


@app.command
def plan(
    scenario: str,
    /,
    *,
    output: Output = None,
    planner: str = "mvo",
    settings: Annotated[list[str] | None, Parameter(name="--set")] = None,
    seed: int | None = None,
    iterations: Annotated[int | None, Parameter(group=budget)] = None,
    paths: Annotated[int | None, Parameter(group=budget)] = None,
    seconds: Annotated[float | None, Parameter(group=budget)] = None,
    assignment: Literal["path-cost", "euclidean", "identity"] = "path-cost",
    criterion: Literal["min-sum", "min-max"] = "min-sum",
    uav: More = None,
    target: More = None,
    page: bool = True,
    as_json: AsJson = False,
) -> int:
    """Plan a mission: assign, plan, time, check; write the mission file and its page.

    Examples: `skyverse plan table-4.8`, `skyverse plan map.txt --uav 0,-4,1 --target 2,17,3 --seed 1`,
    `skyverse plan map1 --planner mvo --set universes=50 --iterations 100`

    Exit code: 0 when every UAV that has a target got a checked path and trajectory to it (too little separation
    between UAVs is reported, not yet resolved), 1 when not, 2 for bad input, 130 when interrupted: Ctrl-C writes the
    best mission so far.

    Parameters
    ----------
    scenario
        A built-in name (see `skyverse scenarios`), a scenario file, a course map, or a mission to plan anew.
    output
        The mission file, .json; the page is put beside it. By default out/NAME.json.
    planner
        mvo, random-restart or astar.
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
    uav
        Add a UAV that starts at x,y,z; repeat for more.
    target
        Add a target at x,y,z; repeat for more.
    page
        Write the page too.
    as_json
        Print what was found as JSON.
    """
    import skyverse as sky

    given = _with_more(sky.read_scenario(scenario), uav, target)
    _refuse_unsafe(scenario, given)
    method = _planner(planner, settings or [])
    out = output if output is not None else Path("out") / f"{given.name}.json"
    if out.suffix.lower() != ".json":
        raise InputError(f"--output: {out}: a mission is written as .json")
    _refuse_output(out)
    with _stop(iterations, paths, seconds) as stop, _progress(given) as on_progress:
        mission = _given(
            sky.plan_mission,
            given,
            method,
            stop=stop,
            rng=seed,
            assignment=assignment,
            criterion=criterion,
            on_progress=on_progress,
        )
    sky.write(mission, out)
    written = [out]
    if page:
        written.append(out.with_suffix(".html"))
        sky.write_html(mission, written[-1])
    _report(mission, written, as_json)
    if mission.interrupted:
        return INTERRUPTED
    own = [v for v in mission.violations if v.fault is not sky.Fault.SEPARATION]
    return 0 if mission.complete and not own else FOUND_WRONG


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
        print(_json([_violation(v) for v in violations]), end="")
    else:
        for violation in violations:
            print(f"{violation.fault.value}: {violation.message}")
        print(f"{len(violations)} violations." if violations else "The referee found nothing wrong.")
    return FOUND_WRONG if violations else 0


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
        _make_folder(figures)
        for path in sky.write_figures(drawn, figures):
            print(path)
        return
    page = output if output is not None else Path(mission).with_suffix(".html")
    if page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--output: expected a file ending in .html, found {str(page)!r}")
    _refuse_output(page)
    sky.write_html(drawn, page)
    print(page)
    if browse:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())


@app.command
def export(mission: str, output: Path, /, *, rate: float = 20.0) -> None:
    """Export a mission's waypoints (.waypoints.csv) or sampled trajectories (.csv).

    Examples: `skyverse export out/map1.json map1.waypoints.csv`, `skyverse export out/map1.json map1.csv --rate 50`

    Parameters
    ----------
    mission
        A mission file.
    output
        The file to write; its ending tells what.
    rate
        Samples a second in trajectories.
    """
    import skyverse as sky

    sky.write(sky.read_mission(mission), output, rate=rate)
    print(output)


def _fail(sentence: str) -> None:
    print(f"skyverse: {sentence}", file=sys.stderr)
    sys.exit(BAD_INPUT)


def _given(function: Any, *args: Any, **kwargs: Any) -> Any:
    """Call what judges a user's words; its complaint becomes bad input."""
    try:
        return function(*args, **kwargs)
    except (ValueError, TypeError) as error:
        raise InputError(str(error)) from error


def _json(data: Any) -> str:
    return json.dumps(data, indent=2) + "\n"


def _with_more(scenario: "Scenario", uavs: list[str] | None, targets: list[str] | None) -> "Scenario":
    from skyverse.files.scenarios import scenario_from_data

    data = scenario.model_dump()
    data["uavs"] = [*data["uavs"], *({"start": _point("--uav", text)} for text in uavs or [])]
    data["targets"] = [*data["targets"], *({"position": _point("--target", text)} for text in targets or [])]
    for kind in ("uavs", "targets"):
        if not data[kind]:
            raise InputError(f"{scenario.name}: {kind}: there are none; give some with --{kind[:-1]} x,y,z")
    return scenario_from_data(scenario.name, data)


def _point(option: str, text: str) -> tuple[float, ...]:
    try:
        point = tuple(float(word) for word in text.split(","))
    except ValueError:
        point = ()
    if len(point) != 3:
        raise InputError(f"{option}: expected x,y,z in metres, as in 0,-4,1, found {text!r}")
    return point


def _refuse_unsafe(source: str, scenario: "Scenario") -> None:
    from skyverse.space.world import World

    world = World(scenario)
    places = [(f"uavs[{i}].start", u.name, u.start) for i, u in enumerate(scenario.uavs)]
    places += [(f"targets[{i}].position", t.name, t.position) for i, t in enumerate(scenario.targets)]
    for field, name, point in places:
        why = world.why_unsafe(point)
        if why is not None:
            raise InputError(f"{source}: {field} ({name}): expected a safe point, found {point}, which {why}")


def _planner(name: str, settings: list[str]) -> "Planner":
    import ast

    from skyverse.planners import make_planner

    values: dict[str, object] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise InputError(f"--set: expected name=value, as in universes=50, found {setting!r}")
        try:
            values[key.strip()] = ast.literal_eval(text.capitalize() if text in ("true", "false") else text)
        except (ValueError, SyntaxError):
            values[key.strip()] = text
    made: Planner = _given(make_planner, name, **values)
    return made


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made: {error.strerror}") from None


def _refuse_output(path: Path) -> None:
    """Find out before a long run, not after it, that its result cannot be kept."""
    import os

    _make_folder(path.parent)
    if path.is_dir():
        raise InputError(f"{path}: expected a file, found a folder")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written: the folder is read-only")


@contextmanager
def _stop(iterations: int | None, paths: int | None, seconds: float | None) -> Iterator["Stop"]:
    """Yield the stop rule of the flags and of Ctrl-C; a second Ctrl-C ends the program."""
    import signal
    import threading

    import skyverse as sky

    cancelled = threading.Event()
    stop: Stop = sky.Cancelled(cancelled)
    for rule, most in ((sky.MaxSeconds, seconds), (sky.MaxPaths, paths), (sky.MaxIterations, iterations)):
        if most is not None:
            stop = _given(rule, most) | stop
    if iterations is None and paths is None:
        stop = sky.MaxIterations(40) | stop

    def cancel(*_: object) -> None:
        cancelled.set()
        signal.signal(signal.SIGINT, before)
        print("skyverse: stopping, and keeping the best so far; Ctrl-C again to end at once", file=sys.stderr)

    before = signal.signal(signal.SIGINT, cancel)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _progress(scenario: "Scenario") -> Iterator["OnProgress | None"]:
    """Yield what draws a progress bar when a person watches; say when kernels are being compiled."""
    from skyverse.kernel import on_first_compilation

    def tell() -> None:
        print("skyverse: compiling kernels; only the first run takes this long ...", file=sys.stderr)

    on_first_compilation(tell)
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[best]}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("planning", total=len(scenario.uavs), best="")

        def on_progress(uav: int, progress: Any) -> None:
            if progress is None:
                bar.update(task, completed=uav + 1)
            else:
                best = f"iteration {progress.iterations}, best {progress.cost:.4g}"
                bar.update(task, description=scenario.uavs[uav].name, best=best)

        yield on_progress


def _violation(violation: Any) -> dict[str, Any]:
    return asdict(violation) | {"fault": violation.fault.value}


def _report(mission: "Mission", written: list[Path], as_json: bool) -> None:
    rows = []
    for uav, target, result, trajectory in zip(
        mission.scenario.uavs, mission.assignment, mission.results, mission.trajectories, strict=True
    ):
        if target is not None and result is not None:
            rows.append(
                {
                    "uav": uav.name,
                    "target": mission.scenario.targets[target].name,
                    "status": result.status.value,
                    "cost": result.cost if result.path.size else None,
                    "optimum": result.bound,
                    "gap": result.gap,
                    "seconds of flight": None if trajectory is None else trajectory.end - trajectory.start,
                    "generated paths": result.effort.generated_paths,
                }
            )
    if as_json:
        summary = {
            "mission": str(written[0]),
            "page": str(written[1]) if len(written) > 1 else None,
            "cost": mission.cost if mission.complete else None,
            "makespan": mission.makespan,
            "interrupted": mission.interrupted,
            "provenance": asdict(mission.provenance),
            "uavs": rows,
            "violations": [_violation(v) for v in mission.violations],
        }
        print(_json(summary), end="")
        return
    _table(list(rows[0]) if rows else ["uav"], [[_cell(k, v) for k, v in row.items()] for row in rows])
    print(f"total cost {mission.cost:.6g}, makespan {mission.makespan:.1f} s, seed {mission.provenance.seed}")
    if mission.interrupted:
        print("Interrupted: this is the best so far.")
    for result in {r.status: r for r in mission.results if r is not None and not r.status.reached}.values():
        print(f"{result.status.value}: {result.status.sentence}")
    for violation in mission.violations:
        print(f"{violation.fault.value}: {violation.message}")
    if not mission.violations:
        print("The referee found nothing wrong.")
    for path in written:
        print(path)


def _cell(key: str, value: object) -> str:
    if value is None:
        return "-"
    if key == "gap":
        return f"{value:.1%}"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _table(head: list[str], rows: list[list[str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(width=None if sys.stdout.isatty() else 140)
    table = Table(*head, box=None, header_style="bold", pad_edge=False)
    for row in rows:
        table.add_row(*row)
    console.print(table)
