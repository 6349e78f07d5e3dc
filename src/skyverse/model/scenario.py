"""All that is given: space, obstacles, UAVs and their limits, targets, objective. Frozen and validated.

SI units throughout; positions are local east-north-up metres, with an optional WGS84 origin in the frame.
"""

from collections.abc import Iterable
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from skyverse.errors import InputError
from skyverse.model.quantities import Extent, Model, NonNegative, Number, Point, Positive, Steps
from skyverse.model.shapes import Obstacle, Terrain, Zone
from skyverse.model.uav import UAV


class Bounds(Extent):
    """The closed box that every UAV stays in: ``min`` and ``max`` corner, metres."""


class Lattice(Model):
    """The nodes that lattice planners walk on: ``bounds.min + i * step``, both ends included.

    Attributes
    ----------
    step
        Metres between neighbouring nodes, one number an axis.
    connectivity
        6 (along the axes) or 26 (diagonals too, without cutting corners).
    """

    step: Steps
    connectivity: Literal[6, 26] = 6


class AltitudeBand(Model):
    """The altitudes to keep to, if it pays.

    Attributes
    ----------
    low, high
        Metres: z, or above ground.
    weight
        The price of a metre flown a metre outside the band.
    above
        What `low` and `high` are counted from: ``"zero"``, the frame's, or ``"ground"``. It must be said where the
        scenario has a terrain.
    """

    low: Number
    high: Number
    weight: Positive
    above: Literal["zero", "ground"] | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.high:
            raise ValueError(f"low must not be above high, but they are {self.low:g} and {self.high:g}")
        return self


class ClimbLimit(Model):
    """The steepness to keep to, if it pays.

    Attributes
    ----------
    angle
        Degrees above or below the horizontal.
    weight
        The price of a metre flown one radian steeper than that.
    """

    angle: Annotated[Number, Field(ge=0, lt=90)]
    weight: Positive


class Objective(Model):
    """C = fuel * C_fuel + divergence * C_divergence + end * C_end (thesis, equation 3.4), and three soft terms.

    The soft terms are paid by every path; the exact searches on the lattice count them, move by move.

    Attributes
    ----------
    fuel
        Weight alpha_1 of the path itself, counted in `unit` (equation 3.2).
    divergence
        Weight alpha_2 of a turn: a non-zero cross product of consecutive steps.
    end
        Weight alpha_3 of a metre between the path's end and the goal (equation 3.3).
    unit
        ``"nodes"`` counts the path's nodes, start included, as the thesis does; ``"metres"`` its length.
    altitude
        Adds, for every metre flown, the metres outside a band of altitudes.
    risk
        Weight of the zones: of each zone's risk times the metres flown inside.
    climb
        Adds, for every metre flown, the radians above a climb angle.
    """

    fuel: NonNegative = 1.0
    divergence: NonNegative = 0.0
    end: NonNegative = 100.0
    unit: Literal["nodes", "metres"] = "nodes"
    altitude: AltitudeBand | None = None
    risk: NonNegative = 1.0
    climb: ClimbLimit | None = None

    @model_validator(mode="after")
    def _priced(self) -> Self:
        if self.fuel == 0:
            raise ValueError("fuel must be above 0, or a path that wanders for ever costs nothing")
        return self


PRESETS = {
    "thesis": Objective(fuel=1, divergence=0, end=100, unit="nodes"),
    "turns": Objective(fuel=1, divergence=0.3, end=80, unit="nodes"),
}
"""Objectives by name: the published experiments' weights, and a sibling study's that prices turns."""


def _preset(value: object) -> object:
    if isinstance(value, str):
        if value not in PRESETS:
            raise ValueError(f"no objective is called {value!r}; there are {', '.join(PRESETS)}, or give the weights")
        return PRESETS[value]
    return value


class Target(Model):
    """A place that some UAV must reach: ``position`` in metres, and a name (``target-1`` ... when left out)."""

    name: str = ""
    position: Point


GEOID = 150.0
"""Metres that mean sea level nowhere lies above or below the ellipsoid by; 85 and -107 are the most."""


def require_geoid(metres: float) -> None:
    """Raise `InputError` for a height of mean sea level above the ellipsoid that is nowhere on Earth."""
    if not -GEOID <= metres <= GEOID:
        raise InputError(f"expected metres from {-GEOID:g} to {GEOID:g}, found {metres:g}", field="geoid")


