"""What notebooks show of a scenario, a mission, a result and a trajectory: a picture and words."""

import sys
from base64 import b64encode
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skyverse.model.mission import Mission
    from skyverse.model.result import Result
    from skyverse.model.scenario import Scenario
    from skyverse.model.trajectory import Trajectory


def show_in_notebooks() -> None:
    """Tell IPython, where it runs, what to show; matplotlib is imported when the first of them is shown."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None:
        html = shell.display_formatter.formatters["text/html"]
        for name in ("Scenario", "Mission", "Result", "Trajectory"):
            html.for_type_by_name(f"skyverse.model.{name.lower()}", name, as_html)


def as_html(shown: "Scenario | Mission | Result | Trajectory") -> str:
    """Return what a notebook shows: a picture, what the prompt would show, and of a mission its table.

    The picture is a PNG inside the text: it looks the same in every notebook, in what is exported from it, and where
    the notebook is not trusted. The interactive page of `write_html` has plotly inside, and is twenty times as large.
    """
    from skyverse.draw.map_figure import png
    from skyverse.draw.mission_page import flight_table
    from skyverse.draw.plot import plot
    from skyverse.draw.scenes import scene
    from skyverse.model.mission import Mission

    picture = b64encode(png(plot(shown))).decode("ascii")
    parts = [
        f'<img src="data:image/png;base64,{picture}" style="max-width: 100%" alt="{type(shown).__name__}">',
        f"<pre>{escape(repr(shown))}</pre>",
    ]
    if isinstance(shown, Mission):
        parts.append(f'<div style="max-height: 24em; overflow: auto"><table>{flight_table(scene(shown))}</table></div>')
    return "\n".join(parts)
