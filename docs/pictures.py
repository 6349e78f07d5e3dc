"""Makes the pictures of the documentation anew, in docs/_static, but for that of the peers: python docs/pictures.py.

It needs matplotlib, Playwright, and Chromium as /usr/bin/chromium.
"""

import runpy
import tempfile
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
from PIL import Image
from playwright.sync_api import sync_playwright

import skyverse as sky

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
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        sky.write_html(sky.plan_mission(scenario), Path(folder) / "page.html")
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=SWITCHES)
        tab = browser.new_page(viewport={"width": WIDTH, "height": height})
        tab.goto((Path(folder) / "page.html").as_uri())
        tab.wait_for_selector("body[data-ready]", timeout=120_000)
        tab.wait_for_timeout(3000)
        tab.screenshot(path=Path(folder) / "page.png")
        browser.close()
        keep(Path(folder) / "page.png", name)


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


figure(sky.read("jacksboro"), "trajectories", "jacksboro.png")
figure(sky.read("table-4.8"), "flight-middle", "table-4.8.png")
figure(sky.random_downtown(), "trajectories", "city.png")
page(sky.read("jacksboro"), 1440, "page.png")
aeroplane("aeroplane.png")
