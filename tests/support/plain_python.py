"""Kernels run as the plain Python that they are compiled from."""

from contextlib import contextmanager

from skyverse.numerics.compiling.numba_internals import Inner, Kernel


@contextmanager
def in_plain_python(report=None, chosen=None):
    """Run each kernel that Python calls, or those of them that are `chosen`, and all that it calls, as plain Python.

    `report` is told each kernel and its arguments before it runs, so that arrays can be copied before they are written
    to. What is not chosen runs compiled, and what it calls is not reported.
    """
    inside = False

    def call(kernel, *arguments):
        nonlocal inside
        if not inside and chosen is not None and not chosen(kernel):
            return super(Kernel, kernel).__call__(*arguments)
        if report is not None:
            report(kernel, arguments)
        before, inside = inside, True
        try:
            return kernel.py_func(*arguments)
        finally:
            inside = before

    plain = Inner.__call__
    for caller in (Kernel, Inner):
        type.__setattr__(caller, "__call__", call)
    try:
        yield
    finally:
        type.__delattr__(Kernel, "__call__")
        type.__setattr__(Inner, "__call__", plain)
