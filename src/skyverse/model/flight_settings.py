"""What the file of somebody's mission may not say: what flies it, from where, how fast and how high it returns."""

from dataclasses import dataclass
from typing import Literal

from skyverse.errors import require_choice, require_number, require_row


@dataclass(frozen=True)
class FlightSettings:
    """What the file of a mission may not say, and what flies it.

    Attributes
    ----------
    autopilot
        What flies the mission; when left out, the file's, or else ``"ardupilot"`` for QGC WPL files and ``"px4"`` for
        all others.
    home
        Where the vehicle takes off, latitude and longitude in degrees, in place of the file's.
    speed
        m/s until the mission says another; the file's, or else the autopilot's usual one, when left out.
    radius
        Metres from a waypoint at which the autopilot turns to the next, where the file leaves it open: `NAV_ACC_RAD` of
        PX4's multirotors, and `WPNAV_RADIUS` of Copter.
    altitude_radius
        Metres above or below a waypoint from which PX4 turns to the next, `NAV_MC_ALT_RAD`; 0.8 when left out.
    return_altitude
        Metres above home at which the vehicle returns; the file's, or else the autopilot's usual one, when left out.
    retraces
        Whether it returns along its mission in place of straight home: PX4 with `RTL_TYPE` 2, Copter by SmartRTL.
    """

    autopilot: Literal["px4", "ardupilot", "dji"] | None = None
    home: tuple[float, float] | None = None
    speed: float | None = None
    radius: float = 2.0
    altitude_radius: float | None = None
    return_altitude: float | None = None
    retraces: bool = False

    def __post_init__(self) -> None:
        if self.autopilot is not None:
            require_choice(self.autopilot, ("px4", "ardupilot", "dji"), "autopilot")
        if self.home is not None:
            require_row(self.home, 2, "home")
            for degrees, what, most in zip(self.home, ("latitude", "longitude"), (90.0, 180.0), strict=True):
                require_number(degrees, "home", f"a {what} in degrees", -most, most)
        if self.speed is not None:
            require_number(self.speed, "speed", "m/s", 0.2, 1000.0)
        require_number(self.radius, "radius", "metres", 0.0, 1000.0)
        if self.altitude_radius is not None:
            require_number(self.altitude_radius, "altitude_radius", "metres", 0.0, 1000.0)
        if self.return_altitude is not None:
            require_number(self.return_altitude, "return_altitude", "metres above home", 0.0, 10_000.0)
