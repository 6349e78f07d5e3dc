"""Runs a study: in this process, on several processes or on a cluster; each row is stored as soon as its run ends."""

from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import closing
from pathlib import Path

from skyverse.errors import InputError
from skyverse.lab.code_versions import refuse_edited
from skyverse.lab.job import Job
from skyverse.lab.row import LABELS, Row
from skyverse.lab.rows import Rows
from skyverse.lab.study import Study
from skyverse.lab.workers import in_process, on_dask, on_workers

OnRun = Callable[[int, int], None]
"""Called with the number of finished runs and the number of all runs, at the start and after each run."""


def run_study(
    study: Study,
    path: str | Path,
    *,
    workers: int = 1,
    dask: str | None = None,
    on_run: OnRun | None = None,
) -> Rows:
    """Run those runs of a study that are not in the file yet.

    Parameters
    ----------
    study
        Scenarios x planners x budgets x seeds, or scenarios x movers x policies x seeds.
    path
        The SQLite file of the rows, which is created if it does not exist. Each row is stored as soon as its run ends,
        so that an interrupted study continues where it was.
    workers
        The number of processes that share the runs; 1 runs them in this process. The rows are the same except for their
        seconds. A script that asks for more than 1 must start under ``if __name__ == "__main__":``.
    dask
        The address of a Dask scheduler whose workers share the runs instead.
    on_run
        Called with the number of finished runs and the number of all runs, at the start and after each run.

    Returns
    -------
    Rows
        The open file.

    Raises
    ------
    InputError
        If the study cannot be run, or the file has rows of another study with the same labels.
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

    Rows are returned in the order in which their labels first appear in the jobs.

    Raises
    ------
    InputError
        If two jobs have the same labels and seed, or a row has them already but is the result of a different job, or
        the source of an own planner was edited after it was imported.
    """
    if workers < 1:
        raise InputError(f"expected a whole number from 1 on, found {workers!r}", field="workers")
    wanted = list(jobs)
    for job in {job.label: job for job in wanted}.values():
        refuse_edited(job.made_by)
    pending = _pending(wanted, rows)
    for place, kind in enumerate(LABELS):
        rows.expect(kind, dict.fromkeys(str(job.run[place]) for job in wanted))
    note = on_run or (lambda done, total: None)
    before, total = len(wanted) - len(pending), len(wanted)
    note(before, total)
    if not pending:
        return
    try:
        with closing(_finished(pending, workers, dask)) as finished:
            for done, (job, row) in enumerate(finished, before + 1):
                rows.add(row, job.key)
                note(done, total)
    except KeyboardInterrupt:  # it may have come between a row and its note
        note(len(rows.done() & {job.key for job in wanted}), total)
        raise


def _finished(jobs: Sequence[Job], workers: int, dask: str | None) -> Generator[tuple[Job, Row]]:
    if dask is not None:
        return on_dask(jobs, dask)
    return in_process(jobs) if workers == 1 else on_workers(jobs, workers)


def _pending(wanted: Sequence[Job], rows: Rows) -> list[Job]:
    seen: set[tuple[str | int, ...]] = set()
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
                f"{rows.path}: holds the run {job}, but of another {', '.join(LABELS)}, assignment or "
                "code; give another file or folder"
            )
        pending.append(job)
    return pending
