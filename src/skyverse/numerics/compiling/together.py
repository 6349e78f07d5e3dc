"""Kernels compiled by as many processes as there are cores, each kernel by one of them, into the user's store."""

import heapq
import multiprocessing
import signal
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import suppress

from skyverse.interrupt import on_interrupt
from skyverse.numerics.compiling.kept_code import is_kept
from skyverse.numerics.compiling.listing import Listing, read_listing
from skyverse.numerics.cores import cores
from skyverse.numerics.kernel import PLAIN_NUMBA, PLAIN_PYTHON

OnCompiled = Callable[[int, int], None]
MIN_KERNELS = 8
"""Starting processes takes as long as compiling about so many."""
SECONDS_A_LINE = 6e-4
"""Processor time for a line of IR, on a 2.5 GHz Xeon."""


def compile_together(missing: Sequence[int], on_compiled: OnCompiled | None = None, *, workers: int = 0) -> None:
    """Compile kernels in several processes, those that are called before those that call them.

    Parameters
    ----------
    missing
        Positions in the list; see `missing_kernels`.
    on_compiled
        Called after each with how many are done, and how many are missing.
    workers
        How many processes; as many as there are cores by default.
    """
    listing, workers = read_listing(), workers or cores()
    context = multiprocessing.get_context("spawn")  # a fork would inherit locks that others hold
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        for done, _ in enumerate(_in_order(listing, missing, pool, workers), 1):
            if on_compiled is not None:
                on_compiled(done, len(missing))


def expected_seconds(missing: Iterable[int]) -> float:
    """Return about how long it takes to compile kernels of the list on all cores, if they are free."""
    kernels = read_listing().kernels
    return SECONDS_A_LINE * sum(kernels[i].ir_lines for i in missing) / cores()


def missing_kernels(workloads: Iterable[str]) -> list[int]:
    """Return the positions in the list of the kernels that workloads need and that the stores do not hold."""
    if PLAIN_PYTHON or PLAIN_NUMBA:
        return []
    listing, workloads = read_listing(), list(workloads)
    asked = range(len(listing.kernels)) if "all" in workloads else listing.needed_by(workloads)
    return [i for i in asked if not is_kept(*listing.kernels[i].load())]


def _in_order(listing: Listing, missing: Sequence[int], pool: ProcessPoolExecutor, workers: int) -> Iterable[int]:
    """Compile each kernel when those that it calls are done, first what most work waits for; yield what is done."""
    unkept = set(missing)
    waiting = {i: unkept & {*listing.kernels[i].calls} for i in missing}
    callers: dict[int, list[int]] = {i: [] for i in missing}
    for i, calls in waiting.items():
        for k in calls:
            callers[k].append(i)
    behind: dict[int, int] = {}  # lines of IR on the longest way from a kernel to the last of its callers
    for i in sorted(missing, reverse=True):
        behind[i] = listing.kernels[i].ir_lines + max((behind[k] for k in callers[i]), default=0)
    ready = [(-behind[i], i) for i, calls in waiting.items() if not calls]
    heapq.heapify(ready)
    running: dict[Future[None], int] = {}
    while ready or running:
        while ready and len(running) < workers:
            _, i = heapq.heappop(ready)
            with on_interrupt(signal.SIG_IGN):  # for the processes that this may start: Ctrl-C is for the first one
                running[pool.submit(_compile, i)] = i
        finished, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in finished:
            i = running.pop(future)
            future.result()
            yield i
            for k in callers[i]:
                waiting[k].discard(i)
                if not waiting[k]:
                    heapq.heappush(ready, (-behind[k], k))


def _compile(i: int) -> None:
    """Compile a kernel of the list, which keeps its machine code; one that was changed since is left to its callers."""
    from numba.core.errors import NumbaError

    kernel, types = read_listing().kernels[i].load()
    with suppress(NumbaError, TypeError):  # as numba says of another number of arguments
        kernel.compile(types)
