"""What is flown of a path: how far, how long, with how much energy, and how far from the path that was priced."""

from dataclasses import dataclass

AIR_DENSITY = 1.225
"""kg/m^3: the International Standard Atmosphere at sea level."""
DISC_LOADING = 7.0
"""kg of take-off mass on each m^2 of rotor disc, as camera multirotors have (DJI Matrice 300 7.1, Phantom 4 7.7)."""
EFFICIENCY = 0.45
"""Share of the electrical power that becomes ideal induced power: a figure of merit of 0.6, and 0.75 of the motors.

It makes a hover of 115 W/kg; a Phantom 4 (1.38 kg, 81 Wh, 28 minutes by its maker's data sheet) takes 126 W/kg.
"""


@dataclass(frozen=True)
class FlightSummary:
    """What one UAV flies, beside the price of its path.

    Attributes
    ----------
    length
        Metres that are flown.
    time
        Seconds from departure to arrival.
    energy
        Joules for each kilogram of take-off mass, by momentum theory (J. G. Leishman, "Principles of Helicopter
        Aerodynamics", 2nd edition, section 2.2): a specific thrust f, m/s^2, takes the power
        f sqrt(f `DISC_LOADING` / (2 `AIR_DENSITY`)) / `EFFICIENCY`, W/kg. Drag and gains in descent are left out.
        ``None`` for an aeroplane, of which no such figure is known.
    deviation
        Metres: no place that is flown is farther than this from the path that was priced, the result's.
    """

    length: float
    time: float
    energy: float | None
    deviation: float
