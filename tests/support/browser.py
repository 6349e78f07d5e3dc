"""Pages opened in a browser, and waiting for what they show."""

import time
from contextlib import contextmanager

import pytest

from patience import PATIENCE_S


@contextmanager
def new_tab(browser, width=1000, height=700):
    """A tab, with a session of its own, that notes errors and requests."""
    tab = browser.new_page(viewport={"width": width, "height": height})
    tab.errors, tab.requests = [], []
    tab.on("console", lambda said: tab.errors.append(said.text) if said.type == "error" else None)
    tab.on("pageerror", lambda error: tab.errors.append(str(error)))
    tab.on("request", lambda request: tab.requests.append(request.url))
    yield tab
    tab.close()


def opened(tab, page):
    """Open the file of a page, and wait until it is drawn."""
    tab.set_default_timeout(1000 * PATIENCE_S)
    tab.goto(page.as_uri())
    tab.wait_for_selector("body[data-ready]")


def until(tab, expression, holds=bool):
    """Wait until what an expression gives is as it should be, and return it.

    Playwright's own waiting needs eval, which the page's policy forbids.
    """
    end = time.monotonic() + PATIENCE_S
    while not holds(found := tab.evaluate(expression)):
        if time.monotonic() > end:
            pytest.fail(f"{expression} did not come true; it is {found}")
        tab.wait_for_timeout(20)
    return found


SIZES = (1400, 900), (390, 844)
"""Pixels of a screen on a desk, and of a phone."""
MISFITS = """() => {
  const wrong = [];
  const said = (what, { tagName, id, className, textContent }) =>
    wrong.push(`${what}: ${tagName} ${id || className}: ${textContent.slice(0, 40)}`);
  for (const one of document.querySelectorAll("body *:not(select, option, input, button, output)")) {
    if (one.closest(".js-plotly-plot, svg, nav") || !one.checkVisibility()) continue;
    const { overflowX, overflowY } = getComputedStyle(one);
    if (overflowY !== "visible" && one.scrollHeight > one.clientHeight + 1) said("hidden below", one);
    if (overflowX !== "visible" && one.scrollWidth > one.clientWidth + 1) said("hidden beside", one);
    if (one.matches(".pill") && one.getClientRects().length > 1) said("a broken word", one);
    if (one.getBoundingClientRect().right > innerWidth + 1) said("too wide", one);
  }
  if (document.documentElement.scrollWidth > innerWidth) wrong.push("the page scrolls sideways");
  return wrong;
}"""
FIRST_SCREEN = """() => {
  const all = (which) => [...document.querySelectorAll(which)].filter((one) => one.childNodes.length);
  const top = (one) => one.getBoundingClientRect().top, [banner] = all(".banner");
  return {
    verdicts: all(".banner .verdict").length,
    above: all(".tiles, .card, #told").filter((one) => one.checkVisibility() && top(one) < top(banner)).length,
    picture: Math.min(...all("#surveyed, #space").map(top)) < innerHeight,
    both: all(".verdict.good").length > 0 && all(".verdict.bad, .pill.bad").length > 0,
  };
}"""


def fits(tab, page):
    """Assert that a page says its verdict first, then shows its picture, and cuts nothing, on a desk and a phone."""
    opened(tab, page)
    for width, height in SIZES:
        tab.set_viewport_size({"width": width, "height": height})
        tab.evaluate("scrollTo(0, 0)")
        until(tab, MISFITS, lambda found: found == [])  # once the pictures have taken their new size
        assert tab.evaluate(FIRST_SCREEN) == {"verdicts": 1, "above": 0, "picture": True, "both": False}
