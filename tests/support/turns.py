"""Threads that take their turns in an order that a test chooses, so that it sees what only some orders show."""

from concurrent.futures import Executor


def in_turns(monkeypatch, order):
    """Let `side_by_side` begin its numbers, from the second on, in the order of these keys, one after another."""

    class Pool(Executor):
        def map(self, make, numbers):
            numbers = list(numbers)
            made = {number: make(number) for number in sorted(numbers, key=order)}
            return map(made.get, numbers)

    monkeypatch.setattr("skyverse.numerics.side_by_side.ThreadPoolExecutor", lambda workers: Pool())
