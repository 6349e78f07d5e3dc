"""How a hot function is compiled: one decorator, so that every kernel is cached, serial and free of the GIL."""

import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar

import numba
import numpy as np
from numba.core.registry import CPUDispatcher
from numpy.typing import ArrayLike, NDArray

from skyverse.numerics.compiling.numba_internals import Inner, Kernel

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile ``function`` with numba at its first call, keep it on disk; ``.py_func`` is the plain one.

    Kernels take arrays, scalars, NamedTuples of arrays and a numpy Generator, nothing else.
    With ``NUMBA_DISABLE_JIT=1`` the function itself comes back.
    """
    return _compiled(function, Kernel)


def query(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that makes no arrays, and so need not count who holds those that it is given.

    With many arrays in a NamedTuple the counting would take longer than a short query.
    """
    return _compiled(function, Kernel, _nrt=False)


def inner(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that only kernels call, without a way into it from Python, which takes long to compile."""
    return _compiled(function, Inner, no_cpython_wrapper=True)


def inner_query(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a `query` that only kernels call; see `inner`."""
    return _compiled(function, Inner, no_cpython_wrapper=True, _nrt=False)


def _compiled(function: Callable[P, R], caller: type[Kernel], **options: Any) -> Callable[P, R]:
    options |= {"nogil": True, "no_cfunc_wrapper": True}
    compiled: Callable[P, R] = numba.njit(**options)(function)
    if isinstance(compiled, CPUDispatcher):  # not where compilation is disabled
        compiled.__class__ = caller
        compiled.enable_caching()
    return compiled


@contextmanager
def in_plain_python(report: Callable[[Any, tuple[Any, ...]], None] | None = None) -> Iterator[None]:
    """Run each kernel that Python calls, and all that it calls, as plain Python; `report` kernels and arguments.

    Each kernel is reported before it runs, so that arrays can be copied before they are written to.
    """

    def call(kernel: Any, *arguments: Any) -> Any:
        if report is not None:
            report(kernel, arguments)
        return kernel.py_func(*arguments)

    before = Inner.__call__
    for caller in (Kernel, Inner):
        type.__setattr__(caller, "__call__", call)
    try:
        yield
    finally:
        type.__delattr__(Kernel, "__call__")
        type.__setattr__(Inner, "__call__", before)


def writable(numbers: ArrayLike) -> NDArray[np.float64]:
    """Return a copy of numbers as kernels take them: for an array that is read-only they would be compiled anew."""
    return np.array(numbers, dtype=np.float64, order="C")


def on_first_compilation(tell: Callable[[], None]) -> None:
    """Call `tell` once, when a kernel is compiled because no cached one is found."""
    from numba.core import event

    class Teller(event.Listener):
        def on_start(self, _: object) -> None:
            event.unregister("numba:compile", self)
            tell()

        def on_end(self, _: object) -> None:
            pass

    event.register("numba:compile", Teller())


class Stopwatch:
    """Wall-clock seconds since it was made, without those in which kernels were compiled."""

    def __init__(self) -> None:
        from numba.core import event

        self._compiling = event.TimingListener()
        self._began = time.perf_counter()
        event.register("numba:compile", self._compiling)
        weakref.finalize(self, event.unregister, "numba:compile", self._compiling)

    @property
    def seconds(self) -> float:
        """Seconds until now."""
        spent = self._compiling.duration if self._compiling.done else 0.0
        return time.perf_counter() - self._began - float(spent)
