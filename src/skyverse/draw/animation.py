"""Planned and flown motion: as a page, as a film, as figures of three instants."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skyverse.atomic import whole_file, write_text
from skyverse.draw.as_flown import as_flown
from skyverse.draw.scene import Scene
from skyverse.draw.stage import INK, ends, legend, line, stage, uav
from skyverse.draw.stills import moment, write_stills
from skyverse.errors import InputError
from skyverse.model.flight_record import Flight

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRAMES_A_SECOND = 20
LONGEST = 15.0
"""Seconds of a film; longer flights are shown faster."""
SPEEDS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
_FILM_DOTS = 100

Frame = NDArray[np.uint8]


def write_animation(flight: Flight, path: Path | str) -> None:
    """Write an animation of `flight`: planned thin, flown thick.

    Parameters
    ----------
    path
        ``.html`` for a page that works offline, ``.mp4`` or ``.gif`` for a film.

    Raises
    ------
    InputError
        For another suffix, where the file cannot be written, or imageio-ffmpeg is not installed (``.mp4``).
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix in (".html", ".htm"):
        from skyverse.draw.flight_page import flight_page

        write_text(path, flight_page(flight))
    elif suffix == ".mp4":
        _write_mp4(flight, path)
    elif suffix == ".gif":
        _write_gif(flight, path)
    else:
        raise InputError(f"{path}: an animation is written as .html, .mp4 or .gif, not as {suffix or 'no suffix'!r}")


def write_instants(flight: Flight, folder: Path | str, *, suffix: str = ".png") -> list[Path]:
    """Write figures of the initial, middle and final instant, ``flown-initial`` and so on, and return their paths.

    Parameters
    ----------
    folder
        Must exist.
    suffix
        ``".png"``, ``".svg"`` or ``".pdf"``.

    Raises
    ------
    ValueError
        For another suffix.
    InputError
        Where the folder does not exist or a file cannot be written.
    """
    drawn = as_flown(flight)
    shares = (("initial", 0.0), ("middle", 0.5), ("final", 1.0))
    figures = [(f"flown-{name}", partial(instant, drawn, share * flight.mission.makespan)) for name, share in shares]
    return write_stills(figures, folder, suffix)


def instant(drawn: Scene, t: float) -> "Figure":
    """Return the figure of a flight's scene at `t` seconds: as planned thin, as flown until then thick."""
    return moment(drawn, f"flown, t = {t:.1f} s", t, lambda track: track.path, drawn.findings)


def instants(drawn: Scene) -> tuple[list[float], int]:
    """Return the seconds that a film shows, one a frame, and how many times as fast as flown."""
    last = drawn.totals.makespan or 0.0
    speed = next((speed for speed in SPEEDS if last / speed <= LONGEST), SPEEDS[-1])
    count = int(np.ceil(last * FRAMES_A_SECOND / speed - 1e-9)) + 1
    return np.minimum(np.arange(count) * speed / FRAMES_A_SECOND, last).tolist(), speed


def frames(drawn: Scene) -> Iterator[Frame]:
    """Yield a film's frames, (height, width, 3) each, both even: the still map once, what moves drawn onto it."""
    times, speed = instants(drawn)
    fast = "" if speed == 1 else f", {speed} times as fast"
    figure, axes = stage(drawn, f"as planned (thin) and flown (thick){fast}")
    for track in drawn.tracks:
        line(axes, track, track.path, width=0.9, alpha=0.6)
        ends(axes, track)
    legend(figure, drawn)
    figure.set_dpi(_FILM_DOTS)
    figure.set_size_inches(*(2 * np.ceil(size * _FILM_DOTS / 2) / _FILM_DOTS for size in figure.get_size_inches()))
    canvas: Any = figure.canvas
    canvas.draw()
    still = canvas.copy_from_bbox(figure.bbox)
    moving = []
    for track in drawn.tracks:
        line(axes, track, np.array([track.start] * 2), width=2.6)
        trail = axes.lines[-1]
        uav(axes, track, np.array(track.start))
        moving.append((track, trail, axes.lines[-1]))
    below = 1 - 0.52 / figure.get_figheight()  # below the title
    clock = figure.text(0.03, below, "", fontsize=13, color=INK, va="top", family="monospace")
    last = drawn.totals.makespan or 0.0
    for t in times:
        canvas.restore_region(still)
        for track, trail, mark in moving:
            trail.set_data_3d(*track.flown(t).T)
            mark.set_data_3d(*track.at(t)[:, None])
            axes.draw_artist(trail)
        for _, _, mark in moving:
            axes.draw_artist(mark)
        clock.set_text(f"{t:6.2f} s / {last:.2f} s")
        figure.draw_artist(clock)
        yield np.ascontiguousarray(np.asarray(canvas.buffer_rgba())[..., :3])


def _write_mp4(flight: Flight, path: Path) -> None:
    try:
        from imageio_ffmpeg import write_frames
    except ImportError:
        raise InputError('MP4 needs imageio-ffmpeg: pip install "skyverse[flight]"') from None
    film = frames(as_flown(flight))
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


def _write_gif(flight: Flight, path: Path) -> None:
    from PIL import Image

    pictures = [Image.fromarray(frame) for frame in frames(as_flown(flight))]
    both = Image.new("RGB", (pictures[0].width, 2 * pictures[0].height))  # all that is planned, all that is flown
    both.paste(pictures[0], (0, 0))
    both.paste(pictures[-1], (0, pictures[0].height))
    palette = both.quantize(255, method=Image.Quantize.MAXCOVERAGE)  # one for all frames, so that the map keeps still
    first, *others = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    with whole_file(path) as beside:
        first.save(beside, save_all=True, append_images=others, duration=1000 // FRAMES_A_SECOND, loop=0)
