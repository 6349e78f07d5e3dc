"""Between the axes of scenarios, east-north-up, and those of MAVLink, north-east-down."""


def ned(enu):
    """Return north, east, down of east, north, up: positions, velocities and accelerations alike."""
    east, north, up = enu
    return north, east, -up


def enu(ned):
    """Return east, north, up of north, east, down."""
    north, east, down = ned
    return east, north, -down
