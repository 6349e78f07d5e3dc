"""What flies in a simulation and what it sees with, in what wind, and what else disturbs it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

from pydantic import ConfigDict, Field

from skyverse.errors import InputError, require_choice, require_flag, require_number, shown
from skyverse.model.quantities import Flag, Model, NonNegative, Positive, Real
from skyverse.model.uav import UAV
from skyverse.model.vehicle_profiles import VEHICLE_PROFILES
from skyverse.model.wind import MAX_WIND

SIMULATED_VEHICLES = ("thesis", "camera", "crazyflie", "hummingbird")
"""The multirotors that a simulation has models of."""
MAX_MISMATCH = 0.5
"""The largest share by which a vehicle may differ from its model; beyond, few could hover."""
MAX_NOISE = 10.0
"""Metres."""
MAX_DELAY = 1.0
"""Seconds."""


@dataclass(frozen=True)
class Conditions:
    """What flies in a simulation, in what wind, and what else disturbs it.

    Attributes
    ----------
    vehicle
        ``"thesis"``, ``"camera"``, ``"crazyflie"`` or ``"hummingbird"``, which flies in place of every multirotor. By
        default it is the vehicle that the mission was planned for where that is one of them, and otherwise the
        thesis's.
    wind
        The mean velocity of the air, (3,) m/s towards east, north and up; `wind_from` gives that of a wind as pilots
        tell it.
    noise
        The standard deviation, on each axis, of the white normal noise in what controllers measure: this many metres
        of position and m/s of velocity.
    gusts
        Whether the wind is gusty, by the Dryden model of MIL-F-8785C at low altitude. The intensity follows from the
        horizontal speed of the mean wind.
    mismatch
        The share, from 0 to 0.5, within which mass, thrust, drag and inertia of the vehicle that flies differ from what
        its controller believes; each is drawn uniformly and on its own, for every UAV and run.
    position_noise
        The standard deviation on each axis, metres, of a slowly drifting error of the measured position, as of GPS: a
        first-order Gauss-Markov process with a time constant of 1,100 s (Beard, McLain, "Small Unmanned Aircraft",
        2012, section 7.5).
    delay
        Seconds by which measured positions and velocities are late; rounded to hundredths.

    Raises
    ------
    InputError
        If a value is out of range, or gusts have no wind.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    vehicle: str | None = None
    wind: tuple[Real, Real, Real] = (0.0, 0.0, 0.0)
    noise: Real = 0.0
    gusts: Flag = False
    mismatch: Real = 0.0
    position_noise: Real = 0.0
    delay: Real = 0.0

    def __post_init__(self) -> None:
        if self.vehicle is not None:
            require_choice(self.vehicle, SIMULATED_VEHICLES, "vehicle")
        object.__setattr__(self, "wind", _velocity(self.wind))
        for name, unit, most in (
            ("noise", "metres", MAX_NOISE),
            ("mismatch", "a share", MAX_MISMATCH),
            ("position_noise", "metres", MAX_NOISE),
            ("delay", "seconds", MAX_DELAY),
        ):
            require_number(getattr(self, name), name, unit, 0.0, most)
        require_flag(self.gusts, "gusts")
        if self.gusts and not math.hypot(*self.wind[:2]):
            raise InputError("gusts need a wind, as their strength follows from its horizontal speed", field="gusts")

    @property
    def random(self) -> bool:
        """Whether any of it is drawn at random, so that a seed matters."""
        return self.gusts or max(self.noise, self.mismatch, self.position_noise) > 0

    @property
    def sentence(self) -> str:
        """What disturbs, in words."""
        told = [
            _told_wind(self.wind) if any(self.wind) else "no wind",
            f"noise {self.noise:g} m" if self.noise else "no noise",
            "gusts (Dryden)" if self.gusts else "",
            f"mismatch of {self.mismatch:.0%}" if self.mismatch else "",
            f"position noise of {self.position_noise:g} m" if self.position_noise else "",
            f"delay of {math.floor(1000 * self.delay + 0.5)} ms" if self.delay else "",
        ]
        return ", ".join(filter(None, told))

    def told(self, seed: int | None) -> str:
        """Return the same with the seed of what was drawn at random, if it is known."""
        return self.sentence if seed is None else f"{self.sentence}, seed {seed}"


def _velocity(wind: object) -> tuple[float, float, float]:
    """Return the velocity of a wind, (3,) m/s, or raise `InputError`."""
    try:
        east, north, up = (float(number) for number in wind)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        east = north = up = math.nan
    if isinstance(wind, str) or not all(abs(speed) <= MAX_WIND for speed in (east, north, up)):
        said = f"expected east, north and up in m/s, up to {MAX_WIND:g} each, found {shown(wind)}"
        raise InputError(f"{said}; wind_from(8, 270) is a wind of 8 m/s from the west", field="wind")
    return east, north, up


def _told_wind(wind: Sequence[float]) -> str:
    """Say where a wind goes, and where it comes from as pilots tell it."""
    east, north, up = wind
    said = f"wind {', '.join(f'{speed:.3g}' for speed in wind)} m/s"
    if up or not (east or north):
        return said
    return f"{said} ({math.hypot(east, north):.3g} m/s from {math.degrees(math.atan2(-east, -north)) % 360:.3g}°)"


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


DEFAULT_VEHICLE = "thesis"
"""Simulated where the fleet's vehicle has no model, where it has none, or where its UAVs have several."""


def simulated_vehicle(uavs: Sequence[UAV]) -> str:
    """Return the vehicle to simulate for the multirotors of a fleet: their own if it has a model."""
    models = {_model_of(name) for name in _planned_for(uavs)}
    return models.pop() or DEFAULT_VEHICLE if len(models) == 1 else DEFAULT_VEHICLE


def is_stand_in(vehicle: str, uavs: Sequence[UAV]) -> bool:
    """Tell whether a simulated vehicle flies in the place of another one, whose profile UAVs have."""
    return any(name and _model_of(name) != vehicle for name in _planned_for(uavs))


def simulated_vehicle_sentence(vehicle: str, uavs: Sequence[UAV]) -> str:
    """Say which vehicle is simulated, and for which other one the fleet was planned, if it was."""
    planned = _planned_for(uavs)
    named = [name for name in planned if name]
    if not named:
        return (
            f"Simulated: {vehicle}, in place of every multirotor; the mission names no vehicle. It is small and agile: "
            "a real vehicle may stray farther."
        )
    if all(_model_of(name) == vehicle for name in planned):
        return f"Simulated: {vehicle}, for which the mission was planned."
    others = [name or "UAVs without a vehicle" for name in planned if _model_of(name) != vehicle]
    why = [name for name in named if _model_of(name) is None]
    reason = f" ({', '.join(why)}: limits are known, but no mass, inertia and rotors to simulate)" if why else ""
    return (
        f"Simulated: {vehicle}, in place of every multirotor; the mission was planned for {', '.join(others)}{reason}."
    )


def _planned_for(uavs: Sequence[UAV]) -> list[str]:
    """Return the names of the multirotors' vehicles, each once; ``""`` for none."""
    return list(dict.fromkeys(uav.vehicle for uav in uavs if uav.fixed_wing is None))


def _model_of(name: str) -> str | None:
    return VEHICLE_PROFILES[name].simulated_as if name else None
