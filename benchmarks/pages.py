"""The cost of a redraw when a page's scene is turned or played: ``python benchmarks/pages.py FOLDER``.

FOLDER contains ``davosdorf.tif`` (ethz-asl/terrain-navigation). Pages are written to a temporary folder and opened in a
headless Chromium that draws on the processor (SwiftShader), 1400 by 1000 pixels. This is an upper bound, since nearly
all users have a graphics card. "script" is a redraw without any drawing commands, which is what remains with such a
card. Frames a second are counted while the mouse turns the scene, or while the mission is played, after the page has
had time to choose a level of detail. Needs the ``maps`` and ``test`` extras, and Chromium.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from machine import describe, table

import skyverse as sky
from maps import DAVOS, DAVOS_TARGETS, built, city, peopled

SWITCHES = """--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
    --use-angle=swiftshader --enable-unsafe-swiftshader"""
REDRAWS = 40
SECONDS = 4.0

# Turn the camera about z and redraw, waiting for the last pixel; again without any drawing, counting what is left out.
REDRAW = """(times) => {
  const host = document.getElementById("space"), scene = internals.space(host);
  const { glplot } = scene, { gl } = glplot;
  const pixel = new Uint8Array(4), median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  const turn = () => {
    const { eye, center } = scene.getCamera(), [x, y] = [eye.x - center.x, eye.y - center.y];
    const [cos, sin] = [Math.cos(0.02), Math.sin(0.02)];
    const turned = [center.x + x * cos - y * sin, center.y + x * sin + y * cos, eye.z];
    scene.camera.lookAt(turned, [center.x, center.y, center.z], [0, 0, 1]);
  };
  const redraws = (count) => median(Array.from({ length: count }, () => {
    turn();
    const began = performance.now();
    glplot.redraw();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return performance.now() - began;
  }));
  const all = redraws(3), drawn = { calls: 0, triangles: 0 };
  const count = (mode, corners) => {
    drawn.calls += 1;
    drawn.triangles += mode === gl.TRIANGLES ? corners / 3 : mode === gl.TRIANGLE_STRIP ? corners - 2 : 0;
  };
  gl.drawArrays = (mode, first, corners) => count(mode, corners);
  gl.drawElements = count;
  gl.readPixels = gl.clear = () => {};
  redraws(1);
  const { calls, triangles } = drawn, script = redraws(times);
  for (const name of ["drawArrays", "drawElements", "readPixels", "clear"]) delete gl[name];
  return { traces: host._fullData.length, all, script, calls, triangles };
}"""
# Move through the flight without any drawing, one frame after the other.
PLAY = """async (times) => {
  const { gl } = internals.space(document.getElementById("space")).glplot;
  const slider = document.getElementById("time");
  gl.drawArrays = gl.drawElements = gl.readPixels = gl.clear = () => {};
  const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  for (let k = 0; k < times; k++) {
    slider.value = (k + 1) * slider.max / times;
    slider.dispatchEvent(new Event("input"));
    await frame();
  }
  for (const name of ["drawArrays", "drawElements", "readPixels", "clear"]) delete gl[name];
}"""
COUNT = """() => {
  const { glplot } = internals.space(document.getElementById("space")), own = glplot.onrender;
  window.drawn = 0;
  glplot.onrender = () => { window.drawn += 1; own(); };
}"""


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    options = parser.parse_args()
    from playwright.sync_api import sync_playwright

    rows = []
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.chromium, args=SWITCHES.split())
        print(describe("plotly", "playwright"), f"Chromium {browser.version}", sep="; ", end="\n\n")
        for name, scenario in scenarios(options.folder, Path(scratch)).items():
            page = Path(scratch) / "page.html"
            sky.write_html(sky.plan_mission(scenario, sky.Taut(), rng=1), page)
            rows.append([name, f"{page.stat().st_size / 1e6:.1f}", *looked_at(browser, page)])
        browser.close()
    head = ["page", "MB", "traces", "draw calls", "triangles drawn", "script, turned", "script, moved", "redraw in all"]
    table([*head, "frames/s, turned", "frames/s, played"], rows)
    return 0


def scenarios(folder: Path, scratch: Path) -> dict[str, sky.Scenario]:
    """Return what is drawn, by name."""
    davos = ["--terrain", str(folder / "davosdorf.tif"), "--clearance", "10", "--ground-clearance", "30"]
    davos += [word for place in DAVOS for word in ("--uav", f"{place[0]},{place[1]},60 m agl")]
    davos += [word for place in DAVOS_TARGETS for word in ("--target", f"{place[0]},{place[1]},60 m agl")]
    built(davos, scratch / "davos.json")
    built(city(scratch, 2000, side=3000.0), scratch / "town.json")
    return {
        "Davos": sky.read_scenario(scratch / "davos.json"),
        "Jacksboro": sky.read_scenario("jacksboro"),
        "2,000 footprints on hills": peopled(sky.read_scenario(scratch / "town.json")),
        "2,000 boxes": sky.random_city(2000, uavs=5),
    }


def looked_at(browser: Any, page: Path) -> list[str]:
    """Open, redraw, turn and play; return a row."""
    tab = browser.new_page(viewport={"width": 1400, "height": 1000})
    tab.set_default_timeout(300_000)
    tab.goto(page.as_uri())
    tab.wait_for_selector("body[data-ready]")
    tab.wait_for_timeout(1000)
    seen = tab.evaluate(REDRAW, REDRAWS)
    meter = tab.context.new_cdp_session(tab)
    meter.send("Performance.enable")
    before = scripted(meter)
    tab.evaluate(PLAY, REDRAWS)
    moved = 1000 * (scripted(meter) - before) / REDRAWS
    tab.evaluate(COUNT)
    turned = turning(tab)
    tab.get_by_role("button", name="Play").click()
    played = rate(tab, lambda: tab.wait_for_timeout(50))
    tab.close()
    times = [f"{seen['script']:.1f} ms", f"{moved:.1f} ms", f"{seen['all']:.0f} ms"]
    counts = [str(seen["traces"]), str(seen["calls"]), f"{seen['triangles']:,.0f}"]
    return [*counts, *times, f"{turned:.1f}", f"{played:.1f}"]


def scripted(meter: Any) -> float:
    """Return the seconds that the page's script has taken so far."""
    return next(m["value"] for m in meter.send("Performance.getMetrics")["metrics"] if m["name"] == "ScriptDuration")


def turning(tab: Any) -> float:
    """Turn the picture with the mouse; return how many frames a second that gives."""
    box = tab.locator("#space").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.mouse.move(x, y)
    tab.mouse.down()
    step = iter(range(10**6))
    frames = rate(tab, lambda: tab.mouse.move(x + next(step) % 300, y))
    tab.mouse.up()
    tab.wait_for_timeout(1000)
    return frames


def rate(tab: Any, act: Any) -> float:
    """Return the frames drawn a second while something is done over and over, after as long a time to settle."""
    for seconds in (2 * SECONDS, SECONDS):
        began, before = time.perf_counter(), tab.evaluate("window.drawn")
        while time.perf_counter() - began < seconds:
            act()
        passed, drawn = time.perf_counter() - began, tab.evaluate("window.drawn") - before
    return drawn / passed


if __name__ == "__main__":
    sys.exit(main())
