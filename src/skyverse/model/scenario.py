"""All that is given: space, obstacles, UAVs and their limits, targets, and the objective; frozen and validated.

All units are SI; positions are local metres east, north and up, with an optional WGS84 origin in the frame.
"""

import math
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from skyverse.errors import shown
from skyverse.model.built_with import BuiltWith
from skyverse.model.frame import Frame, require_true_lengths
from skyverse.model.mover import Mover
from skyverse.model.quantities import Extent, Model, NonNegative, Number, Point, Positive, Steps, derived, digest_of
from skyverse.model.round_steps import ROUND, round_steps
from skyverse.model.shapes import LEAST_CLEARANCE, Obstacle, Terrain, Zone
from skyverse.model.short_lines import TIMES, as_lines, counted, told_point
from skyverse.model.survey import Survey
from skyverse.model.uav import UAV
from skyverse.model.wind import STILL_AIR, Wind, WindBall

MAX_STATES = 5e8
"""States of the exact search on a scenario's lattice, more of which would not fit into memory."""


class Bounds(Extent):
    """The closed box that every UAV stays in: ``min`` and ``max`` corner, metres."""


class Lattice(Model):
    """The nodes that lattice planners walk on: ``bounds.min + i * step``, both ends included.

    Attributes
    ----------
    step
        Metres between neighbouring nodes, one number for each axis.
    connectivity
        6 (moves along the axes) or 26 (diagonal moves too, which do not cut corners).
    """

    step: Steps
    connectivity: Literal[6, 26] = 6


def _lattice_of(given: dict[str, Any]) -> Lattice:
    """Return the lattice of a scenario that gives none."""
    bounds: Bounds = given["bounds"]
    return Lattice(step=round_steps([high - low for low, high in zip(bounds.min, bounds.max, strict=True)]))


class AltitudeBand(Model):
    """The altitudes that a path should keep to; what is flown outside the band has a price.

    Attributes
    ----------
    low, high
        Metres, counted from zero or from the ground; see `above`.
    weight
        The price of a metre flown a metre outside the band.
    above
        What `low` and `high` are counted from: ``"zero"``, the zero of the frame, or ``"ground"``. It must be given
        where the scenario has a terrain.
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
    """The steepness that a path should keep to; what is flown more steeply has a price.

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

    Every path pays the soft terms; exact searches on the lattice count them move by move.

    Attributes
    ----------
    fuel
        The weight alpha_1 of the path itself, counted in `unit` (equation 3.2).
    divergence
        The weight alpha_2 of a turn: two consecutive steps whose cross product is not zero.
    end
        The weight alpha_3 of a metre between the path's end and the goal (equation 3.3).
    unit
        ``"nodes"`` counts the path's nodes with the start, as the thesis does; ``"metres"`` takes its length.
    altitude
        Adds, for every metre flown, the metres that it is outside a band of altitudes.
    risk
        The weight of the zones' risk, which is each zone's own risk times the metres flown inside it.
    climb
        Adds, for every metre flown, the radians that it is steeper than a climb angle.
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
"""Objectives by name: the weights of the thesis's experiments, and those of a related study that prices turns."""


def _preset(value: object) -> object:
    if isinstance(value, str):
        if value not in PRESETS:
            known = ", ".join(PRESETS)
            raise ValueError(f"no objective is called {shown(value)}; there are {known}, or give the weights")
        return PRESETS[value]
    return value


class Target(Model):
    """A place that one UAV must reach.

    Attributes
    ----------
    name
        Unique in its scenario; ``target-1``, ``target-2`` and so on if it is left out.
    position
        x, y, z in metres.
    stay
        Seconds for which the UAV stays there.
    window
        Seconds into the mission, from the first to the second of which the stay must begin; ``None`` for any time.
    uavs
        The names of the UAVs that may go there; empty for all.
    demand
        What is brought there or fetched from there, kg; see `UAV.capacity`.
    heading, look_at
        Where a multirotor points its nose while it stays: degrees clockwise from north, or at x, y, z in metres.
    """

    name: str = ""
    position: Point
    stay: NonNegative = 0.0
    window: tuple[NonNegative, NonNegative] | None = None
    uavs: tuple[str, ...] = ()
    demand: NonNegative = 0.0
    heading: Annotated[Number, Field(ge=0, le=360)] | None = None
    look_at: Point | None = None

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if self.window is not None and self.window[0] > self.window[1]:
            raise ValueError("window must not end before it begins, but it is {:g} to {:g} s".format(*self.window))
        if self.look_at is not None and self.heading is not None:
            raise ValueError("look_at and heading both say where the nose points: give one of them")
        return self

    @property
    def is_plain(self) -> bool:
        """Whether nothing but its place is given."""
        return self == Target(name=self.name, position=self.position)


