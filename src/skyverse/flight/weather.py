"""What disturbs all flights of a mission, checked."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from skyverse.errors import InputError, require_number
from skyverse.model.disturbances import MAX_NOISE, Disturbances

MAX_WIND = 100.0
"""m/s."""


@dataclass(frozen=True)
class Weather:
    """What disturbs all flights of a mission.

    Attributes
    ----------
    wind
        The mean velocity of the air, m/s towards east, north and up.
    noise
        The standard deviation of white noise in what is measured: metres of position and m/s of velocity.
    others
        Gusts, mismatch, drift of positions and delay.
    """

    wind: tuple[float, float, float]
    noise: float
    others: Disturbances

    @property
    def random(self) -> bool:
        """Whether any of it is drawn at random, so that a seed matters."""
        return self.noise > 0 or self.others.gusts or self.others.mismatch > 0 or self.others.position_noise > 0


def weather_of(wind: Sequence[float], noise: float, disturbances: Disturbances | None) -> Weather:
    """Return what disturbs a mission, or raise `InputError`; the parameters are those of `fly`."""
    blown, others = _wind(wind), disturbances or Disturbances()
    require_number(noise, "noise", "metres", 0.0, MAX_NOISE)
    if others.gusts and not math.hypot(blown[0], blown[1]):
        raise InputError("gusts need a wind, as their strength follows from its horizontal speed", field="gusts")
    return Weather(blown, float(noise), others)


def _wind(wind: Sequence[float]) -> tuple[float, float, float]:
    try:
        numbers = [float(number) for number in wind]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
        raise InputError(f"expected east,north,up in m/s, or speed,degrees, found {wind!r}", field="wind")
    if max(map(abs, numbers if len(numbers) == 3 else numbers[:1])) > MAX_WIND:
        raise InputError(f"expected at most {MAX_WIND:g} m/s, found {wind!r}", field="wind")
    if len(numbers) == 2:
        speed, heading = numbers[0], math.radians(numbers[1])
        return round(speed * math.cos(heading), 12), round(speed * math.sin(heading), 12), 0.0
    return numbers[0], numbers[1], numbers[2]
