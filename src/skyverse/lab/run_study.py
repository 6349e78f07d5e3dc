"""Jobs to rows: what is not done yet is run, here, on several processes or on a cluster, and kept as it finishes."""

from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from pathlib import Path

from skyverse.errors import InputError
from skyverse.lab.row import Row
from skyverse.lab.rows import Rows
from skyverse.lab.run_job import Job
from skyverse.lab.study import Study
from skyverse.lab.workers import in_process, on_workers

OnRun = Callable[[int, int], None]
"""Called with the number of runs that are done and of all runs: at the start, and after each run."""


def run_study(
    study: Study,
    path: str | Path,
    *,
    workers: int = 1,
    dask: str | None = None,
    on_run: OnRun | None = None,
) -> Rows:
    """Run what a study asks for and is not in the file yet.

    Parameters
    ----------
    study
        Scenarios x planners x budgets x seeds.
    path
        The SQLite file of the rows, made if it is not there. Each row is kept as soon as its run is finished:
        a study that was cut short, by whatever, goes on where it was.
    workers
        How many processes share the runs; 1 runs them in this one. The rows are the same, their seconds apart.
        A script that asks for more must begin its work under ``if __name__ == "__main__":``.
    dask
        The address of a Dask scheduler, whose workers share the runs instead.
    on_run
        Called with the number of runs done and of all runs, at the start and after each run.

    Returns
    -------
    Rows
        The open file.

    Raises
    ------
    InputError
        If the study cannot be run, or the file belongs to another one.
    """
    rows = Rows(path)
    try:
        run_jobs(study.jobs(), rows, workers=workers, dask=dask, on_run=on_run)
    except BaseException:
        rows.close()
        raise
    return rows


def run_jobs(
    jobs: Iterable[Job],
    rows: Rows,
    *,
    workers: int = 1,
    dask: str | None = None,
    on_run: OnRun | None = None,
) -> None:
    """Run those jobs that have no row yet; see `run_study`.

    The rows are ordered as the labels first appear in the jobs.

    Raises
    ------
    InputError
        If two jobs have the same labels and seed, or a row has them already but was made of something else.
    """
    if workers < 1:
        raise InputError(f"expected a whole number from 1 on, found {workers!r}", field="workers")
    wanted = list(jobs)
    pending = _pending(wanted, rows)
    rows.expect("scenario", dict.fromkeys(job.case.label for job in wanted))
    rows.expect("planner", dict.fromkeys(job.label for job in wanted))
    rows.expect("budget", dict.fromkeys(job.budget for job in wanted))
    done, total = len(wanted) - len(pending), len(wanted)
    if on_run is not None:
        on_run(done, total)
    if not pending:
        return
    with closing(_finished(pending, workers, dask)) as finished:
        for job, row in finished:
            rows.add(row, job.key)
            done += 1
            if on_run is not None:
                on_run(done, total)


def _finished(jobs: Sequence[Job], workers: int, dask: str | None) -> Generator[tuple[Job, Row]]:
    if dask is not None:
        from skyverse.lab.dask_cluster import on_dask

        return on_dask(jobs, dask)
    return in_process(jobs) if workers == 1 else on_workers(jobs, workers)


def _pending(wanted: Sequence[Job], rows: Rows) -> list[Job]:
    seen: set[tuple[str, str, str, int]] = set()
    done = rows.done()
    pending = []
    for job in wanted:
        if job.run in seen:
            raise InputError(f"the run {job} is asked for twice; labels and seeds must differ")
        seen.add(job.run)
        if job.key in done:
            continue
        if done and rows.key(*job.run) is not None:
            raise InputError(
                f"{rows.path}: holds the run {job}, but of another scenario, planner, budget, assignment or "
                "version of skyverse; give another file or folder"
            )
        pending.append(job)
    return pending
