"""Runs made by whichever process is asked for them: this one, several spawned ones, or those of a Dask cluster."""

import itertools
import multiprocessing
import re
import signal
import traceback
from collections import deque
from collections.abc import Generator, Sequence
from contextlib import suppress
from functools import lru_cache
from multiprocessing.connection import Connection, wait
from typing import Any

from skyverse.errors import InputError
from skyverse.extras import require_libraries
from skyverse.interrupt import on_interrupt
from skyverse.lab.code_versions import code_digest
from skyverse.lab.flown_run import fly_job, least_lengths, planned
from skyverse.lab.job import Job
from skyverse.lab.planned_run import Rates, plan_job, problems_of
from skyverse.lab.row import Row


class WorkerError(RuntimeError):
    """A run ended its process twice, or the connection to a cluster was lost."""


class RunMaker:
    """Makes runs one after another, and keeps what runs of the same scenario share."""

    def __init__(self) -> None:
        self._problems = lru_cache(maxsize=4)(problems_of)
        self._missions = lru_cache(maxsize=8)(planned)
        self._lengths = lru_cache(maxsize=8)(least_lengths)
        self._rates: Rates = {}

    def make(self, job: Job) -> Row:
        """Make a run and return its row."""
        if job.case.encounters is None:
            return plan_job(job, self._problems(job.case), self._rates)
        return fly_job(job, self._missions, self._lengths)

    def row_of(self, job: Job) -> Row:
        """Make a run, or raise `InputError` where this process has other code than the one that asks."""
        if code_digest(job.made_by) != job.code:
            raise InputError(f"{job}: expected the code of the process that asks, found another; start workers anew")
        return self.make(job)

    def warm_up(self, jobs: Sequence[Job]) -> None:
        """Make each run as short as it can be, so that all kernels which the jobs need are compiled and cached."""
        for job in jobs:
            with suppress(Exception):  # the run itself will raise the same error
                self.make(job.shortened())


def in_process(jobs: Sequence[Job]) -> Generator[tuple[Job, Row]]:
    """Run one job after another in this process; Ctrl-C takes effect after the run, a second Ctrl-C at once."""
    maker, interrupts = RunMaker(), list[int]()

    def catch(number: int, _: object) -> None:
        interrupts.append(number)
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    with on_interrupt(catch):  # an exception raised inside a kernel may crash the process
        for job in jobs:
            try:
                row = maker.make(job)
            except Exception as error:
                error.add_note(f"in the run {job}")
                raise
            yield job, row
            if interrupts:
                raise KeyboardInterrupt


def on_workers(jobs: Sequence[Job], workers: int) -> Generator[tuple[Job, Row]]:
    """Run jobs on spawned processes, each one job at a time, and yield each job with its row as it finishes.

    The first process compiles the kernels before the others begin. A process that dies is replaced, and its job is run
    once more. The processes end when the iteration ends, for whatever reason.

    Raises
    ------
    WorkerError
        If the second process of a job dies as well.
    """
    context = multiprocessing.get_context("spawn")  # a forked process would inherit locks that other threads hold
    staff = [_Worker(context) for _ in range(min(workers, len(jobs)))]
    waiting = deque((job, 1) for job in jobs)
    try:
        if staff:
            _prepare(staff[0], list({job.label: job for job in jobs}.values()))
        for worker in staff:
            worker.take(waiting)
        while busy := {worker.connection: worker for worker in staff if worker.job is not None}:
            for connection in wait(list(busy)):
                worker = busy[connection]
                job, attempt = worker.job, worker.attempt
                assert job is not None
                try:
                    row = worker.answer()
                except EOFError:
                    worker.process.join(30.0)  # its pipe is closed, so it ends, however busy the machine is
                    died = worker.end()
                    if attempt == 2:
                        raise WorkerError(f"the run {job} ended its process twice, with exit code {died}") from None
                    waiting.appendleft((job, attempt + 1))
                    staff[staff.index(worker)] = worker = _Worker(context)
                    worker.take(waiting)
                else:
                    worker.take(waiting)  # the process continues while the row is stored
                    yield job, row
    finally:
        for worker in staff:
            worker.end()


class _Worker:
    """A process, the pipe to it, and its current job."""

    def __init__(self, context: Any) -> None:
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with on_interrupt(signal.SIG_IGN):  # from its first instant, since this process handles Ctrl-C
            self.process.start()
        theirs.close()
        self.job: Job | None = None
        self.attempt = 0

    def take(self, waiting: deque[tuple[Job, int]]) -> None:
        """Take the next job, if there is one."""
        self.job = None
        if waiting:
            self.job, self.attempt = waiting.popleft()
            with suppress(OSError):  # the process has died, which `answer` reports
                self.connection.send(self.job)

    def answer(self) -> Any:
        """Return the answer of the process, or raise the exception that it sent; `EOFError` if it has died."""
        try:
            answer = self.connection.recv()
        except OSError:
            raise EOFError from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def end(self) -> int | None:
        """End the process; return its exit code if it had already ended by itself."""
        self.connection.close()
        died: int | None = self.process.exitcode
        self.process.kill()
        self.process.join()
        return died


def _prepare(worker: _Worker, jobs: list[Job]) -> None:
    """Let one process compile the kernels; if it dies, the runs themselves will report why."""
    with suppress(OSError, EOFError):
        worker.connection.send(jobs)
        worker.answer()


def _serve(connection: Connection) -> None:
    """Run the jobs that arrive through a pipe until its other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent process handles Ctrl-C
    maker = RunMaker()
    with suppress(EOFError, OSError):
        while True:
            task = connection.recv()
            answer: object = None
            try:
                if isinstance(task, list):
                    maker.warm_up(task)
                else:
                    answer = maker.row_of(task)
            except InputError as error:
                answer = error
            except Exception:
                answer = RuntimeError(f"in the run {task}:\n{traceback.format_exc()}")
            connection.send(answer)


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
    require_libraries("a cluster", "distributed", field="dask")
    from distributed import CancelledError, Client, KilledWorker, as_completed

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
                future = client.submit(_on_cluster, job, pure=False)
                given[future.key] = job
                running.add(future)

        try:
            client.submit(_warm_up, list({job.label: job for job in jobs}.values()), pure=False).result()
            hand_out(3 * max(1, sum(client.nthreads().values())))
            for future, row in running:
                job = given.pop(future.key)
                hand_out(1)
                yield job, row
        except KilledWorker as error:
            raise WorkerError(f"the run {given.get(error.task, 'before all')} ended one worker after another") from None
        except CancelledError:
            raise WorkerError(f"the cluster at {address} is gone") from None


def _warm_up(jobs: Sequence[Job]) -> None:
    RunMaker().warm_up(jobs)


def _on_cluster(job: Job) -> Row:
    """Make a run on a worker of a Dask cluster, which keeps its `RunMaker`."""
    from distributed import get_worker

    maker: RunMaker = vars(get_worker()).setdefault("skyverse_run_maker", RunMaker())
    return maker.row_of(job)
