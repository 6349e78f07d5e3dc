"""Makes the pictures of the documentation anew, in docs/_static, but for that of the peers: python docs/pictures.py.

It needs matplotlib, Playwright, and Chromium as /usr/bin/chromium.
"""

import contextlib
import re
import runpy
import shlex
import tempfile
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright
from relief_picture import mountain

import skyverse as sky
from skyverse.cli import main

HERE = Path(__file__).parent / "_static"
EXAMPLES = Path(__file__).parents[1] / "examples"
WIDTH = 1400
"""Pixels of the pictures at most."""
SWITCHES = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def figure(scenario: sky.Scenario, which: str, name: str) -> None:
    """Draw one of the figures of a scenario's mission, by the planner that is taken where none is named."""
    with tempfile.TemporaryDirectory() as folder:
        sky.write_figures(sky.plan_mission(scenario), Path(folder))
        keep(Path(folder) / f"{which}.png", name)


def page(scenario: sky.Scenario, height: int, name: str) -> None:
    """Photograph the upper part of a mission's page."""
    with tempfile.TemporaryDirectory() as folder:
        sky.write_html(sky.plan_mission(scenario), Path(folder) / "page.html")
        photograph(Path(folder), height, name)


def photograph(folder: Path, height: int, name: str) -> None:
    """Photograph the upper part of page.html in a folder."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=SWITCHES)
        tab = browser.new_page(viewport={"width": WIDTH, "height": height})
        tab.goto((folder / "page.html").as_uri())
        tab.wait_for_selector("body[data-ready]", timeout=120_000)
        tab.wait_for_timeout(3000)
        tab.screenshot(path=folder / "page.png")
        browser.close()
    keep(folder / "page.png", name)


def survey(height: int, page_name: str, profile_name: str) -> None:
    """Photograph the page of the survey of check.md, and draw its profile before and after it is mended."""
    made = re.search(r"^```python\n(.*?)^```", (HERE.parent / "check.md").read_text("utf-8"), re.M | re.S)
    assert made is not None
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        exec(compile(made[1], "check.md", "exec"), {})
        where = sky.BuildOptions("hill", terrain=["dem.tif"], clearance=2, ground_clearance=2, vehicle="camera")
        told = [sky.read_waypoints("survey.plan")]
        with contextlib.suppress(SystemExit):
            main(["check", "survey.plan", "--terrain", "dem.tif", "--vehicle", "camera", "--page", "page.html"])
        photograph(Path(folder), height, page_name)
        drawn, axes = plt.subplots(figsize=(11, 3.6), layout="constrained")
        looks = ("flown before", "#D55E00", "--", 1.5), ("flown now", "#0072B2", "-", 2.0)
        fleets = sky.check_waypoints(told, where), sky.repair_waypoints(told, where).checked
        for fleet, (label, colour, dashes, width) in zip(fleets, looks, strict=True):
            flight, terrain = fleet.missions[0].flown.plan.predicted(), fleet.scenario.terrain
            assert terrain is not None
            assert fleet.scenario.frame.origin is not None
            places = flight.at(np.linspace(flight.start, flight.end, 6000)).position
            along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1)))
            sea = fleet.scenario.frame.origin.altitude
            axes.plot(along, places[:, 2] + sea, dashes, color=colour, lw=width, label=label, zorder=3)
        ground = terrain.height(places[:, :2]) + sea
        axes.fill_between(along, ground, ground.min() - 5, color="#d3c7b4", lw=0, label="ground")
        axes.set(
            xlabel="distance flown (m)", ylabel="m above the sea", xlim=(0, along[-1]), ylim=(ground.min() - 5, None)
        )
        axes.legend(loc="lower right", ncols=3)
        drawn.savefig("profile.png", dpi=120)
        keep(Path("profile.png"), profile_name)


def relief(name: str) -> None:
    """Draw a survey of a mountain, in all colours."""
    drawn = mountain()
    with tempfile.TemporaryDirectory() as folder:
        drawn.savefig(Path(folder) / "figure.png", dpi=200, facecolor=drawn.get_facecolor())
        picture = Image.open(Path(folder) / "figure.png").convert("RGB")
        picture.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
        picture.save(HERE / name, quality=90, optimize=True)


def walk(height: int, name: str) -> None:
    """Photograph the page of the survey of survey.md."""
    text = (HERE.parent / "survey.md").read_text("utf-8")
    made = re.search(r"^```python\n(.*?)^```", text, re.M | re.S)
    command = re.search(r"^\$ skyverse (survey field.kml .*)$", text, re.M)
    assert made is not None
    assert command is not None
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        exec(compile(made[1], "survey.md", "exec"), {})
        with contextlib.suppress(SystemExit):
            main(shlex.split(command[1]))
        Path("field.html").rename("page.html")
        photograph(Path(folder), height, name)


def aeroplane(name: str) -> None:
    """Draw the figure of the example of aeroplanes."""
    mpl.use("agg")
    runpy.run_path(str(EXAMPLES / "9_aeroplane.py"))
    with tempfile.TemporaryDirectory() as folder:
        plt.savefig(Path(folder) / "figure.png", dpi=110)
        keep(Path(folder) / "figure.png", name)


def keep(made: Path, name: str) -> None:
    """Keep a picture, no wider than `WIDTH`, in 256 colours, which is a quarter of its size."""
    picture = Image.open(made).convert("RGB")
    picture.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
    picture.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(HERE / name, optimize=True)


relief("survey.jpg")
walk(1130, "survey-page.png")
figure(sky.read("jacksboro"), "trajectories", "jacksboro.png")
figure(sky.read("table-4.8"), "flight-middle", "table-4.8.png")
figure(sky.random_downtown(), "trajectories", "city.png")
page(sky.read("jacksboro"), 1440, "page.png")
aeroplane("aeroplane.png")
survey(1720, "check.png", "repair.png")
