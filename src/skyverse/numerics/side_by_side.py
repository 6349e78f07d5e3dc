"""Makes many things side by side, by threads: kernels release Python's global lock."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from itertools import chain
from typing import TypeVar

from skyverse.errors import InputError
from skyverse.interrupt import interrupted
from skyverse.numerics.cores import cores

T = TypeVar("T")


def threads(workers: int | None) -> int:
    """Return how many threads are asked for, as many as there are cores for ``None``, or raise `InputError`."""
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"workers is a whole number from 1 on, not {workers!r}")
    return workers or cores()


def side_by_side(make: Callable[[int], T], count: int, workers: int) -> Iterator[T]:
    """Yield what is made of the numbers from 0 up to a count, in their order, by some threads, until interrupted.

    What is made of the first number is made alone, since that compiles the kernels that all others run. None is begun
    once this work is `interrupted`, unless a higher one has been begun before; what has been begun is finished. So what
    is yielded is made of the first numbers, without a gap, whichever thread comes first.
    """
    highest, turn = -1, threading.Lock()

    def made(number: int) -> tuple[T, ...]:
        nonlocal highest
        with turn:
            highest = highest if interrupted() else max(highest, number)
            begun = number <= highest
        return (make(number),) if begun else ()

    if workers == 1 or count < 2:
        yield from chain.from_iterable(map(made, range(count)))
        return
    yield from made(0)
    with ThreadPoolExecutor(workers) as pool:
        contexts = [copy_context() for _ in range(1, count)]
        yield from chain.from_iterable(pool.map(lambda own, number: own.run(made, number), contexts, range(1, count)))
