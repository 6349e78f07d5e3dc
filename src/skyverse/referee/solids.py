"""What all kinds of grown shapes answer, whether boxes, spheres, cylinders, prisms or the ground."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Shape
from skyverse.referee.chord import distance_error
from skyverse.referee.tolerances import LET_PASS

ShapeKind = TypeVar("ShapeKind", bound=Shape)


@dataclass(frozen=True, eq=False)
class GrownSolids(ABC):
    """Shapes of one kind, grown by the clearance less what is let pass.

    Attributes
    ----------
    clearance
        Metres by which the shapes are grown.
    obstacle
        (m,) the number of the scenario's obstacle that each shape belongs to.
    """

    clearance: float
    obstacle: Indices

    @abstractmethod
    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners (m, 3), (m, 3) of boxes about the grown shapes, metres."""

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds (n,) on the errors of the depths of pieces and their parts, and of the hulls, metres.

        Parameters
        ----------
        b, error
            (n, degree + 1, 3) coefficients of the pieces, and (n,) bounds on their errors, metres.
        """
        return distance_error(b, error, float(np.abs(self.hulls()).max(initial=0.0)))

    @abstractmethod
    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return upper bounds (n,) on how deep parts get inside grown shapes, metres; below 0 where they stay outside.

        Of a single coefficient, which is a point, it is the depth itself, or any number below 0.

        Parameters
        ----------
        part
            (n, degree + 1, 3) coefficients of the parts, metres.
        which
            (n,) the shape that each part is compared with.
        """

    @abstractmethod
    def gap(self, position: Floats, which: int) -> float:
        """Return the distance from a position (3,) to a shape as it is given, metres; negative inside the shape."""


def vertical_depth(part: Floats, low: Floats, high: Floats) -> Floats:
    """Return upper bounds (n,) on how deep parts (n, degree + 1, 3) get between altitudes `low` and `high`, (n,)."""
    z = part[:, :, 2]
    return np.minimum(z.max(axis=1) - low, high - z.min(axis=1))


def grown(low: Floats, high: Floats, clearance: float) -> tuple[Floats, Floats]:
    """Return where intervals from low to high begin and end when the clearance grows them, less what is let pass.

    A wall thinner than what is let pass is still a wall: only a quarter of its thickness is let pass at each face.
    """
    low, high = low - clearance, high + clearance
    let_pass = np.minimum(LET_PASS, (high - low) / 4)
    return low + let_pass, high - let_pass


def shapes_of(scenario: Scenario, kind: type[ShapeKind]) -> tuple[Sequence[ShapeKind], Indices]:
    """Return the scenario's obstacles of one kind, and their numbers among all obstacles."""
    some = [(number, shape) for number, shape in enumerate(scenario.obstacles) if isinstance(shape, kind)]
    return [shape for _, shape in some], np.array([number for number, _ in some], dtype=np.intp)
