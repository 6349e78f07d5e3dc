"""The electrical power of a vehicle as a function of airspeed, climb and load, and the energy that a battery gives.

Hovering, a rotor pushes down air at the induced speed that makes its thrust; in forward flight more air comes by, and
less power pushes it (J. G. Leishman, "Principles of Helicopter Aerodynamics", 2nd edition, sections 2.2 and 2.14; Y.
Zeng, J. Xu, R. Zhang, "Energy Minimization for Wireless Communication with Rotary-Wing UAV", IEEE Transactions on
Wireless Communications, 2019, equation 12). Drag of blades takes a share that does not fall, and parasite drag grows
with the cube of the airspeed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from skyverse._typing import Floats

TRUSTED_SHARE = 0.9
"""Share of a battery's nominal energy that is counted on: the rest covers what the model of the power may be off."""
JOULES_OF_WATT_HOUR = 3600.0
INDUCED_SPEED = 5.5
"""m/s: the speed of the air below the rotors of a hovering multirotor, 4.1 m/s (27 g) to 6.8 m/s (15.5 kg)."""
INDUCED_SHARE = 0.45
"""Share of the hover power that pushes air down, where one point of a data sheet alone says nothing of it."""
WING_EFFICIENCY = 0.5
"""Of propeller and motor of an aeroplane that climbs, battery to air."""
LARGEST_MISS = 0.05
"""Share by which a curve may miss the points that it is made of."""
SLOWEST = 1e-3
"""m/s: the power of an aeroplane slower than this counts as that at this airspeed."""

_ANGLES = tuple(math.pi / 2 * k / 8 for k in range(9))
_SECTORS = tuple((math.cos(low), math.sin(high)) for low, high in pairwise(_ANGLES))
"""Of a gust, the largest shares sideways and upwards, by its angle above the horizon."""


@dataclass(frozen=True)
class Power:
    """The electrical power of a vehicle, W.

    With airspeed a, load n (thrust over weight, payload included), and climb rate c (no gain where it is negative):

    - multirotor: hover * (induced * g(a, n) + (1 - induced) * n^1.5) + drag * a^3 + n * weight * c, where g is the
      power that pushes air down as a share of that in a hover at n = 1;
    - aeroplane: drag * a^3 + lift * n^2 / a + n * weight * c / `WING_EFFICIENCY`;
    - from measured points: straight between them, times n^1.5, or n^2 for an aeroplane, and climb as above. Above the
      last airspeed it grows with the cube, as no part of it grows faster; below the first it stays, or grows as 1 / a.

    Attributes
    ----------
    hover
        W, of a multirotor without payload.
    induced
        Share of that which pushes air down.
    drag
        W s^3 / m^3.
    lift
        W m / s, of an aeroplane; 0 for a multirotor.
    weight
        N, without payload; 0 where it is not known, and where climbing costs nothing.
    laden
        Weight with payload over weight without.
    points
        Measured airspeeds, m/s, rising, and powers, W; empty where the rest says all.
    wings
        Whether this is an aeroplane.
    """

    hover: float = 0.0
    induced: float = 0.0
    drag: float = 0.0
    lift: float = 0.0
    weight: float = 0.0
    laden: float = 1.0
    points: tuple[tuple[float, float], ...] = ()
    wings: bool = False

    def at(self, airspeed: Floats, climb: Floats, load: Floats) -> Floats:
        """Return the power, W, at horizontal airspeeds, m/s, climb rates, m/s, and loads.

        It rises with climb and load. In airspeed, between two of `corners`, it has no maximum but at the ends: the rate
        at which pushing air takes less, over the airspeed, falls as that rises, and that of drag rises.
        """
        n = load * self.laden
        rising = n * np.maximum(climb, 0.0) * (self.weight / (WING_EFFICIENCY if self.wings else 1.0))
        if self.points:
            speeds, watts = (np.array(row) for row in zip(*self.points, strict=True))
            beyond = np.maximum(airspeed / max(speeds[-1], SLOWEST), 1.0)
            level = np.interp(airspeed, speeds, watts) * (beyond * beyond * beyond)
            if self.wings:
                return level * np.maximum(speeds[0] / np.maximum(airspeed, SLOWEST), 1.0) * (n * n) + rising
            return level * (n * np.sqrt(n)) + rising
        drag = self.drag * airspeed * airspeed * airspeed
        if self.wings:
            return drag + self.lift * n * n / np.maximum(airspeed, SLOWEST) + rising
        pushed = (1.0 - self.induced) * (n * np.sqrt(n))
        if self.induced:
            pushed = pushed + self.induced * _induced(airspeed, n)
        return self.hover * pushed + drag + rising

    def most(self, low: Floats, high: Floats, climb: Floats, load: Floats, gust: float = 0.0) -> Floats:
        """Return the largest power, W, at airspeeds from `low` to `high`, in gusts of up to `gust` m/s any way.

        What a gust has upwards it lacks sideways: its directions are cut into sectors, each of which counts with its
        largest share upwards and its largest share sideways.
        """
        found = []
        for aside, up in _SECTORS if gust > 0 else ((0.0, 0.0),):
            slow, fast = np.maximum(low - gust * aside, 0.0), high + gust * aside
            speeds = [slow, fast, *(np.clip(corner, slow, fast) for corner in self.corners)]
            found += [self.at(speed, climb + gust * up, load) for speed in speeds]
        return np.max(found, axis=0)

    @property
    def corners(self) -> Floats:
        """Airspeeds between which the power has no maximum but at the ends, m/s."""
        return np.array([speed for speed, _ in self.points])


