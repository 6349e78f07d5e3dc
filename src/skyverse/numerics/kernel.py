"""How a hot function is compiled: one decorator, so that every kernel is cached, serial and free of the GIL."""

import os
import time
import weakref
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numpy as np
from numba.core import config
from numpy.typing import ArrayLike, NDArray

VERIFIED = ((0, 64), (0, 65), (0, 66), (0, 67), (0, 68))  # versions of numba that `numba_internals` was tried with
PLAIN_PYTHON = bool(vars(config)["DISABLE_JIT"])
PLAIN_NUMBA = numba.version_info.short not in VERIFIED or bool(os.environ.get("SKYVERSE_PLAIN_NUMBA"))
P = ParamSpec("P")
R = TypeVar("R")
Class = TypeVar("Class", bound=type)


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile ``function`` with numba at its first call, keep it on disk; ``.py_func`` is the plain one.

    Kernels take arrays, scalars, NamedTuples of arrays and a numpy Generator, nothing else.
    With ``NUMBA_DISABLE_JIT=1`` the function itself comes back. With a version of numba that is not in `VERIFIED`, or
    ``SKYVERSE_PLAIN_NUMBA=1``, numba compiles in its ordinary way, which takes longer.
    """
    return _compiled(function)


def query(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that makes no arrays, and so need not count who holds those that it is given.

    With many arrays in a NamedTuple the counting would take longer than a short query.
    """
    return _compiled(function, counts_references=False)


def inner(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that only kernels call, without a way into it from Python, which takes long to compile."""
    return _compiled(function, is_inner=True)


def inner_query(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a `query` that only kernels call; see `inner`."""
    return _compiled(function, is_inner=True, counts_references=False)


def by_reference(cls: Class) -> Class:
    """Let kernels take arguments of this NamedTuple by reference: fields are read, the whole is not unpacked."""
    if not PLAIN_NUMBA:
        from skyverse.numerics.compiling.references import add_class

        add_class(cls)
    return cls


def _compiled(function: Callable[P, R], *, is_inner: bool = False, counts_references: bool = True) -> Callable[P, R]:
    # numba would let a kernel that sets nothing count references only if its first caller does
    options: dict[str, Any] = {"_nrt": counts_references}
    if PLAIN_PYTHON:
        return function
    if PLAIN_NUMBA:
        try:
            return cast(Callable[P, R], numba.njit(nogil=True, cache=True, **options)(function))
        except RuntimeError:  # neither the installation nor the home folder can be written to
            return cast(Callable[P, R], numba.njit(nogil=True, **options)(function))
    from skyverse.numerics.compiling.numba_internals import Inner, Kernel

    return cast(Callable[P, R], (Inner if is_inner else Kernel)(function, **options))


def writable(numbers: ArrayLike) -> NDArray[np.float64]:
    """Return a copy of numbers as kernels take them: for an array that is read-only they would be compiled anew."""
    return np.array(numbers, dtype=np.float64, order="C")


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
