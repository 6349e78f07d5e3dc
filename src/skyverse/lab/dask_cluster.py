"""The runs of a study on a Dask cluster of one machine or many."""

import itertools
import re
from collections.abc import Generator, Sequence
from typing import Any

from skyverse.errors import InputError
from skyverse.lab.job import Job
from skyverse.lab.row import Row
from skyverse.lab.workers import WorkerError, row_of, warm_up


def on_dask(jobs: Sequence[Job], address: str) -> Generator[tuple[Job, Row]]:
    """Run jobs on the cluster whose scheduler is at `address`, and yield each job with its row as it finishes.

    The cluster holds at most three jobs for each of its threads at a time. Dask repeats a job whose worker dies.

    Raises
    ------
    InputError
        If distributed is not installed, or no scheduler answers.
    WorkerError
        If a job has ended one worker after another, or the connection to the cluster is lost.
    """
    try:
        from distributed import CancelledError, Client, KilledWorker, as_completed
    except ImportError:
        raise InputError('needs Dask: pip install "skyverse[dask]"', field="dask") from None
    if not re.fullmatch(r"(\w+://)?[^\s/]+:\d+", address):
        raise InputError(f"expected a scheduler's address, as in tcp://192.0.2.7:8786, found {address!r}", field="dask")
    try:
        client = Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"{address}: expected a scheduler's address, but none answers: {error}", field="dask"
        ) from None
    with client:
        waiting = iter(jobs)
        given: dict[Any, Job] = {}
        running = as_completed(loop=client.loop, with_results=True)

        def hand_out(count: int) -> None:
            for job in itertools.islice(waiting, count):
                future = client.submit(row_of, job, pure=False)
                given[future.key] = job
                running.add(future)

        try:
            client.submit(warm_up, list({job.label: job for job in jobs}.values()), pure=False).result()
            hand_out(3 * max(1, sum(client.nthreads().values())))
            for future, row in running:
                job = given.pop(future.key)
                hand_out(1)
                yield job, row
        except KilledWorker as error:
            raise WorkerError(f"the run {given.get(error.task, 'before all')} ended one worker after another") from None
        except CancelledError:
            raise WorkerError(f"the cluster at {address} is gone") from None
