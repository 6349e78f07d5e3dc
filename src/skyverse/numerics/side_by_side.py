"""Makes many things side by side, by threads: kernels release Python's global lock."""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from skyverse.errors import InputError
from skyverse.numerics.cores import cores

T = TypeVar("T")


def threads(workers: int | None) -> int:
    """Return how many threads are asked for, as many as there are cores for ``None``, or raise `InputError`."""
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"workers is a whole number from 1 on, not {workers!r}")
    return workers or cores()


def side_by_side(make: Callable[[int], T], count: int, workers: int) -> Iterator[T]:
    """Yield what is made of the numbers from 0 up to a count, in their order, by some threads.

    What is made of the first number is made alone, since that compiles the kernels that all others run.
    """
    if workers == 1 or count < 2:
        yield from map(make, range(count))
        return
    yield make(0)
    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(make, range(1, count))
