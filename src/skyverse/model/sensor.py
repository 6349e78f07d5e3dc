"""The sensor that each UAV of a fleet carries when its mission is replanned in flight."""

import math
from typing import Annotated

from pydantic import Field

from skyverse.model.quantities import Model, NonNegative, Positive

MAX_RATE = 1e3
"""Observations a second: no sensor makes more."""
MIN_RATE = 0.2
"""Observations a second: with fewer, a replanner takes its clock for one that leaps."""


class Sensor(Model):
    """A sensor that each UAV of a fleet carries; what one of them sees, all are told.

    Attributes
    ----------
    range
        Metres from a UAV within which movers and obstacles are seen; ``None`` if all are.
    rate
        Observations a second.
    delay
        Seconds after which an observation arrives.
    error
        Metres by which the position of a mover is off at most.
    """

    range: Positive | None = None
    rate: Annotated[Positive, Field(ge=MIN_RATE, le=MAX_RATE)] = 10.0
    delay: NonNegative = 0.0
    error: NonNegative = 0.0

    @property
    def reach(self) -> float:
        """Metres within which is seen, infinite if everything is."""
        return math.inf if self.range is None else self.range

    @property
    def sentence(self) -> str:
        """What the sensor sees, how often, how late and how exactly."""
        sees = "everything" if self.range is None else f"what is within {self.range:g} m"
        late = f", {self.delay:g} s late" if self.delay else ""
        off = f", with errors of up to {self.error:g} m" if self.error else ""
        return f"The sensors see {sees} {self.rate:g} times a second{late}{off}."
