"""A table (CSV) of all UAVs' samples, with latitude, longitude, altitude and local metres."""

import csv
import io

import numpy as np

from skyverse.exports.global_positions import AltitudeReference, global_positions
from skyverse.exports.sampling import SampledTrajectory
from skyverse.model.scenario import Scenario


def geo_csv_text(scenario: Scenario, flights: list[SampledTrajectory], reference: AltitudeReference) -> str:
    """Return a ``.geo.csv`` text."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["uav", "t", "latitude", "longitude", f"altitude_{reference}_m", "x", "y", "z"])
    for flight in flights:
        at = global_positions(scenario, flight.uav, flight.position, reference)
        table = np.column_stack([flight.seconds, at.latitude, at.longitude, at.altitude, flight.position])
        for t, latitude, longitude, up, *local in table.tolist():
            row = [f"{t:.6f}", f"{latitude:.9f}", f"{longitude:.9f}", f"{up:.4f}", *(f"{v:.4f}" for v in local)]
            writer.writerow([flight.name, *row])
    return out.getvalue()
