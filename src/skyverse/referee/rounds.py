"""Cylinders and spheres: how deep a part of a curve may be inside, by its chord."""

from typing import NamedTuple

import numpy as np

from skyverse._typing import Floats, Indices
from skyverse.model.scenario import Scenario
from skyverse.model.shapes import Cylinder, Sphere
from skyverse.referee.boxes import TOLERANCE
from skyverse.referee.chord import chords, distance, distance_error


class Spheres(NamedTuple):
    """(m, 3) centres, (m,) radii, and radii of what is shut: grown by the clearance, less the tolerance."""

    centre: Floats
    radius: Floats
    shut: Floats
    obstacle: Indices

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of boxes about what is shut."""
        return self.centre - self.shut[:, None], self.centre + self.shut[:, None]

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths, and of hulls."""
        return distance_error(b, error, float(np.abs(self.hulls()).max(initial=0.0)))

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside; exactly, where they are straight."""
        chord = chords(part)
        deep: Floats = self.shut[which] - distance(self.centre[which], chord.a, chord.b) + chord.off
        return deep

    def gap(self, position: Floats, which: int) -> float:
        """Return the distance of one position to a sphere as given, negative inside; metres."""
        return float(np.linalg.norm(position - self.centre[which]) - self.radius[which])


class Cylinders(NamedTuple):
    """(m, 2) centres, (m,) radii and altitudes, and those of what is shut: grown, less the tolerance."""

    centre: Floats
    radius: Floats
    low: Floats
    high: Floats
    shut: Floats
    shut_low: Floats
    shut_high: Floats
    obstacle: Indices

    def hulls(self) -> tuple[Floats, Floats]:
        """Return the corners of boxes about what is shut."""
        level = self.shut[:, None]
        return (
            np.column_stack([self.centre - level, self.shut_low]),
            np.column_stack([self.centre + level, self.shut_high]),
        )

    def error(self, b: Floats, error: Floats) -> Floats:
        """Return bounds on the errors of depths, and of hulls."""
        return distance_error(b, error, float(np.abs(self.hulls()).max(initial=0.0)))

    def depth(self, part: Floats, which: Indices) -> Floats:
        """Return how deep parts may be inside: what is not, is off the axis, or below, or above."""
        chord = chords(part[:, :, :2])
        level = self.shut[which] - distance(self.centre[which], chord.a, chord.b) + chord.off
        z = part[:, :, 2]
        deep: Floats = np.minimum(
            level, np.minimum(z.max(axis=1) - self.shut_low[which], self.shut_high[which] - z.min(axis=1))
        )
        return deep

    def gap(self, position: Floats, which: int) -> float:
        """Return the level distance of one position to a cylinder as given, or that along z where it is more."""
        level = np.hypot(*(position[:2] - self.centre[which])) - self.radius[which]
        return float(max(level, self.low[which] - position[2], position[2] - self.high[which]))


def shut_spheres(scenario: Scenario) -> Spheres:
    """Return the scenario's spheres."""
    some = [(k, shape) for k, shape in enumerate(scenario.obstacles) if isinstance(shape, Sphere)]
    radius = np.array([shape.radius for _, shape in some])
    grown = radius + scenario.clearance
    centre = np.array([shape.centre for _, shape in some]).reshape(-1, 3)
    return Spheres(centre, radius, grown - np.minimum(TOLERANCE, grown / 4), _numbers(some))


def shut_cylinders(scenario: Scenario) -> Cylinders:
    """Return the scenario's cylinders."""
    some = [(k, shape) for k, shape in enumerate(scenario.obstacles) if isinstance(shape, Cylinder)]
    rows = np.array([(*shape.centre, shape.radius, shape.low, shape.high) for _, shape in some]).reshape(-1, 5)
    radius, low, high = rows[:, 2], rows[:, 3], rows[:, 4]
    grown, grown_low, grown_high = radius + scenario.clearance, low - scenario.clearance, high + scenario.clearance
    flat = np.minimum(TOLERANCE, (grown_high - grown_low) / 4)
    shut = grown - np.minimum(TOLERANCE, grown / 4)
    return Cylinders(rows[:, :2], radius, low, high, shut, grown_low + flat, grown_high - flat, _numbers(some))


def _numbers(some: list[tuple[int, Cylinder]] | list[tuple[int, Sphere]]) -> Indices:
    return np.array([k for k, _ in some], dtype=np.intp)
