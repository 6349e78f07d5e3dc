"""Long work that ends early when it is asked to, and Ctrl-C, which asks for it, taken over for a while."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

Handler = Callable[[int, Any], Any] | signal.Handlers


_asked: ContextVar[Callable[[], bool]] = ContextVar("asked", default=lambda: False)


class Interrupted(KeyboardInterrupt):
    """The end of this work was asked for, and what was being made is not kept."""


@contextmanager
def interruptible(asked: Callable[[], bool]) -> Iterator[None]:
    """Let work within this context end early once a function tells that its end is `asked` for."""
    before = _asked.set(asked)
    try:
        yield
    finally:
        _asked.reset(before)


def interrupted() -> bool:
    """Tell whether the end of this work has been asked for: nothing more is to be begun, and what there is is kept."""
    return _asked.get()()


def raise_if_interrupted() -> None:
    """Raise `Interrupted` if the end of this work has been asked for; long loops without an answer of theirs do so."""
    if interrupted():
        raise Interrupted


@contextmanager
def on_interrupt(handler: Handler) -> Iterator[None]:
    """Let a handler take Ctrl-C within this context, if this is the main thread; no other thread may set a handler.

    Processes that are started while Ctrl-C is ignored ignore it from their first instant.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
