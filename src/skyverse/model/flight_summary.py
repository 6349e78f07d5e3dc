"""What is flown of a path: how far, how long, with how much energy, and how far from the path that was priced."""

from dataclasses import dataclass

from skyverse.model.quantities import Real


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
        Joules that a multirotor takes, estimated from the power at which it hovers, `UAV.hover_power`. By momentum
        theory, the power grows with the thrust to the power of 1.5 (J. G. Leishman, "Principles of Helicopter
        Aerodynamics", 2nd edition, section 2.2). Drag is left out, and so is what forward flight and descent save.
        ``None`` for an aeroplane, and where the power is not known.
    deviation
        Metres: no place that is flown is farther than this from the path that was priced, the result's.
    """

    length: Real
    time: Real
    energy: Real | None
    deviation: Real
