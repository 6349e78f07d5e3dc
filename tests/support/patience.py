"""How long tests wait for others: only what never comes fails, however busy the machine is. No other file waits."""

import asyncio
import time

PATIENCE_S = 600.0


def wait_until(condition, process=None):
    """Wait until a condition holds, and return what it returned; fail if the process ends and it still does not."""
    end = time.monotonic() + PATIENCE_S
    while True:
        ended = process is not None and process.poll() is not None
        if found := condition():
            return found
        if ended or time.monotonic() > end:
            raise AssertionError(f"it never came: {process.communicate() if ended else 'time is over'}")
        time.sleep(0.01)


async def come(condition):
    """Wait until a condition holds, while other tasks go on."""
    async with asyncio.timeout(PATIENCE_S):
        while not condition():
            await asyncio.sleep(0.01)