class Origin(Model):
    """Where the local frame's zero lies.

    Attributes
    ----------
    latitude, longitude
        WGS84 degrees.
    altitude
        Metres above mean sea level.
    geoid
        How far mean sea level lies above the WGS84 ellipsoid there, metres; where it is not known, heights above the
        ellipsoid cannot be written, and places are counted as if it were 0.
    """

    latitude: Annotated[Number, Field(ge=-90, le=90)]
    longitude: Annotated[Number, Field(ge=-180, le=180)]
    altitude: Number
    geoid: Annotated[Number, Field(ge=-GEOID, le=GEOID)] | None = None


class Frame(Model):
    """How positions are to be read: local east-north-up metres (``"enu"``), at ``origin`` where one is known."""

    axes: Literal["enu"] = "enu"
    origin: Origin | None = None


class Source(Model):
    """A file that a scenario was made of.

    Attributes
    ----------
    file
        Its name.
    gives
        What was taken from it, such as ``"terrain"``.
    licence
        Under which it may be used, and who is to be named.
    crs
        The coordinates that it was in, such as ``"EPSG:21781"``.
    """

    file: str
    gives: str
    licence: str = ""
    crs: str = ""


def _named(things: Iterable[Any], kind: str) -> tuple[Any, ...]:
    named = tuple(
        thing if thing.name else thing.model_copy(update={"name": f"{kind}-{number}"})
        for number, thing in enumerate(things, 1)
    )
    names = [thing.name for thing in named]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"names must differ, but {name!r} stands {names.count(name)} times")
    return named


class Scenario(Model):
    """All that is given. Every field is validated; unknown keys are refused.

    Attributes
    ----------
    clearance
        Every obstacle is grown by this many metres on every side; what is inside a grown obstacle is unsafe.
    zones
        May be flown through, at a risk.
    terrain
        The ground, which must cover the bounds.
    objective
        The weights, or the name of a preset: ``"thesis"`` or ``"turns"``.
    sources
        The files that it was made of.
    """

    format: Literal["skyverse/scenario/1"] = "skyverse/scenario/1"
    name: Annotated[str, Field(min_length=1)]
    description: str = ""
    bounds: Bounds
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    terrain: Terrain | None = None
    clearance: NonNegative
    lattice: Lattice
    objective: Annotated[
        Objective, BeforeValidator(_preset, json_schema_input_type=Objective | Literal["thesis", "turns"])
    ] = PRESETS["thesis"]
    uavs: tuple[UAV, ...] = ()
    targets: tuple[Target, ...] = ()
    frame: Frame = Frame()
    sources: tuple[Source, ...] = ()

    @property
    def ground_clearance(self) -> float:
        """How high above ground must be kept, metres: the terrain's clearance, or the scenario's where it has none."""
        own = None if self.terrain is None else self.terrain.clearance
        return self.clearance if own is None else own

    @field_validator("uavs")
    @classmethod
    def _name_uavs(cls, uavs: tuple[UAV, ...]) -> tuple[UAV, ...]:
        return _named(uavs, "uav")

    @field_validator("targets")
    @classmethod
    def _name_targets(cls, targets: tuple[Target, ...]) -> tuple[Target, ...]:
        return _named(targets, "target")

    @model_validator(mode="after")
    def _on_the_ground(self) -> Self:
        band = self.objective.altitude
        if self.terrain is None:
            if band is not None and band.above == "ground":
                raise ValueError("objective.altitude.above is 'ground', but the scenario has no terrain")
            return self
        if band is not None and band.above is None:
            raise ValueError(
                "objective.altitude.above: with a terrain, say what low and high are counted from, 'zero' or 'ground'"
            )
        first, last = self.terrain.extent
        for axis in range(2):
            low, high = self.bounds.min[axis], self.bounds.max[axis]
            if not (first[axis] <= low + 1e-6 and high <= last[axis] + 1e-6):
                raise ValueError(
                    f"the terrain must cover the bounds, but along {'xy'[axis]} it runs from {first[axis]:g} to "
                    f"{last[axis]:g} and they from {low:g} to {high:g}"
                )
        return self

    @model_validator(mode="after")
    def _lattice_fits(self) -> Self:
        # where turns are priced, the exact search tells apart by which axis a node was entered
        states = self.lattice.connectivity / 2 if self.objective.divergence > 0 else 1.0
        for axis, low, high, step in zip("xyz", self.bounds.min, self.bounds.max, self.lattice.step, strict=True):
            if step > (high - low) * (1 + 1e-9):  # as forgiving of rounding as the lattice that is made of it
                raise ValueError(f"lattice.step is {step:g} m along {axis}, longer than the bounds' {high - low:g} m")
            states *= (high - low) / step + 1
        if states > MAX_STATES:
            raise ValueError(
                f"lattice.step {self.lattice.step} makes {states:.3g} states to search, above the {MAX_STATES:.3g} "
                "that fit into memory; take longer steps or smaller bounds"
            )
        return self


MAX_STATES = 5e8
