"""Figures of the fleet at an instant, and figures written to files, for missions and flights alike."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from skyverse._typing import Floats
from skyverse.atomic import whole_file
from skyverse.draw.map_figure import ends, legend, line, map_figure, ring, uav
from skyverse.draw.scene import Scene, SceneFinding
from skyverse.draw.track import Track

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 160


def moment(
    drawn: Scene, heading: str, t: float, thin: Callable[[Track], Floats], findings: Iterable[SceneFinding] = ()
) -> "Figure":
    """Return the figure of the fleet at `t` seconds: a `thin` line and its flight so far for each UAV."""
    figure, axes = map_figure(drawn, heading)
    for track in drawn.tracks:
        line(axes, track, thin(track), width=0.9, alpha=0.55)
        line(axes, track, track.flown(t), width=2.6)
        ends(axes, track)
        uav(axes, track, track.at(t))
    for finding in findings:
        ring(axes, finding)
    legend(figure, drawn)
    return figure


def write_stills(figures: Iterable[tuple[str, Callable[[], "Figure"]]], folder: Path | str, suffix: str) -> list[Path]:
    """Write figures, given by name, into a folder that exists, and return their paths.

    Raises
    ------
    ValueError
        For a suffix other than ``".png"``, ``".svg"`` and ``".pdf"``.
    InputError
        If the folder does not exist or a file cannot be written.
    """
    if suffix not in (".png", ".svg", ".pdf"):
        raise ValueError(f"figures are written as .png, .svg or .pdf, not as {suffix!r}")
    written = []
    for name, draw in figures:
        path = Path(folder) / f"{name}{suffix}"
        with whole_file(path) as beside:
            draw().savefig(beside, dpi=DOTS_PER_INCH, facecolor="white")
        written.append(path)
    return written
