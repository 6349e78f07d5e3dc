"""All that is given: space, obstacles, UAVs and their limits, targets, objective. Frozen and validated.

SI units throughout; positions are local east-north-up metres, with an optional WGS84 origin in the frame.
"""

import math
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
NonNegative = Annotated[Number, Field(ge=0)]
Limit = Annotated[Number, Field(ge=1e-3, le=1e6)]
"""What no vehicle is outside of, so that durations and their powers stay numbers."""


def _listed(value: object) -> object:
    return value.tolist() if isinstance(value, np.ndarray) else value


Point = Annotated[tuple[Number, Number, Number], BeforeValidator(_listed)]
"""x, y, z in metres; a numpy array of three is accepted."""
Place = Annotated[tuple[Number, Number], BeforeValidator(_listed)]
"""x, y in metres."""
Steps = Annotated[tuple[Positive, Positive, Positive], BeforeValidator(_listed)]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _Extent(_Model):
    min: Point
    max: Point

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        for axis, low, high in zip("xyz", self.min, self.max, strict=True):
            if not low < high:
                raise ValueError(f"min must be below max on every axis, but {axis} runs from {low:g} to {high:g}")
        return self


class Bounds(_Extent):
    """The closed box that every UAV stays in: ``min`` and ``max`` corner, metres."""


class Box(_Extent):
    """An axis-aligned obstacle: ``min`` and ``max`` corner, metres."""

    shape: Literal["box"] = "box"


Obstacle = Box  # cylinder, polygon prism, terrain, voxels: further members of this union, told apart by `shape`


class Cylinder(_Model):
    """A vertical cylinder that may be flown through, at a risk.

    Attributes
    ----------
    centre
        x, y, metres.
    radius
        Metres.
    low, high
        Where it begins and ends, z in metres.
    risk
        What a metre flown inside adds to the path's risk.
    """

    shape: Literal["cylinder"] = "cylinder"
    centre: Place
    radius: Positive
    low: Number
    high: Number
    risk: Positive

    @model_validator(mode="after")
    def _upright(self) -> Self:
        _require_rise(self.low, self.high)
        return self


class Prism(_Model):
    """A vertical prism on a polygon, convex or not, that may be flown through, at a risk.

    Attributes
    ----------
    vertices
        x, y of three corners or more, metres, in either sense of rotation, the first not repeated. The outline must
        not touch or cross itself.
    low, high
        Where it begins and ends, z in metres.
    risk
        What a metre flown inside adds to the path's risk.
    """

    shape: Literal["prism"] = "prism"
    vertices: Annotated[tuple[Place, ...], BeforeValidator(_listed), Field(min_length=3)]
    low: Number
    high: Number
    risk: Positive

    @model_validator(mode="after")
    def _upright(self) -> Self:
        _require_rise(self.low, self.high)
        met = _edges_that_meet(np.array(self.vertices))
        if met is not None:
            raise ValueError(f"the outline must not touch or cross itself, but its edges {met[0]} and {met[1]} meet")
        return self


def _require_rise(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"low must be below high, but they are {low:g} and {high:g}")


def _edges_that_meet(corners: NDArray[np.float64]) -> tuple[int, int] | None:
    """Return two edges of an outline (n, 2) that meet, or ``None``; neighbours do where one folds back."""
    n = len(corners)
    following = np.roll(np.arange(n), -1)
    ahead = corners[following] - corners
    to = corners[None] - corners[:, None]
    side = np.sign(ahead[:, None, 0] * to[..., 1] - ahead[:, None, 1] * to[..., 0])  # (edge, corner)
    apart = side * side[:, following] > 0
    low, high = np.minimum(corners, corners[following]), np.maximum(corners, corners[following])
    meet = ~(apart | apart.T | np.any((low[:, None] > high[None]) | (high[:, None] < low[None]), axis=2))
    onward = np.sum(ahead * ahead[following], axis=1)
    each = np.arange(n)
    folds = (side[each, following[following]] == 0) & (onward <= 0)
    meet[each, each] = False
    meet[each, following] = meet[following, each] = folds
    first = np.argwhere(meet)
    return (int(first[0, 0]), int(first[0, 1])) if len(first) else None


Zone = Annotated[Cylinder | Prism, Field(discriminator="shape")]


class Lattice(_Model):
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


class AltitudeBand(_Model):
    """The altitudes to keep to, if it pays.

    Attributes
    ----------
    low, high
        z, metres.
    weight
        The price of a metre flown a metre outside the band.
    """

    low: Number
    high: Number
    weight: Positive

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low <= self.high:
            raise ValueError(f"low must not be above high, but they are {self.low:g} and {self.high:g}")
        return self


class ClimbLimit(_Model):
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


