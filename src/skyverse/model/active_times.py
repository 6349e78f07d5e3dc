"""The times at which a zone is active: pairs of instants, in seconds into the mission, with open ends."""

import math
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field

from skyverse.model.quantities import Instant, listed

Spans = tuple[tuple[float | None, float | None], ...]


def _in_order(given: Spans) -> Spans:
    spans = active_spans(given)
    for k, (begin, end) in enumerate(spans):
        if not begin < end:
            raise ValueError(f"active[{k}] must end after it begins, but is from {begin:g} s to {end:g} s")
    for k, ((_, end), (begin, _)) in enumerate(pairwise(spans), 1):
        if not end < begin:
            raise ValueError(f"active[{k}] must begin after active[{k - 1}] has ended")
    return given


Span = Annotated[tuple[Instant | None, Instant | None], BeforeValidator(listed)]
ActiveTimes = Annotated[tuple[Span, ...], BeforeValidator(listed), Field(min_length=1), AfterValidator(_in_order)]
"""When a zone is active: pairs of instants, ``None`` where a pair has no beginning or no end; in order of time."""


def active_spans(active: Spans | None) -> tuple[tuple[float, float], ...]:
    """Return from when until when a zone is active, seconds, infinite where it is open; always without such times."""
    if active is None:
        return ((-math.inf, math.inf),)
    return tuple((-math.inf if a is None else a, math.inf if b is None else b) for a, b in active)


MAX_TOLD = 3
"""Active times that are told in one sentence; of more it is told how many there are."""


def told_spans(active: Spans) -> str:
    """Return when a zone is active, as sentences tell it: ``from 60 s to 120 s and from 300 s on``."""
    told = active if len(active) <= MAX_TOLD else active[: MAX_TOLD - 1]
    more = [f"{len(active) - len(told):,} times more"] if len(active) > len(told) else []
    return " and ".join([*map(_told, active_spans(told)), *more])


def _told(span: tuple[float, float]) -> str:
    begin, end = span
    if begin == -math.inf:
        return "at all times" if end == math.inf else f"until {end:g} s"
    return f"from {begin:g} s on" if end == math.inf else f"from {begin:g} s to {end:g} s"
