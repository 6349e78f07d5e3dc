"""What the judges of the referee return and say: violations, places where something is too close, positions."""

from dataclasses import dataclass
from typing import NamedTuple

from skyverse._typing import Floats
from skyverse.model.scenario import Scenario
from skyverse.model.verdict import Violation

GROUND_NUMBER = -1
"""The number that stands for the ground among the numbers of obstacles."""
CEILING_NUMBER = -2
"""The number that stands for the ceiling above the ground."""


class Judgement(NamedTuple):
    """What is wrong or could not be decided, and how often pieces of curves were cut in two to find that out."""

    violations: list[Violation]
    halvings: int = 0


def position_text(position: Floats) -> str:
    """Write a position (3,) in metres, such as ``(1, 2.5, 0.3)``."""
    return "(" + ", ".join(f"{value:.6g}" for value in position) + ")"


def position_tuple(position: Floats) -> tuple[float, float, float]:
    """Return a position (3,) as the tuple that a violation holds."""
    return float(position[0]), float(position[1]), float(position[2])


@dataclass(frozen=True, eq=False)
class Incursion:
    """The deepest place of a path or a curve inside a grown obstacle.

    Attributes
    ----------
    gap
        Metres from the place to the obstacle as it is given, negative inside: to a box along the axis where the
        distance is largest, to upright shapes horizontally or along z, to the ground along z.
    required
        Metres of clearance that must be kept from this obstacle.
    obstacle
        The obstacle's number in the scenario, `GROUND_NUMBER`, or `CEILING_NUMBER`.
    segment, fraction
        The index of the segment or piece, and how far along it, 0 to 1.
    position
        (3,) metres.
    """

    gap: float
    required: float
    obstacle: int
    segment: int
    fraction: float
    position: Floats

    @property
    def depth(self) -> float:
        """How deep inside the grown obstacle the place is, metres."""
        return self.required - self.gap

    def sentence(self, scenario: Scenario, subject: str, where: str) -> str:
        """Say that `subject` comes too close at the place that the words `where` tell."""
        at = f"position {position_text(self.position)}"
        if self.obstacle == CEILING_NUMBER:
            most = f"{scenario.max_height:.6g} m above ground"
            return f"{subject} is {-self.gap:.6g} m above the ceiling of {most} {where}, {at}."
        if self.obstacle == GROUND_NUMBER:
            height = f"only {self.gap:.6g} m above ground" if self.gap >= 0 else f"{-self.gap:.6g} m below ground"
            deed = f"is {height}"
        elif self.gap < 0:
            deed = f"is {-self.gap:.6g} m inside {obstacle_text(scenario, self.obstacle)}"
        else:
            deed = f"comes within {self.gap:.6g} m of {obstacle_text(scenario, self.obstacle)}"
        return f"{subject} {deed} {where}, {at}; {self.required:.6g} m are required."


def obstacle_text(scenario: Scenario, obstacle: int) -> str:
    """Name an obstacle by its number in the scenario, its kind and its name."""
    shape = scenario.obstacles[obstacle]
    words = [word for word in (shape.kind, shape.name and f"{shape.name!r}") if word]
    return f"obstacle {obstacle}" + (f" ({' '.join(words)})" if words else "")
