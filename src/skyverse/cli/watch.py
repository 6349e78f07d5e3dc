"""A long run watched: kernels compiled before it, its end by budget or Ctrl-C, its progress."""

import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from skyverse.cli.settings import given
from skyverse.cli.streams import below, plain
from skyverse.errors import InputError
from skyverse.interrupt import on_interrupt

if TYPE_CHECKING:
    from rich.console import Console

    from skyverse.lab import OnRun
    from skyverse.mission.plan_mission import OnProgress
    from skyverse.model.scenario import Scenario
    from skyverse.stop import Progress, Stop

SIGN_OF_LIFE_S = 10.0
"""Seconds between two lines that say in a pipe how far a long flight is."""


def console() -> "Console":
    """Return what all bars are drawn on, so that one can be drawn within another."""
    return _console_on(below(sys.stderr))


@lru_cache(1)
def _console_on(stream: TextIO) -> "Console":
    from rich.console import Console

    return Console(file=stream)


def compile_with_bar(workloads: Sequence[str]) -> None:
    """Compile the kernels that workloads need and that are not kept yet, on all cores; say how many and how long."""
    from skyverse.numerics.compiling.store import why_nothing_is_kept
    from skyverse.numerics.compiling.together import MIN_KERNELS, compile_together, expected_seconds, missing_kernels

    missing = missing_kernels(workloads)
    if len(missing) < MIN_KERNELS:
        return
    if why := why_nothing_is_kept():
        told = f"each time, as {why}; the environment variable SKYVERSE_CACHE can name another folder"
    else:
        told = f"once for each version; about {max(expected_seconds(missing), 1):.0f} s"
    print(f"skyverse: compiling {len(missing)} kernels, {told}", file=sys.stderr, flush=True)
    if why:
        return
    with on_interrupt(signal.default_int_handler), count_bar("compiling", "kernels") as draw:  # nothing is lost
        compile_together(missing, draw)


@contextmanager
def stop_rule(iterations: int | None, paths: int | None, seconds: float | None) -> Iterator["Stop"]:
    """Yield the stop rule of the options and of Ctrl-C; a second Ctrl-C ends the program."""
    import threading

    import skyverse as sky

    if seconds is not None and not seconds > 0:
        raise InputError(f"--seconds: expected a number above 0, found {seconds:g}")
    if seconds is not None and iterations is None and paths is None:
        raise InputError(
            "--seconds: expected --iterations or --paths with it, as schedules follow counts, found neither"
        )
    cancelled = threading.Event()
    stop: Stop = sky.Cancelled(cancelled)
    for rule, most in ((sky.MaxSeconds, seconds), (sky.MaxPaths, paths), (sky.MaxIterations, iterations)):
        if most is not None:
            stop = given(rule, most) | stop
    if iterations is None and paths is None:
        stop = sky.MaxIterations(40) | stop

    def cancel(*_: object) -> None:
        cancelled.set()
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # ends even a kernel at once
        print("skyverse: stopping, and keeping the best so far; Ctrl-C again to end at once", file=sys.stderr)

    before = signal.signal(signal.SIGINT, cancel)
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def progress_bar(scenario: "Scenario", stop: "Stop") -> Iterator["OnProgress | None"]:
    """Yield what draws a progress bar when a person watches."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    name, best = TextColumn("{task.description}", markup=False), TextColumn("{task.fields[best]}")
    with Bar(name, BarColumn(), best, TimeElapsedColumn(), console=console(), transient=True) as bar:
        task = bar.add_task("planning", total=len(scenario.uavs), best="")

        drawn = 0.0

        def on_progress(uav: int, progress: "Progress | None") -> None:
            nonlocal drawn
            if progress is None:
                bar.update(task, completed=uav + 1)
            elif time.monotonic() - drawn > 0.05:  # an iteration takes less time than drawing it
                drawn = time.monotonic()
                told = f"iteration {progress.iterations}, best {progress.cost:.4g}"
                done = uav + (stop.spent(progress) or 0.0)
                bar.update(task, completed=done, description=plain(scenario.uavs[uav].name), best=told)

        yield on_progress


@contextmanager
def count_bar(beginning: str, things: str) -> Iterator[Callable[[int, int], None] | None]:
    """Yield what draws how many of all things are done; where no person watches, it prints that now and then."""
    if not sys.stderr.isatty():
        told = time.monotonic()

        def tell(done: int, total: int) -> None:
            nonlocal told
            if time.monotonic() - told > SIGN_OF_LIFE_S:
                told = time.monotonic()
                print(f"skyverse: {beginning}, {done} of {total} {things}", file=sys.stderr, flush=True)

        yield tell
        return
    from rich.progress import Progress as Bar

    with Bar(console=console(), transient=True) as bar:
        task = bar.add_task(beginning, total=None)
        yield lambda done, total: bar.update(
            task, completed=done, total=total, description=f"{done} of {total} {things}"
        )


class StudyWatch:
    """Tells how far a study is: a bar when a person watches; and what is kept when it ends too early.

    Parameters
    ----------
    folder
        Where the study's rows are kept.
    workloads
        What to compile once it is known that there is something to run.
    """

    def __init__(self, folder: Path, workloads: Sequence[str]) -> None:
        self._folder, self._workloads = folder, workloads
        self._done = self._total = 0

    @contextmanager
    def bar(self) -> Iterator["OnRun"]:
        """Yield what must be called at the beginning and after each run."""
        with count_bar("comparing", "runs") as draw:

            def on_run(done: int, total: int) -> None:
                if self._total == 0 and done:
                    print(f"skyverse: {done} of {total} runs were done before", file=sys.stderr)
                if self._total == 0 and done < total and self._workloads:
                    compile_with_bar(self._workloads)
                if draw is not None:
                    draw(done, total)
                self._done, self._total = done, total

            yield on_run

    @property
    def kept(self) -> str:
        """What an early end leaves behind."""
        return f"{self._done} of {self._total} runs are kept in {self._folder}, and the same command goes on"
