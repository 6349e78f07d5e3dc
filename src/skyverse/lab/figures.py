"""Figures of a study from plain data: one palette, one size of type, the same bytes from the same data."""

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 160

_STYLE: Any = {
    "axes.axisbelow": True,
    "axes.edgecolor": "#5b6776",
    "axes.grid": True,
    "axes.labelcolor": "#17202b",
    "axes.labelsize": 10,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10.5,
    "font.size": 9.5,
    "grid.color": "#e3e8ee",
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "svg.hashsalt": "skyverse",
    "text.color": "#17202b",
    "xtick.color": "#5b6776",
    "ytick.color": "#5b6776",
}
_UNDATED: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None}}


@contextmanager
def style() -> Iterator[None]:
    """Draw as all figures of the laboratory are drawn, whatever the user's matplotlibrc says."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


def image(figure: "Figure", suffix: str) -> bytes:
    """Return `figure` as the bytes of an ``"svg"``, ``"png"`` or ``"pdf"`` file without a date."""
    file = BytesIO()
    figure.savefig(file, format=suffix, dpi=DOTS_PER_INCH, facecolor="white", metadata=_UNDATED[suffix])
    return file.getvalue()
