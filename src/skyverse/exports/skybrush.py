"""Light shows for Skybrush Studio for Blender, which imports zipped CSV with a file for each drone."""

import numpy as np

from skyverse.exports.sampling import SampledTrajectory

SHOW_HEADER = "Time_msec,X,Y,Z,R,G,B"
"""The header that Skybrush writes itself, and whose beginning its importer recognises."""
SHOW_COLOUR = "255,255,255"


def show_csv(flight: SampledTrajectory, end: float) -> str:
    """Return one drone's file: whole milliseconds, local metres, white light; it waits at its first and last place."""
    milliseconds = np.rint(flight.seconds * 1000).astype(np.int64)
    rows = [(int(t), p) for t, p in zip(milliseconds, flight.position.tolist(), strict=True)]
    if rows[0][0] > 0:
        rows.insert(0, (0, rows[0][1]))
    last = int(np.rint(end * 1000))
    if rows[-1][0] < last:
        rows.append((last, rows[-1][1]))
    unique = dict(rows)
    return (
        "\n".join([SHOW_HEADER, *(f"{t},{x:.4f},{y:.4f},{z:.4f},{SHOW_COLOUR}" for t, (x, y, z) in unique.items())])
        + "\n"
    )
