"""Runs on this machine: in this process, or on several spawned ones."""

import multiprocessing
import signal
import threading
import traceback
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from typing import Any

from skyverse.errors import InputError
from skyverse.lab.row import Row
from skyverse.lab.run_job import Job, run_job, warm_up


class WorkerError(RuntimeError):
    """A run ended the process that it ran in, twice."""


def in_process(jobs: Sequence[Job]) -> Generator[tuple[Job, Row]]:
    """Run one job after another in this process; Ctrl-C takes effect after a run, a second one ends the program."""
    with _interrupts() as interrupts:
        for job in jobs:
            yield job, run_job(job)
            if interrupts:
                raise KeyboardInterrupt


@contextmanager
def _interrupts() -> Iterator[list[int]]:
    """Yield a list of the signals of Ctrl-C: an exception raised inside a kernel may crash the process."""
    caught: list[int] = []

    def catch(number: int, _: object) -> None:
        caught.append(number)
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    if threading.current_thread() is not threading.main_thread():
        yield caught
        return
    before = signal.signal(signal.SIGINT, catch)
    try:
        yield caught
    finally:
        signal.signal(signal.SIGINT, before)


def on_workers(jobs: Sequence[Job], workers: int) -> Generator[tuple[Job, Row]]:
    """Run jobs on as many spawned processes, and yield them as they finish; each holds one job at a time.

    The first process compiles what is not compiled yet, before the others begin. A process that dies is replaced and
    its job run once more. Whatever ends the iteration ends the processes.

    Raises
    ------
    WorkerError
        If a job's second process dies, too.
    """
    context = multiprocessing.get_context("spawn")  # a fork would inherit locks that others hold
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
                    worker.process.join(1.0)
                    died = worker.end()
                    if attempt == 2:
                        raise WorkerError(f"the run {job} ended its process twice, with exit code {died}") from None
                    waiting.appendleft((job, attempt + 1))
                    staff[staff.index(worker)] = worker = _Worker(context)
                    worker.take(waiting)
                else:
                    worker.take(waiting)  # it works on while the row is stored
                    yield job, row
    finally:
        for worker in staff:
            worker.end()


class _Worker:
    """A process, the pipe to it, and the job that it has."""

    def __init__(self, context: Any) -> None:
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs,), daemon=True)
        with _deaf():
            self.process.start()
        theirs.close()
        self.job: Job | None = None
        self.attempt = 0

    def take(self, waiting: deque[tuple[Job, int]]) -> None:
        """Take the next job, if there is one."""
        self.job = None
        if waiting:
            self.job, self.attempt = waiting.popleft()
            with suppress(OSError):  # it is dead, which its answer will tell
                self.connection.send(self.job)

    def answer(self) -> Any:
        """Return the answer, or raise what it raised; `EOFError` if the process has died."""
        try:
            answer = self.connection.recv()
        except OSError:
            raise EOFError from None
        if isinstance(answer, Exception):
            raise answer
        return answer

    def end(self) -> int | None:
        """End the process, and return its exit code if it has ended by itself."""
        self.connection.close()
        died: int | None = self.process.exitcode
        self.process.kill()
        self.process.join()
        return died


@contextmanager
def _deaf() -> Iterator[None]:
    """Let a process that is started here ignore Ctrl-C from its first instant: the parent decides what it means."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _prepare(worker: _Worker, jobs: list[Job]) -> None:
    """Let one process compile; if it dies of that, the runs will tell."""
    with suppress(OSError, EOFError):
        worker.connection.send(jobs)
        worker.answer()


def _serve(connection: Connection) -> None:
    """Do jobs until the other end of the pipe is closed, if only because that process is dead."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what Ctrl-C means
    with suppress(EOFError, OSError):
        while True:
            task = connection.recv()
            answer: Row | Exception | None = None
            try:
                if isinstance(task, Job):
                    answer = run_job(task)
                else:
                    warm_up(task)
            except InputError as error:
                answer = error
            except Exception:
                answer = RuntimeError(f"in the run {task}:\n{traceback.format_exc()}")
            connection.send(answer)
