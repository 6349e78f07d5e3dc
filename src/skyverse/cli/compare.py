"""The verb ``compare``: planners compared over scenarios, budgets and seeds."""

import itertools
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from skyverse.cli.exit_codes import FOUND_WRONG, INTERRUPTED
from skyverse.cli.given_scenario import refuse_unsafe
from skyverse.cli.option_types import PLANNER, SCENARIO, AsJson, Output, Whole
from skyverse.cli.outputs import DEFAULT_FOLDER, file_name, refuse_output
from skyverse.cli.report import json_text, table
from skyverse.cli.study import study_of
from skyverse.cli.watch import StudyWatch
from skyverse.errors import InputError
from skyverse.numerics.cores import cores

if TYPE_CHECKING:
    from skyverse.lab.rows import Rows
    from skyverse.lab.study import Study

_JUDGED_COLUMNS = ("scenario", "planner", "budget", "seed", "verdict")

asked = Group("Study (instead of a study file)")


def compare(
    sources: Annotated[list[str], Parameter(name="scenarios", consume_multiple=True), SCENARIO],
    /,
    *,
    planner: Annotated[list[str] | None, PLANNER, Parameter(group=asked)] = None,
    settings: Annotated[list[str] | None, Parameter(name="--set", group=asked)] = None,
    runs: Annotated[Whole, Parameter(group=asked)] = None,
    seed: Annotated[Whole, Parameter(group=asked)] = None,
    paths: Annotated[Whole, Parameter(group=asked)] = None,
    nodes: Annotated[Whole, Parameter(group=asked)] = None,
    evaluations: Annotated[Whole, Parameter(group=asked)] = None,
    iterations: Annotated[Whole, Parameter(group=asked)] = None,
    seconds: Annotated[float | None, Parameter(group=asked)] = None,
    assignment: Annotated[Literal["path-cost", "euclidean", "identity"] | None, Parameter(group=asked)] = None,
    output: Output = None,
    workers: Whole = None,
    dask: str | None = None,
    export: Path | None = None,
    report: bool = True,
    as_json: AsJson = False,
) -> int:
    """Compare planners over scenarios and seeds; go on where an earlier run of the same command was cut short.

    Examples: `skyverse compare study.yaml`, `skyverse compare map1 map2 --planner mvo --planner random-restart`,
    `skyverse compare map1 --planner mvo --set universes=50 --runs 100 --iterations 40 --export rows.csv`

    Exit code: 0 when the study is finished, 1 when the referee found anything wrong in a row or a run could not be
    done, 2 for bad input, 130 when interrupted: finished runs are kept, and the same command goes on.

    Parameters
    ----------
    sources
        One study file, or scenarios by name or file.
    planner
        A planner to compare; repeat for more. By default mvo and random-restart.
    settings
        A setting of all planners, as in `--set universes=50`, or of one, as in `--set mvo.universes=50`; repeat for
        more.
    runs
        Seeds for each scenario and planner; 30 by default.
    seed
        The first seed; 0 by default.
    paths
        End each UAV's run after so many generated paths; 1000 by default.
    nodes
        End it after so many generated nodes instead.
    evaluations
        End it after so many objective values instead.
    iterations
        End it after so many iterations instead.
    seconds
        End it after about so many seconds instead.
    assignment
        What a UAV's way to a target costs when they are assigned; path-cost by default.
    output
        The folder for study, rows and report. By default out/NAME.
    workers
        Processes that share the runs; as many as there are cores by default.
    dask
        The address of a Dask scheduler whose workers share the runs instead.
    export
        Write the rows to this file as well, .csv or .parquet, and the histories beside it.
    report
        Write the report as well.
    as_json
        Print the summary as JSON.
    """
    from skyverse.lab.row_export import refuse_export
    from skyverse.lab.rows import Rows
    from skyverse.lab.run_study import run_jobs
    from skyverse.lab.workers import WorkerError

    study = study_of(
        sources,
        {
            "planner": planner,
            "set": settings,
            "runs": runs,
            "seed": seed,
            "paths": paths,
            "nodes": nodes,
            "evaluations": evaluations,
            "iterations": iterations,
            "seconds": seconds,
            "assignment": assignment,
        },
    )
    jobs = list(study.jobs())
    for case in {job.case: None for job in jobs}:
        refuse_unsafe(case.label, case.scenario)
    folder = output if output is not None else DEFAULT_FOLDER / file_name(study.name)
    if export is not None:
        refuse_export(export)
        refuse_output(export)
    _keep_study(folder, study)
    watch = StudyWatch(folder, [] if dask else sorted({type(job.planner).__name__ for job in jobs}))
    try:
        with Rows(folder / "rows.sqlite") as rows:
            others = len(rows.done() - {job.key for job in jobs})
            if others:
                raise InputError(
                    f"{rows.path}: expected rows of this study only, found {others} of others; give another folder"
                )
            with watch.bar() as on_run:
                run_jobs(jobs, rows, workers=workers or cores(), dask=dask, on_run=on_run)
            summary = summarise(rows)
            written = [rows.path]
            if report:
                from skyverse.lab.comparison_report import write_report

                written += write_report(rows, folder, title=study.name)
            if export is not None:
                written += rows.export(export)
            judged = rows.select(_JUDGED_COLUMNS)
            wrong = [run for run in zip(*(judged[name].tolist() for name in _JUDGED_COLUMNS), strict=True) if run[-1]]
    except KeyboardInterrupt:
        print(f"skyverse: interrupted; {watch.kept}", file=sys.stderr)
        return INTERRUPTED
    except WorkerError as error:
        print(f"skyverse: {error}; {watch.kept}", file=sys.stderr)
        return FOUND_WRONG
    _print_summary(summary, wrong, written, as_json)
    return FOUND_WRONG if wrong else 0


