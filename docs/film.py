"""Makes the film of a UAV that finds its way through moving traffic, and a still of it: python docs/film.py.

With a file as an argument, such as ``traffic.mp4``, ``.gif`` or ``.html``, it writes the film there alone.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import skyverse as sky

HERE = Path(__file__).parent / "_static"
CARTS = (
    (4.5, 26.0, 200.0),
    (8.0, 20.0, 10.0),
    (10.5, 21.0, 30.0),
    (14.5, 21.0, 110.0),
    (17.0, 21.0, 150.0),
    (22.0, 26.0, 220.0),
    (24.5, 26.0, 170.0),
)
"""Of each cart, where it crosses the hall, metres, how long it takes to and fro, seconds, and where in that it begins,
as an angle in degrees."""
WIDTH = 600
"""Pixels of the film."""
SENSOR = sky.Sensor(range=7.0, rate=10.0, delay=0.05, error=0.03)


def hall() -> sky.Scenario:
    """Return a hall with pillars that a UAV crosses, without its traffic."""
    pillars = [(6.0, 3.0), (6.0, 9.0), (13.0, 6.0), (20.0, 3.0), (20.0, 9.0)]
    return sky.Scenario(
        name="A hall with traffic",
        bounds=sky.Bounds(min=(0, 0, 0), max=(28, 12, 4)),
        obstacles=[sky.Cylinder(centre=place, radius=0.5, low=0, high=4) for place in pillars],
        clearance=0.3,
        lattice=sky.Lattice(step=(0.5, 0.5, 0.5), connectivity=26),
        objective=sky.Objective(unit="metres"),
        uavs=[sky.UAV(name="uav", start=(1, 6, 1.5), max_speed=3.0, max_acceleration=3.0)],
        targets=[sky.Target(name="gate", position=(27, 6, 1.5))],
    )


def traffic(scenario: sky.Scenario) -> sky.Scenario:
    """Return what there is besides: carts as high as the hall that go to and fro across it, and an unknown wall."""
    cart = sky.Cylinder(centre=(0, 0), radius=0.5, low=0, high=4)
    movers = []
    for number, (x, period, begin) in enumerate(CARTS, 1):
        turn = np.radians(begin)
        swing = {"cosine": [(0, 4.6 * np.cos(turn), 0)], "sine": [(0, -4.6 * np.sin(turn), 0)]}
        motion = sky.PeriodicMotion(centre=(x, 6, 0), period=period, **swing)
        movers.append(sky.Mover(name=f"cart {number}", shape=cart, motion=motion))
    wall = sky.Box(min=(18.6, 4.8, 0), max=(19.0, 7.4, 4))
    return sky.Scenario(**{**dict(scenario), "movers": movers, "obstacles": [*scenario.obstacles, wall]})


def flight() -> sky.ReplannedFlight:
    """Return the flight."""
    known = hall()
    return sky.fly_replanned(sky.Replanner(sky.plan_mission(known)), traffic(known), SENSOR, rng=1)


def keep(made: sky.ReplannedFlight) -> None:
    """Keep the film at half its rate and size, and its middle as a still."""
    with tempfile.TemporaryDirectory() as folder:
        sky.write_animation(made, Path(folder) / "film.gif")
        sky.write_instants(made, folder)
        with Image.open(Path(folder) / "film.gif") as film:
            frames = []
            for number in range(0, film.n_frames, 2):
                film.seek(number)
                picture = film.convert("RGB")
                frames.append(
                    picture.resize((WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS)
                )
        both = Image.new("RGB", (WIDTH, 2 * frames[0].height))  # early the wall is not seen yet, at the end all else is
        both.paste(frames[len(frames) // 4], (0, 0))
        both.paste(frames[-1], (0, frames[0].height))
        palette = both.quantize(96, method=Image.Quantize.MAXCOVERAGE)
        first, *others = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
        first.save(HERE / "traffic.gif", save_all=True, append_images=others, duration=100, loop=0, optimize=True)
        picture = Image.open(Path(folder) / "flown-middle.png").convert("RGB")
        picture.thumbnail((1400, 1400), Image.Resampling.LANCZOS)
        picture.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
            HERE / "traffic.png", optimize=True
        )


if __name__ == "__main__":
    if len(sys.argv) > 1:
        sky.write_animation(flight(), sys.argv[1])
    else:
        keep(flight())
