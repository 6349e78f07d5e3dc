"""Figures of the fleet, and figures written to files, for missions and flights alike."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from skyverse._typing import Floats
from skyverse.atomic import whole_file
from skyverse.draw.map_figure import ends, legend, line, map_figure, ring, uav
from skyverse.draw.scene import Scene, SceneFinding
from skyverse.draw.track import Track
from skyverse.errors import InputError, path_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 160


Line = tuple[Floats, float, float]
"""The points of a line, (n, 3), its width, and how opaque it is, from 0 to 1."""


def fleet_figure(
    drawn: Scene,
    heading: str,
    lines: Callable[[Track], Sequence[Line]],
    *,
    t: float | None = None,
    findings: Iterable[SceneFinding] = (),
) -> "Figure":
    """Return the figure of the map with the lines of each UAV, its start and target, and rings around findings.

    With `t`, seconds, the UAVs are drawn where they are then.
    """
    figure, axes = map_figure(drawn, heading)
    for track in drawn.tracks:
        for points, width, alpha in lines(track):
            line(axes, track, points, width=width, alpha=alpha)
        ends(axes, track)
        if t is not None:
            uav(axes, track, track.at(t))
    for finding in findings:
        ring(axes, finding)
    legend(figure, drawn)
    return figure


def write_stills(figures: Iterable[tuple[str, Callable[[], "Figure"]]], folder: Path | str, suffix: str) -> list[Path]:
    """Write figures, given by name, into a folder that exists, and return their paths.

    Raises
    ------
    InputError
        For a suffix other than ``".png"``, ``".svg"`` and ``".pdf"``, or if the folder does not exist or a file cannot
        be written.
    """
    if suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"figures are written as .png, .svg or .pdf, not as {suffix!r}", field="suffix")
    folder, written = path_of(folder, "folder"), []
    for name, draw in figures:
        path = folder / f"{name}{suffix}"
        with whole_file(path) as beside:
            draw().savefig(beside, dpi=DOTS_PER_INCH, facecolor="white")
        written.append(path)
    return written