class Source(Model):
    """A file that a scenario was made from.

    Attributes
    ----------
    file
        The name of the file.
    gives
        What was taken from the file, such as ``"terrain"``.
    licence
        The licence under which the file may be used, and who must be named.
    crs
        The coordinate system of the file, such as ``"EPSG:21781"``.
    cautions
        What was left out of the file or taken for granted, in sentences that a pilot must heed.
    flown
        Of a mission, how far and how long it flies from the UAV's start to its target, metres and seconds.
    """

    file: str
    gives: str
    licence: str = ""
    crs: str = ""
    cautions: tuple[str, ...] = ()
    flown: tuple[Positive, Positive] | None = None


def _named(things: Iterable[Any], kind: str) -> tuple[Any, ...]:
    """Return things with a name for each one that has none, and refuse a name that occurs twice."""
    named = tuple(
        thing if thing.name else derived(thing, name=f"{kind}-{number}") for number, thing in enumerate(things, 1)
    )
    names = [thing.name for thing in named]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"names must differ, but {shown(name)} stands {names.count(name)} times")
    return named


class Scenario(Model):
    """All that is given. Every field is validated; unknown keys are refused.

    Attributes
    ----------
    clearance
        Metres that every UAV keeps from all obstacles, closed zones, movers and the ground; a place that is nearer, by
        more than a micrometre, is unsafe. With any of these it is at least `LEAST_CLEARANCE`, a millimetre.
    zones
        Shapes that may be flown through, at a risk, no faster than at some speed, or while they are not active.
    movers
        Obstacles that move in stated ways.
    terrain
        The ground, which must cover the bounds.
    wind
        In which all fly; ``None`` in still air.
    surveys
        What cameras are to see.
    max_height
        Metres above the terrain that no UAV may exceed; ``None`` where there is no such ceiling. It needs a terrain,
        and is counted from `Terrain.lowest` where the terrain has it.
    lattice
        Of at most two million nodes, a round step apart, if it is left out.
    objective
        The weights of the cost, or the name of a preset: ``"thesis"`` or ``"turns"``.
    sources
        The files that the scenario was made from.
    built_with
        The options of ``skyverse scenario build`` that it was made by, each a name and what was written after it.
    """

    format: Literal["skyverse/scenario/2"] = "skyverse/scenario/2"
    name: Annotated[str, Field(min_length=1)]
    description: str = ""
    bounds: Bounds
    obstacles: tuple[Obstacle, ...] = ()
    zones: tuple[Zone, ...] = ()
    movers: tuple[Mover, ...] = ()
    terrain: Terrain | None = None
    clearance: NonNegative
    max_height: Positive | None = None
    lattice: Lattice = Field(default_factory=_lattice_of)
    objective: Annotated[
        Objective, BeforeValidator(_preset, json_schema_input_type=Objective | Literal["thesis", "turns"])
    ] = PRESETS["thesis"]
    wind: Wind | None = None
    uavs: tuple[UAV, ...] = ()
    targets: tuple[Target, ...] = ()
    surveys: tuple[Survey, ...] = ()
    frame: Frame = Frame()
    sources: tuple[Source, ...] = ()
    built_with: BuiltWith = ()

    def __repr__(self) -> str:
        kinds = Counter(shape.shape for shape in self.obstacles)
        kinds_told = ", ".join(f"{count:,} {kind}" for kind, count in kinds.most_common()) if len(kinds) > 1 else ""
        things = [
            counted(len(self.uavs), "UAV"),
            counted(len(self.targets), "target"),
            counted(len(self.obstacles), "obstacle") + (f" ({kinds_told})" if kinds_told else ""),
        ]
        things += [counted(len(self.surveys), "survey")] if self.surveys else []
        things += [counted(len(self.zones), "zone")] if self.zones else []
        things += [counted(len(self.movers), "mover")] if self.movers else []
        things += ["over a terrain"] if self.terrain is not None else []
        low, high, step = self.bounds.min, self.bounds.max, self.lattice.step
        sizes = [b - a for a, b in zip(low, high, strict=True)]
        kept = [f"{self.clearance:g} m from obstacles"] if self.obstacles else []
        kept += [f"{self.ground_clearance:g} m or more above ground"] if self.terrain is not None else []
        kept += [] if self.max_height is None else [f"{self.max_height:g} m or less above ground"]
        nodes = math.prod(int(size / one + 1e-9) + 1 for size, one in zip(sizes, step, strict=True))
        origin = self.frame.origin
        return as_lines(
            f"Scenario {self.name!r}: {', '.join(things)}",
            self.description,
            f"bounds {TIMES.join(f'{size:,.6g}' for size in sizes)} m, from {told_point(low)} to {told_point(high)}",
            f"UAVs keep {', '.join(kept)}" if kept else "",
            "" if self.wind is None else f"wind of {self.wind.told}",
            f"lattice of {counted(nodes, 'node')}, {TIMES.join(f'{one:g}' for one in step)} m apart, "
            f"{self.lattice.connectivity}-connected",
            "" if origin is None else f"origin at latitude {origin.latitude:.6f}, longitude {origin.longitude:.6f}",
        )

    __str__ = __repr__

    @property
    def risky_zones(self) -> tuple[Zone, ...]:
        """The zones in which every metre has a price: none where the objective's weight of risks is 0."""
        return tuple(zone for zone in self.zones if zone.risk is not None and self.objective.risk > 0)

    @property
    def winds(self) -> WindBall:
        """All winds that may blow between the bounds, gusts included."""
        return STILL_AIR if self.wind is None else self.wind.between(self.bounds.min[2], self.bounds.max[2])

    @property
    def ground_clearance(self) -> float:
        """Metres above ground that must be kept: the terrain's clearance, or the scenario's where that has none."""
        own = None if self.terrain is None else self.terrain.clearance
        return self.clearance if own is None else own

    def end_place(self, uav: int, target: int | None) -> tuple[float, float, float] | None:
        """Return where a UAV ends whose last target is this one, metres; ``None`` for one that has no target."""
        if target is None:
            return None
        return self.uavs[uav].start if self.uavs[uav].end == "home" else self.targets[target].position

    @property
    def asks_for_tours(self) -> bool:
        """Whether UAVs return or survey, or a target asks for more than that one flies there and stays."""
        asked = bool(self.surveys) or any(uav.end == "home" for uav in self.uavs)
        return asked or not all(target.is_plain for target in self.targets)

    @property
    def digest(self) -> str:
        """The SHA-256 of all that is given, 64 hexadecimal digits: scenarios that differ have different ones."""
        return digest_of(self)

    @field_validator("uavs")
    @classmethod
    def _name_uavs(cls, uavs: tuple[UAV, ...]) -> tuple[UAV, ...]:
        return _named(uavs, "uav")

    @field_validator("targets")
    @classmethod
    def _name_targets(cls, targets: tuple[Target, ...]) -> tuple[Target, ...]:
        return _named(targets, "target")

    @field_validator("surveys")
    @classmethod
    def _name_surveys(cls, surveys: tuple[Survey, ...]) -> tuple[Survey, ...]:
        return _named(surveys, "survey")

    @field_validator("movers")
    @classmethod
    def _name_movers(cls, movers: tuple[Mover, ...]) -> tuple[Mover, ...]:
        return _named(movers, "mover")

    @model_validator(mode="after")
    def _keeps_clear(self) -> Self:
        kept_from = {"obstacles": self.obstacles, "zones": self.zones, "movers": self.movers, "terrain": self.terrain}
        found = [noun for noun, things in kept_from.items() if things]
        if found and self.clearance < LEAST_CLEARANCE:
            raise ValueError(
                f"clearance must be at least {LEAST_CLEARANCE:g} m with {' and '.join(found)}, but it is "
                f"{self.clearance:g}"
            )
        return self

    @model_validator(mode="after")
    def _by_known_uavs(self) -> Self:
        known = {uav.name for uav in self.uavs}
        for number, target in enumerate(self.targets):
            strange = [name for name in target.uavs if name not in known]
            if strange:
                raise ValueError(f"targets[{number}].uavs: there is no UAV of the name {shown(strange[0])}")
            for uav in self.uavs if target.demand > 0 else ():
                if uav.battery is not None and uav.capacity is None and uav.name in (target.uavs or known):
                    raise ValueError(
                        f"targets[{number}].demand: {uav.name} has a battery, which depends on what it carries, but "
                        "no capacity"
                    )
        return self

    @model_validator(mode="after")
    def _surveys_what_there_is(self) -> Self:
        uavs, obstacles = {uav.name for uav in self.uavs}, {one.name for one in self.obstacles}
        for number, survey in enumerate(self.surveys):
            for field, names, known, kind in (
                ("uavs", survey.uavs, uavs, "UAV"),
                ("structures", survey.structures, obstacles, "obstacle"),
            ):
                strange = [name for name in names if name not in known]
                if strange:
                    raise ValueError(f"surveys[{number}].{field}: there is no {kind} of the name {shown(strange[0])}")
            for own, uav in enumerate(self.uavs):
                if uav.end != "home" and uav.name in (survey.uavs or uavs):
                    raise ValueError(f"uavs[{own}].end: UAVs that fly surveys return; expected 'home', found 'target'")
        return self

    @model_validator(mode="after")
    def _on_a_true_map(self) -> Self:
        if self.frame.origin is not None:
            require_true_lengths(self.bounds.min, self.bounds.max, "bounds")
        return self

    @model_validator(mode="after")
    def _on_the_ground(self) -> Self:
        band = self.objective.altitude
        if self.terrain is None:
            if self.max_height is not None:
                raise ValueError("max_height is counted from the ground, but the scenario has no terrain")
            if band is not None and band.above == "ground":
                raise ValueError("objective.altitude.above is 'ground', but the scenario has no terrain")
            return self
        if band is not None and band.above is None:
            raise ValueError(
                "objective.altitude.above: with a terrain, say what low and high are counted from, 'zero' or 'ground'"
            )
        if self.max_height is not None and self.max_height <= self.ground_clearance:
            raise ValueError(
                f"max_height, {self.max_height:g} m, must be above the clearance from the ground, "
                f"{self.ground_clearance:g} m"
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
        # where turns have a price, the exact search has a state for each axis along which a node may be entered
        states = self.lattice.connectivity / 2 if self.objective.divergence > 0 else 1.0
        for axis, low, high, step in zip("xyz", self.bounds.min, self.bounds.max, self.lattice.step, strict=True):
            if step > (high - low) * (1 + 1e-9):  # the lattice lets the same rounding pass
                raise ValueError(f"lattice.step is {step:g} m along {axis}, longer than the bounds' {high - low:g} m")
            states *= (high - low) / step + 1
        if states > MAX_STATES:
            raise ValueError(
                f"lattice.step {self.lattice.step} makes {states:.3g} states to search, above the {MAX_STATES:.3g} "
                "that fit into memory; take longer steps or smaller bounds"
            )
        return self


SHORTEST = 0.1
"""Metres: where less height is left, no step is chosen for it."""
STEPS_IN_BAND = 2
"""Steps at least between the clearance from the ground and the ceiling, so that a way between them follows slopes."""


def upright_step(scenario: Scenario) -> float:
    """Return the longest round step, metres, of which `STEPS_IN_BAND` fit below the scenario's ceiling above ground.

    It is infinite where there is no ceiling, or no such step.
    """
    if scenario.max_height is None:
        return math.inf
    strays = max((uav.tracking_error.vertical for uav in scenario.uavs), default=0.0)
    room = scenario.max_height - scenario.ground_clearance - 2.0 * strays
    return max((step for step in ROUND if step >= SHORTEST and STEPS_IN_BAND * step <= room), default=math.inf)


def with_fitting_lattice(scenario: Scenario) -> Scenario:
    """Return a scenario whose lattice has no longer steps upright than fit below its ceiling above ground."""
    (x, y, z), upright = scenario.lattice.step, upright_step(scenario)
    if z <= upright:
        return scenario
    return scenario.model_copy(update={"lattice": scenario.lattice.model_copy(update={"step": (x, y, upright)})})
