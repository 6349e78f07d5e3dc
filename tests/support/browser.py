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
