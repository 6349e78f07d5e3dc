"""The way from what the model holds to its pictures."""

from importlib import import_module
from typing import Any


def drawing() -> Any:
    """Return the module that draws what the model holds.

    It belongs to a layer above this one, and loads matplotlib: it is asked for by name, here alone, and only when
    somebody wants a picture.
    """
    return import_module("skyverse.draw.at_prompt")


class Drawn:
    """The base of what notebooks show with a picture; ``plot`` returns the picture alone, as a figure."""

    def _repr_html_(self) -> str:
        html: str = drawing().as_html(self)
        return html
