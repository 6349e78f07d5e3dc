"""The verb ``compare``: planners or replanning policies compared over scenarios and seeds."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from skyverse.cli.exit_codes import FOUND_WRONG
from skyverse.cli.given_scenario import refuse_unsafe
from skyverse.cli.option_types import SCENARIO, AsJson, Output, Whole
from skyverse.cli.outputs import DEFAULT_FOLDER, file_name, refuse_output
from skyverse.cli.report import json_text, say, table
from skyverse.cli.study import StudyOptions, study_of, study_summary, summary_lines
from skyverse.cli.watch import StudyWatch
from skyverse.errors import InputError
from skyverse.extras import missing_at_once, require_libraries
from skyverse.numerics.cores import cores

if TYPE_CHECKING:
    from skyverse.lab import Job, Study


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class StudyOutput:
    """What is written of a study.

    Parameters
    ----------
    output
        The folder for study, rows and report. By default out/NAME.
    export
        Write the rows to this file as well, .csv or .parquet, and the histories beside it.
    report
        Write the report as well.
    paper
        Write the report's figures also as PDF with embedded fonts, and its tables also as CSV and LaTeX.
    """

    output: Output = None
    export: Path | None = None
    report: bool = True
    paper: bool = False


_NOTHING_ASKED, _AS_USUAL = StudyOptions(), StudyOutput()


def compare(
    sources: Annotated[list[str], Parameter(name="scenarios", consume_multiple=True), SCENARIO],
    /,
    *,
    asked: StudyOptions = _NOTHING_ASKED,
    written: StudyOutput = _AS_USUAL,
    workers: Whole = None,
    dask: str | None = None,
    as_json: AsJson = False,
) -> int:
    """Compare planners over scenarios and seeds; go on where an earlier run of the same command was cut short.

    A study file that lists policies compares replanning in flight among movers instead.

    Examples: `skyverse compare study.yaml`, `skyverse compare map1 map2 --planner mvo --planner random-restart`,
    `skyverse compare map1 --planner mvo --set universes=50 --runs 100 --iterations 40 --export rows.csv`

    Exit code: 0 when the study is finished, 1 when the referee found anything wrong in a row or a run could not be
    done, 2 for bad input, 130 when interrupted: finished runs are kept, and the same command goes on.

    Parameters
    ----------
    sources
        One study file, or scenarios by name or file.
    workers
        Processes that share the runs; as many as there are cores by default.
    dask
        The address of a Dask scheduler whose workers share the runs instead.
    as_json
        Print the summary as JSON.
    """
    from skyverse.lab import LABELS, Rows, WorkerError, refuse_export, run_jobs, write_report

    with missing_at_once():
        if dask is not None:
            require_libraries("a cluster", "distributed", field="dask")
        if written.export is not None:
            refuse_export(written.export)
        study = study_of(sources, asked)
    jobs = list(study.jobs())
    for case in {job.case: None for job in jobs}:
        refuse_unsafe(case.label, case.scenario)
    folder = written.output if written.output is not None else DEFAULT_FOLDER / file_name(study.name)
    if written.export is not None:
        refuse_output(written.export)
    _keep_study(folder, study)
    watch = StudyWatch(folder, [] if dask else _workloads(jobs))
    try:
        with Rows(folder / "rows.sqlite") as rows:
            others = len(rows.done() - {job.key for job in jobs})
            if others:
                raise InputError(
                    f"{rows.path}: expected rows of this study only, found {others} of others, or made by code that "
                    "has been edited since; give another folder"
                )
            with watch.bar() as on_run:
                run_jobs(jobs, rows, workers=workers or cores(), dask=dask, on_run=on_run)
            summary = study_summary(rows)
            paths = [rows.path]
            if written.report:
                formats, figures = (
                    (("html", "md", "csv", "tex"), ("svg", "pdf")) if written.paper else (("html", "md"), ("svg",))
                )
                paths += write_report(rows, folder, title=study.name, formats=formats, figures=figures)
            if written.export is not None:
                paths += rows.export(written.export)
            columns = (*LABELS, "seed", "verdict")
            judged = rows.select(columns)
            wrong = [run for run in zip(*(judged[name].tolist() for name in columns), strict=True) if run[-1]]
    except KeyboardInterrupt:
        raise KeyboardInterrupt(watch.kept) from None
    except WorkerError as error:
        print(f"skyverse: {error}; {watch.kept}", file=sys.stderr)
        return FOUND_WRONG
    if as_json:
        verdicts = [dict(zip(columns, run, strict=True)) for run in wrong]
        print(json_text({"summary": summary, "violations": verdicts, "files": [str(path) for path in paths]}), end="")
    else:
        _print_summary(summary_lines(summary), wrong, paths)
    return FOUND_WRONG if wrong else 0


def _workloads(jobs: "list[Job]") -> list[str]:
    """Return what to compile before jobs are run: for planners, and for those that policies ask."""
    from skyverse.live import PlannerPolicy

    makers = {job.label: job.planner for job in jobs}.values()
    asked = {type(one.made() if isinstance(one, PlannerPolicy) else one).__name__ for one in makers}
    return sorted(asked | {"mission" for job in jobs if job.case.encounters is not None})


def _keep_study(folder: Path, study: "Study") -> None:
    """Write the study into its folder, and refuse a folder that holds another study."""
    from skyverse.lab import read_study, write_study

    file = folder / "study.yaml"
    refuse_output(file)
    if not file.is_file():
        write_study(study, file)
    elif read_study(file).seen_from(folder) != study.seen_from(folder):
        raise InputError(f"{folder}: expected the same study as before or a new folder, found another study in {file}")


def _print_summary(lines: list[dict[str, str]], wrong: list[tuple[Any, ...]], written: list[Path]) -> None:
    if len({line["budget"] for line in lines}) == 1:
        print(f"{lines[0]['budget']} for each UAV")
        for line in lines:
            del line["budget"]
    table(list(lines[0]), [list(line.values()) for line in lines])
    say(*(f"{', '.join(run)}, seed {seed}: {verdict}" for *run, seed, verdict in wrong))
    say(*(["The referee found nothing wrong."] if not wrong else []), *written)