def _keep_study(folder: Path, study: "Study") -> None:
    """Write the study into its folder, and refuse a folder that holds another study."""
    from skyverse.lab.study import read_study, write_study

    file = folder / "study.yaml"
    refuse_output(file)
    if not file.is_file():
        write_study(study, file)
    elif read_study(file).seen_from(folder) != study.seen_from(folder):
        raise InputError(f"{folder}: expected the same study as before or a new folder, found another study in {file}")


def summarise(rows: "Rows") -> list[dict[str, Any]]:
    """Return a line for each planner on each scenario under each budget; costs are those of all runs."""
    import numpy as np

    columns = ("success", "cost", "gap", "generated_paths", "seconds")
    lines = []
    names: tuple[Literal["scenario", "budget", "planner"], ...] = ("scenario", "budget", "planner")
    for labels in itertools.product(*(rows.labels(name) for name in names)):
        group = dict(zip(names, labels, strict=True))
        found = rows.select(columns, **group)
        cost, gap, runs = found["cost"], found["gap"], len(found["cost"])
        if not runs:
            continue
        known, finite = gap[np.isfinite(gap)], bool(np.isfinite(cost).all())
        measured = {
            "runs": runs,
            "success": float(found["success"].mean()),
            "median": float(np.median(cost)) if finite else None,
            "mean": float(cost.mean()) if finite else None,
            "standard error": float(cost.std(ddof=1) / runs**0.5) if finite and runs > 1 else None,
            "gap": float(known.mean()) if len(known) else None,
            "generated paths": float(found["generated_paths"].mean()),
            "seconds": float(found["seconds"].mean()),
        }
        lines.append(group | measured)
    return lines


def _print_summary(
    summary: list[dict[str, Any]], wrong: list[tuple[Any, ...]], written: list[Path], as_json: bool
) -> None:
    if as_json:
        verdicts = [dict(zip(_JUDGED_COLUMNS, row, strict=True)) for row in wrong]
        print(json_text({"summary": summary, "violations": verdicts, "files": [str(path) for path in written]}), end="")
        return
    lines = [_line(line) for line in summary]
    if len({line["budget"] for line in lines}) == 1:
        print(f"{lines[0]['budget']} for each UAV")
        for line in lines:
            del line["budget"]
    table(list(lines[0]), [list(line.values()) for line in lines])
    for scenario, planner, budget, seed, verdict in wrong:
        print(f"{scenario}, {planner}, {budget}, seed {seed}: {verdict}")
    if not wrong:
        print("The referee found nothing wrong.")
    for path in written:
        print(path)


def _line(line: dict[str, Any]) -> dict[str, str]:
    mean, error, gap = line["mean"], line["standard error"], line["gap"]
    return {
        "scenario": line["scenario"],
        "budget": line["budget"],
        "planner": line["planner"],
        "success": f"{round(line['success'] * line['runs'])}/{line['runs']}",
        "median": "-" if line["median"] is None else f"{line['median']:.1f}",
        "mean": "-" if mean is None else f"{mean:.1f}" if error is None else f"{mean:.1f} ± {error:.1f}",
        "gap": "-" if gap is None else f"{gap:.1%}",
        "paths": f"{line['generated paths']:.0f}",
        "seconds": f"{line['seconds']:.3g}",
    }
