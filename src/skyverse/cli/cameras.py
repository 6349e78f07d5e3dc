"""The verb ``cameras``: those that surveys know by name."""

from skyverse.cli.option_types import AsJson
from skyverse.cli.report import json_text, table
from skyverse.model.short_lines import told_gsd

DISTANCE = 100.0
"""Metres from which the ground sample distances are told."""


def cameras(*, as_json: AsJson = False) -> None:
    """List the cameras that `skyverse survey --camera` knows by name; docs/survey.md has their sources.

    Example: `skyverse cameras`

    Parameters
    ----------
    as_json
        Print JSON.
    """
    import skyverse as sky

    known = sky.CAMERAS.values()
    if as_json:
        print(json_text([one.model_dump() | {"gsd_at_100_m": one.gsd(DISTANCE)} for one in known]), end="")
        return
    rows = [
        [
            one.name,
            "{:g}x{:g}".format(*one.sensor),
            "{}x{}".format(*one.image),
            f"{one.focal:g} mm",
            told_gsd(one.gsd(DISTANCE)),
        ]
        for one in known
    ]
    table(("name", "sensor, mm", "pixels", "focal", "at 100 m"), rows)
