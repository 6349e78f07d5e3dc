"""Threads that take their turns in an order that a test chooses, so that it sees what only some orders show."""

from concurrent.futures import Executor

import skyverse as sky


def in_turns(monkeypatch, order):
    """Let `side_by_side` begin its numbers, from the second on, in the order of these keys, one after another."""

    class Pool(Executor):
        def map(self, make, contexts, numbers):
            numbers = list(numbers)
            own = dict(zip(numbers, contexts, strict=True))
            made = {number: make(own[number], number) for number in sorted(numbers, key=order)}
            return map(made.get, numbers)

    monkeypatch.setattr("skyverse.numerics.side_by_side.ThreadPoolExecutor", lambda workers: Pool())


class CancelledAtLook(sky.Stop):
    """A rule that is cancelled from its n-th look on, counted from 1; never for ``None``."""

    def __init__(self, look):
        self.look, self.looks = look, 0

    def met(self, progress):
        return "Cancelled" if self.cancelled else None

    @property
    def cancelled(self):
        self.looks += 1
        return self.look is not None and self.looks >= self.look