def _induced(airspeed: Floats, load: Floats) -> Floats:
    """Return the power that pushes air down, as a share of that in a hover at a load of 1.

    Thrust times induced speed v, where v^2 (v^2 + a^2) is the fourth power of the induced speed of the hover.
    """
    ahead = airspeed * airspeed / (2.0 * INDUCED_SPEED**2)
    return load * load / np.sqrt(np.maximum(ahead + np.sqrt(load * load + ahead * ahead), np.finfo(float).tiny))


def multirotor_curve(hover: float, points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return `Power.induced` and `Power.drag` of the curve from a hover through points (m/s, W) of a data sheet.

    Two points fix both, one point the drag alone, and more are met as well as can be.

    Raises
    ------
    ValueError
        If no such curve meets all points to within `LARGEST_MISS`.
    """
    speeds, watts = (np.array(row, dtype=float) for row in zip(*points, strict=True))
    saved = (_induced(speeds, np.ones_like(speeds)) - 1.0) * (hover / watts)
    cube, lacking = speeds * speeds * speeds / watts, (watts - hover) / watts
    share, drag = _least_squares(saved, cube, lacking) if len(speeds) > 1 else (-1.0, -1.0)
    if not (0.0 <= share <= 1.0 and drag >= 0.0):
        drags = [(share, _least_square(cube, lacking - share * saved)) for share in (INDUCED_SHARE, 0.0, 1.0)]
        among = [*drags[: 1 if len(speeds) == 1 else 0], (_least_square(saved, lacking), 0.0), *drags[1:]]
        sound = [(share, drag) for share, drag in among if 0.0 <= share <= 1.0 and drag >= 0.0] or [(0.0, 0.0)]
        share, drag = min(sound, key=lambda one: float(np.sum((saved * one[0] + cube * one[1] - lacking) ** 2)))
    _require_met(points, watts * (1.0 + saved * share + cube * drag - lacking))
    return share, drag


def aeroplane_curve(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return `Power.drag` and `Power.lift` of the curve through two points (m/s, W), or as near as can be to more.

    Raises
    ------
    ValueError
        If there are fewer, or if no such curve meets all to within `LARGEST_MISS`.
    """
    if len(points) < 2 or min(speed for speed, _ in points) <= 0:
        raise ValueError(f"power of an aeroplane takes two points at airspeeds above 0, found {list(points)}")
    speeds, watts = (np.array(row, dtype=float) for row in zip(*points, strict=True))
    cube, inverse = speeds * speeds * speeds / watts, 1.0 / (speeds * watts)
    drag, lift = (max(one, 0.0) for one in _least_squares(cube, inverse, np.ones_like(watts)))
    _require_met(points, watts * (cube * drag + inverse * lift))
    return drag, lift


def _least_squares(one: Floats, two: Floats, sums: Floats) -> tuple[float, float]:
    """Return the factors of two columns whose sum is nearest to a third; below zero where there are many such."""
    a, b, d = float(np.sum(one * one)), float(np.sum(one * two)), float(np.sum(two * two))
    p, q, determinant = float(np.sum(one * sums)), float(np.sum(two * sums)), a * d - b * b
    if not determinant > 1e-12 * a * d:
        return -1.0, -1.0
    return (d * p - b * q) / determinant, (a * q - b * p) / determinant


def _least_square(column: Floats, sums: Floats) -> float:
    squares = float(np.sum(column * column))
    return float(np.sum(column * sums)) / squares if squares > 0 else 0.0


def _require_met(points: Sequence[tuple[float, float]], watts: Floats) -> None:
    for (speed, given), made in zip(points, watts, strict=True):
        if not abs(made - given) <= LARGEST_MISS * given:
            raise ValueError(
                f"power: no curve of momentum theory and drag meets {given:g} W at {speed:g} m/s, the nearest has "
                f"{made:.4g} W; measured points may be given as power_curve"
            )
