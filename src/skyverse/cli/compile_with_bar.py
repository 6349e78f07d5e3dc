"""Kernels compiled before they are needed, and a bar that tells how far that is."""

import sys
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console


def compile_with_bar(workloads: Sequence[str]) -> None:
    """Compile the kernels that workloads need and that are not kept yet, on all cores; show how far that is."""
    from skyverse.numerics.compiling.together import compile_missing

    if not sys.stderr.isatty():
        told = -1

        def tell(done: int, total: int, kernel: str) -> None:
            nonlocal told
            if done * 4 // total > told:
                told = done * 4 // total
                print(f"skyverse: compiling kernels, this once: {told * 25} % done", file=sys.stderr, flush=True)

        compile_missing(workloads, tell)
        return
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    with Progress(*columns, TextColumn("{task.fields[kernel]}"), console=console(), transient=True) as bar:
        task = bar.add_task("compiling kernels, this once", total=None, kernel="")

        def draw(done: int, total: int, kernel: str) -> None:
            bar.update(task, completed=done, total=total, kernel=kernel.removeprefix("skyverse."))

        compile_missing(workloads, draw)


@cache
def console() -> "Console":
    """Return what all bars are drawn on, so that one can be drawn within another."""
    from rich.console import Console

    return Console(stderr=True)
