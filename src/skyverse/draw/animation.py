"""Animations of a flight, as a web page or a film, and figures of three of its instants."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skyverse.atomic import whole_file, write_text
from skyverse.draw.figures import Line, fleet_figure, write_stills
from skyverse.draw.map_figure import INK, ends, legend, line, map_figure, uav
from skyverse.draw.replanned_film import film_frames, replanned_frames, still
from skyverse.draw.replanned_scene import ReplannedScene
from skyverse.draw.scenes import Scene, flight_scene
from skyverse.draw.track import DrawnTrack
from skyverse.errors import InputError
from skyverse.extras import require_libraries
from skyverse.model.flight_record import Flight
from skyverse.model.replanned_flight import ReplannedFlight

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES_A_SECOND = 20
MAX_FILM_SECONDS = 15.0
"""The longest film, in seconds; longer flights are shown faster."""
FILM_SPEEDS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_FILM_DOTS = 100

Frame = NDArray[np.uint8]


def write_animation(flight: Flight | ReplannedFlight, path: Path | str) -> None:
    """Write an animation of `flight`: the planned motion thin, the flown motion thick.

    That of a flight that was replanned also shows where the replanner held movers to be, the range of sensors, what
    UAVs were committed to and their way out, and every answer on a time line; films show it from above and the side.

    Parameters
    ----------
    path
        ``.html`` for a page that works offline, ``.mp4`` or ``.gif`` for a film.

    Raises
    ------
    InputError
        For another suffix, if the file cannot be written, or if ``.mp4`` is asked for without imageio-ffmpeg.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix in (".html", ".htm"):
        from skyverse.draw.flight_page import flight_page
        from skyverse.draw.replanned_page import replanned_page

        write_text(path, replanned_page(flight) if isinstance(flight, ReplannedFlight) else flight_page(flight))
    elif suffix == ".mp4":
        _write_mp4(flight, path)
    elif suffix == ".gif":
        _write_gif(flight, path)
    else:
        raise InputError(f"{path}: an animation is written as .html, .mp4 or .gif, not as {suffix or 'no suffix'!r}")


def write_instants(flight: Flight | ReplannedFlight, folder: Path | str, *, suffix: str = ".png") -> list[Path]:
    """Write ``flown-initial``, ``flown-middle`` and ``flown-final``, figures of three instants; return their paths.

    Parameters
    ----------
    folder
        A folder that exists.
    suffix
        ``".png"``, ``".svg"`` or ``".pdf"``.

    Raises
    ------
    InputError
        For another suffix, or if the folder does not exist or a file cannot be written.
    """
    drawn = flight_scene(flight)
    draw = partial(still, ReplannedScene(flight)) if isinstance(flight, ReplannedFlight) else partial(instant, drawn)
    shares = (("initial", 0.0), ("middle", 0.5), ("final", 1.0))
    figures = [(f"flown-{name}", partial(draw, share * (drawn.makespan or 0.0))) for name, share in shares]
    return write_stills(figures, folder, suffix)


def instant(drawn: Scene, t: float) -> "Figure":
    """Return the figure of a flight's scene at `t` seconds: planned paths thin, flown motion until then thick."""
    heading = f"flown, t = {t:.1f} s"

    def lines(track: DrawnTrack) -> list[Line]:
        return [(track.path, 0.9, 0.55), (track.flown(t), 2.6, 1.0)]

    return fleet_figure(drawn, heading, lines, t=t, findings=drawn.findings)


def instants(drawn: Scene) -> tuple[list[float], int]:
    """Return the time of each frame of a film, in seconds, and how many times as fast as the flight the film is."""
    last = drawn.makespan or 0.0
    speed = next((speed for speed in FILM_SPEEDS if last / speed <= MAX_FILM_SECONDS), FILM_SPEEDS[-1])
    count = int(np.ceil(last * FRAMES_A_SECOND / speed - 1e-9)) + 1
    return np.minimum(np.arange(count) * speed / FRAMES_A_SECOND, last).tolist(), speed


def frames(drawn: Scene) -> Iterator[Frame]:
    """Return the frames of the film of a flight: moving marks over one still map; see `film_frames`."""
    times, speed = instants(drawn)
    fast = "" if speed == 1 else f", {speed} times as fast"
    figure, axes = map_figure(drawn, f"as planned (thin) and flown (thick){fast}")
    for track in drawn.tracks:
        line(axes, track, track.path, width=0.9, alpha=0.6)
        ends(axes, track)
    legend(figure, drawn)
    trails, marks = [], []
    for track in drawn.tracks:
        line(axes, track, np.array([track.start] * 2), width=2.6)
        trails.append(axes.lines[-1])
        uav(axes, track, np.array(track.start))
        marks.append(axes.lines[-1])
    below = 1 - 0.52 / figure.get_figheight()  # inches below the title
    clock = figure.text(0.03, below, "", fontsize=13, color=INK, va="top", family="monospace")

    def show(t: float) -> None:
        for track, trail, mark in zip(drawn.tracks, trails, marks, strict=True):
            trail.set_data_3d(*track.flown(t).T)
            mark.set_data_3d(*track.at(t)[:, None])
        clock.set_text(f"{t:6.2f} s / {drawn.makespan or 0.0:.2f} s")

    return film_frames(figure, [*trails, *marks, clock], show, times, _FILM_DOTS)


def _film(flight: Flight | ReplannedFlight) -> Iterator[Frame]:
    """Return the frames of the film of a flight."""
    if not isinstance(flight, ReplannedFlight):
        return frames(flight_scene(flight))
    drawn = ReplannedScene(flight)
    return replanned_frames(drawn, *instants(drawn.scene), _FILM_DOTS)


def _write_mp4(flight: Flight | ReplannedFlight, path: Path) -> None:
    require_libraries(str(path), "imageio_ffmpeg")
    from imageio_ffmpeg import write_frames

    film = _film(flight)
    first = next(film)
    height, width, _ = first.shape
    with whole_file(path) as beside:
        writer: Any = write_frames(str(beside), (width, height), fps=FRAMES_A_SECOND, macro_block_size=2, quality=7)
        writer.send(None)
        try:
            writer.send(first)
            for frame in film:
                writer.send(frame)
        finally:
            writer.close()


def _write_gif(flight: Flight | ReplannedFlight, path: Path) -> None:
    from PIL import Image

    pictures = [Image.fromarray(frame) for frame in _film(flight)]
    both = Image.new(
        "RGB", (pictures[0].width, 2 * pictures[0].height)
    )  # the first frame shows all that is planned, the last all that was flown
    both.paste(pictures[0], (0, 0))
    both.paste(pictures[-1], (0, pictures[0].height))
    palette = both.quantize(
        255, method=Image.Quantize.MAXCOVERAGE
    )  # one palette for all frames, so that the map does not flicker
    first, *others = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    with whole_file(path) as beside:
        first.save(beside, save_all=True, append_images=others, duration=1000 // FRAMES_A_SECOND, loop=0)
