"""Every tolerance of the referee, in order of size, each with its unit and the reason for its value.

The planners have tolerances of their own. The referee does not import them, so that it repeats none of their errors.
"""

import numpy as np

MACHINE_EPSILON = float(np.finfo(np.float64).eps)
"""Relative: the distance from 1 to the next larger number, 2.2e-16; every error bound is a multiple of it."""

TWO_ROUNDINGS = 4e-16
"""Relative: two roundings, such as those of a subtraction and a division, change a number by no more than this."""

JUMP_ROUNDING = 8 * MACHINE_EPSILON
"""Relative to a position, velocity, acceleration or instant: how far off rounding alone may make it at a knot."""

INSTANT_ROUNDING = 8 * MACHINE_EPSILON
"""Relative to the last instant: a zone counts as active for so much longer, so that no instant falls beside it."""

SUMS_ROUNDING = 64 * MACHINE_EPSILON
"""Relative to the largest number in them: more than a few sums and products of coordinates are off by rounding."""

ENERGY_ROUNDING = 1e-9
"""Share added to bounds on energy, more than the rounding of all their sums."""

WORST_INSTANT = 1e-9
"""Metres, or shares of a limit: the search for the worst instant ends when no other can be worse by more than this."""

YAW_RATE_ROUNDING = 1e-9
"""Rad/s: a yaw acceleration that changes the yaw rate by no more than this has lasted for as long as rounding makes it.

Turns that follow one another begin where others end, at instants that are equal but for rounding.
"""

NO_LENGTH = 1e-9
"""Metres: what is shorter has no direction, and nothing is divided by it."""

AREA_ROUNDING = 1e-9
"""Share, and square metres, by which areas of polygons that are equal may differ, as they are added up otherwise."""

OUTLINE_CONTACT = 1e-8
"""Metres: a chord this near to a polygon's outline counts as meeting it; more than rounding moves either of them."""

ON_AXIS = 1e-8
"""Metres: a UAV so near to the axis of its pad is on it; more than rounding moves either of them."""

LET_PASS = 1e-6
"""Metres, also m/s and m/s^2 at rest: what is wrong by no more than this is let pass, a micrometre being no danger.

All jumps of one trajectory together may make no more than this either.
"""

LIMIT_LET_PASS = 1e-6
"""Share of a UAV's limit that may be exceeded: planners reach limits exactly, and rounding adds to that."""

SAME_INSTANT = 1e-6
"""Seconds by which the instants of visits may differ from those of a flight, as both are rounded."""

SURELY_OUTSIDE = 2e-5
"""Metres: what is so far above or below a shape is outside it, however its coordinates are rounded."""

MOVER_SLACK = 1e-3
"""Metres by which boxes about UAVs and movers are compared too generously, more than all their roundings make."""

NEARER_AHEAD = 1e-3
"""Metres that a photo counts as farther aside for each metre along a strip, so that of equals the nearest is chosen."""

MORE_THAN_HALF = 4e-3
"""The share of the way between strips by which a gap ends beyond half of the way to the strip between them."""

LOOSE_POWER = 5e-3
"""Share by which the bound on the power on a part may exceed its mean before the part is cut in two."""

SHARE_SHORT = 5e-3
"""The share of pairs of neighbouring photos that may share less than asked, which sentences tell."""

AIRSPEED_BAND = 0.01
"""Share of an aeroplane's speed that its speed over ground may be off: this much every autopilot corrects at once."""

HASTE = 0.01
"""Share by which photos may follow each other sooner than the camera allows, as their instants are interpolated."""

LEAST_EVERY = 0.01
"""Metres from photo to photo, at least, so that nobody has to look at millions of them."""

APART = 0.05
"""How far beside a neighbour on another strip is at least, as a share of the width that is shown."""

STEEP_VIEW = 0.05
"""Least fall of an optical axis for each metre by which distances along it are counted: flatter views are of walls."""

EXEMPT_SLOPE = 1 + 1e-9
"""Metres of height a metre: ground up to this slope, 45 degrees and rounding, carries a UAV; steeper is a wall."""