class Objective(_Model):
    """C = fuel * C_fuel + divergence * C_divergence + end * C_end (thesis, equation 3.4), and three soft terms.

    The soft terms are paid by every path; the exact searches on the lattice do not seek to lower them.

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


class FixedWing(_Model):
    """What an aeroplane can do that cannot hover: it flies on, level speed held, and turns and climbs gently.

    Attributes
    ----------
    speed
        Its horizontal speed, m/s.
    turn_radius
        Of its tightest turn seen from above, metres.
    climb
        The steepest climb or descent, degrees.
    """

    speed: Limit
    turn_radius: Limit
    climb: Annotated[Positive, Field(lt=90)]


class UAV(_Model):
    """One vehicle: where it starts and what it can do.

    Attributes
    ----------
    name
        Unique in its scenario; ``uav-1``, ``uav-2`` ... when left out.
    start
        Metres.
    max_speed, max_acceleration, max_jerk
        Limits on the norm of velocity (m/s), of acceleration (m/s^2) and of its rate of change (m/s^3).
    max_tilt
        Of a multirotor: degrees between its thrust and the vertical.
    thrust_to_weight
        Of a multirotor: the most thrust, as a multiple of its weight; above 1, or it cannot hover.
    separation
        The horizontal distance in metres that other UAVs at its height must keep; of two UAVs the larger counts.
    vertical_separation
        The vertical distance that those above and below must keep, metres, because of its downwash; twice `separation`
        when left out. Between the two an ellipsoid is kept free.
    priority
        Of two UAVs in conflict the one of lower priority gives way.
    fixed_wing
        Given for an aeroplane; then tilt and thrust are not limited, nor is it at rest at its start and target.
    """

    name: str = ""
    start: Point
    max_speed: Limit = 5.0
    max_acceleration: Limit = 3.5
    max_jerk: Limit = 50.0
    max_tilt: Annotated[Number, Field(ge=0.1, lt=90)] = 40.0
    thrust_to_weight: Annotated[Number, Field(gt=1, le=1e6)] = 2.5
    separation: NonNegative = 0.5
    vertical_separation: NonNegative | None = None
    priority: Annotated[int, Field(strict=True)] = 0
    fixed_wing: FixedWing | None = None

    @property
    def ellipsoid(self) -> tuple[float, float]:
        """Horizontal and vertical semi-axis of what it keeps free of others, metres."""
        vertical = 2.0 * self.separation if self.vertical_separation is None else self.vertical_separation
        return self.separation, vertical

    @model_validator(mode="after")
    def _within_limits(self) -> Self:
        if (self.separation == 0) != (self.ellipsoid[1] == 0):
            raise ValueError(
                "separation and vertical_separation must both be above 0, or both 0, but they are "
                f"{self.separation:g} and {self.ellipsoid[1]:g}"
            )
        wing = self.fixed_wing
        if wing is None:
            return self
        fastest = wing.speed / math.cos(math.radians(wing.climb))
        if fastest > self.max_speed:
            raise ValueError(
                f"fixed_wing.speed of {wing.speed:g} m/s at a climb of {wing.climb:g} degrees is {fastest:.4g} m/s, "
                f"above max_speed, {self.max_speed:g}"
            )
        turning = wing.speed**2 / wing.turn_radius
        if turning >= self.max_acceleration:
            raise ValueError(
                f"fixed_wing.turn_radius of {wing.turn_radius:g} m at {wing.speed:g} m/s takes {turning:.4g} m/s^2, "
                f"not below max_acceleration, {self.max_acceleration:g}"
            )
        return self


class Target(_Model):
    """A place that some UAV must reach: ``position`` in metres, and a name (``target-1`` ... when left out)."""

    name: str = ""
    position: Point


class Origin(_Model):
    """Where the local frame's zero lies: WGS84 degrees, and metres above mean sea level."""

    latitude: Annotated[Number, Field(ge=-90, le=90)]
    longitude: Annotated[Number, Field(ge=-180, le=180)]
    altitude: Number


class Frame(_Model):
    """How positions are to be read: local east-north-up metres (``"enu"``), at ``origin`` where one is known."""

    axes: Literal["enu"] = "enu"
    origin: Origin | None = None


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


class Scenario(_Model):
    """All that is given. Every field is validated; unknown keys are refused.

    Attributes
    ----------
    clearance
        Every obstacle is grown by this many metres on every side; what is inside a grown obstacle is unsafe.
    zones
        May be flown through, at a risk.
    objective
        The weights, or the name of a preset: ``"thesis"`` or ``"turns"``.
    """

    format: Literal["skyverse/scenario/1"] = "skyverse/scenario/1"
    name: Annotated[str, Field(min_length=1)]
    description: str = ""
    bounds: Bounds
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    clearance: NonNegative
    lattice: Lattice
    objective: Annotated[
        Objective, BeforeValidator(_preset, json_schema_input_type=Objective | Literal["thesis", "turns"])
    ] = PRESETS["thesis"]
    uavs: tuple[UAV, ...] = ()
    targets: tuple[Target, ...] = ()
    frame: Frame = Frame()

    @field_validator("uavs")
    @classmethod
    def _name_uavs(cls, uavs: tuple[UAV, ...]) -> tuple[UAV, ...]:
        return _named(uavs, "uav")

    @field_validator("targets")
    @classmethod
    def _name_targets(cls, targets: tuple[Target, ...]) -> tuple[Target, ...]:
        return _named(targets, "target")

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
