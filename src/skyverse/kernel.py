"""How a hot function is compiled: one decorator, so that every kernel is cached, serial and free of the GIL."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile ``function`` with numba at its first call, keep it on disk; ``.py_func`` is the plain one.

    Kernels take arrays, scalars, NamedTuples of arrays and a numpy Generator, nothing else.
    With ``NUMBA_DISABLE_JIT=1`` the function itself comes back.
    """
    compiled: Callable[P, R] = numba.njit(cache=True, nogil=True)(function)
    return compiled


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
