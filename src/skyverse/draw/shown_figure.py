"""A figure that needs no display, and that notebooks show."""

from io import BytesIO
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure that a notebook shows also where nothing has imported ``matplotlib.pyplot``, which would keep it."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        return png(self)


def png(figure: Figure) -> bytes:
    """Return a figure as the bytes of a PNG file, as large as notebooks show it."""
    file = BytesIO()
    figure.savefig(file, format="png", facecolor="white")
    return file.getvalue()
