"""How kernels become machine code, and where the machine code is kept."""

from collections.abc import Callable

to_prepare: list[Callable[[], None]] = []
"""Called once, when a kernel is needed whose machine code was not kept, before it is compiled."""


def before_compiling(prepare: Callable[[], None]) -> None:
    """Call a function, and no other, once before the first kernel is compiled whose machine code was not kept."""
    to_prepare[:] = [prepare]
